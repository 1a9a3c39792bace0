// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/pbd/typed_block.h"

#include "support/catch.h"
#include "support/targets.h"
#include "tandem/pbd/corrections.h"
#include "tandem/pbd/math.h"

namespace typed_block_test {

using namespace tandem::pbd;
using namespace tandem::testing;

namespace {

/// A kind of constraint that the solver has never heard of: holds a body's height and orientation.
/// C = (z - height, rotation vector from the wanted orientation) [m, rad].
class Shelf {
 public:
  static constexpr std::string_view kName = "shelf";
  static constexpr int kOrder = static_cast<int>(SolveOrder::Joint) + 1;
  struct Def {
    BodyId body;
    double height = 0.0;  ///< m
  };
  static void check(const World& world, const Def& def) {
    detail::require_body(world, def.body, kName, "body");
    detail::require(std::isfinite(def.height), kName, "height", def.height, "finite");
  }
  explicit Shelf(const Def& def) : def_(def) {}
  const Def& def() const { return def_; }
  Def& def() { return def_; }
  BodyId body_a() const { return {}; }
  BodyId body_b() const { return def_.body; }

  double project(const SubstepContext& ctx) {
    SolverBody& body = ctx.bodies[def_.body.index];
    const double c = body.x.z() - def_.height;
    const Vec3 tilt = log_map(body.q);
    apply_correction(body, Vec3(0.0, 0.0, -c / body.inv_mass),
                     -body.inv_inertia_w.inverse() * tilt);
    residual_ = std::abs(c);
    return std::abs(c) + tilt.norm();
  }
  double project_displacement(const SubstepContext& ctx) { return project(ctx); }
  double residual() const { return residual_; }
  double displacement_residual() const { return 0.0; }
  void save(ByteWriter& out) const {
    out.u32(def_.body.index);
    out.u32(def_.body.generation);
    out.f64(def_.height);
  }
  void load(ByteReader& in) {
    def_.body.index = in.u32();
    def_.body.generation = in.u32();
    def_.height = in.f64();
  }

 private:
  Def def_;
  double residual_ = 0.0;
};
using Shelves = TypedBlock<Shelf>;

/// Writes down every verb that it is told.
class Recorder final : public ConstraintBlock {
 public:
  Recorder(std::string name, int order, std::vector<std::string>* log)
      : name_(std::move(name)), order_(order), log_(log) {}
  std::string_view name() const override { return name_; }
  int order() const override { return order_; }
  bool empty() const override { return false; }
  void begin_step(const SubstepContext&) override { note("begin_step"); }
  void begin_substep(const SubstepContext&) override { note("begin_substep"); }
  void warm_start(const SubstepContext&) override { note("warm_start"); }
  double project(const SubstepContext&) override {
    note("project");
    return 0.0;
  }
  double solve_velocity(const SubstepContext&) override {
    note("solve_velocity");
    return 0.0;
  }
  void finish_velocity(const SubstepContext&) override { note("finish_velocity"); }
  void begin_displacement(const SubstepContext&) override { note("begin_displacement"); }
  double project_displacement(const SubstepContext&) override {
    note("project_displacement");
    return 0.0;
  }
  void end_displacement(const SubstepContext&) override { note("end_displacement"); }
  void end_step(const SubstepContext&, std::span<double>) override { note("end_step"); }
  BlockReport report() const override { return {.name = name_, .rows = 1}; }
  void save(ByteWriter&) const override {}
  void load(ByteReader&) override {}

 private:
  void note(const char* verb) { log_->push_back(name_ + " " + verb); }
  std::string name_;
  int order_;
  std::vector<std::string>* log_;
};

using Log = std::vector<std::string>;

/// The same verb of both blocks, in solve order.
void expect(Log& log, const char* verb, int times = 1) {
  for (int i = 0; i < times; ++i) {
    log.push_back(std::string("soft ") + verb);
    log.push_back(std::string("hard ") + verb);
  }
}

}  // namespace

TEST_CASE("typed_block: a kind of constraint defined in a test is solved like any other",
          "[pbd][unit]") {
  World world;
  auto& shelves = world.add_block<Shelves>();
  BodyDef def = box_def(1.0, Vec3(0.1, 0.2, 0.3), Vec3(0.0, 0.0, 1.0));
  def.twist = {Vec3(0.7, 0.0, 0.0), Vec3(0.0, 0.0, 4.0)};
  const BodyId body = world.add_body(def);
  shelves.add(world, {.body = body, .height = 1.25});
  Solver solver;
  const StepReport& report = solver.step(world, kFrame);
  REQUIRE(report.blocks.size() == 1);
  CHECK(report.blocks[0].name == "shelf");
  CHECK(report.blocks[0].rows == 1);
  run(world, solver, 1.0 - kFrame);
  CHECK(std::abs(world.pose(body).position.z() - 1.25) < 1e-12);
  CHECK(angle_between(world.pose(body).orientation, Quat::Identity()) < 1e-9);
  CHECK(std::abs(world.pose(body).position.x() - 0.7) < 1e-12);  // what it leaves free is free
  CHECK(world.twist(body).angular.norm() < 1e-9);
}

TEST_CASE("typed_block: a new kind takes part in the displacement channel and in snapshots",
          "[pbd][consensus][unit]") {
  const auto build = [](World& world, FixedTargets& source) -> BodyId {
    auto& shelves = world.add_block<Shelves>();
    const BodyId body = world.add_body(box_def(1.0, Vec3(0.1, 0.2, 0.3), Vec3(0.0, 0.0, 1.0)));
    shelves.add(world, {.body = body, .height = 1.0});
    source.targets.push_back(
        {.body = body, .pose = {Vec3(1.0, 0.0, 3.0), turn(Vec3(0.5, 0.0, 0.0))}, .share = 0.2});
    world.set_target_source(&source);
    return body;
  };
  World world;
  FixedTargets source;
  const BodyId body = build(world, source);
  Solver solver;
  run(world, solver, 1.0);
  CHECK(std::abs(world.pose(body).position.x() - 1.0) < 1e-3);
  CHECK(std::abs(world.pose(body).position.z() - 1.0) < 1e-9);
  CHECK(angle_between(world.pose(body).orientation, Quat::Identity()) < 1e-9);

  World other;
  FixedTargets other_source;
  build(other, other_source);
  other.restore(world.snapshot());
  run(world, solver, 0.5);
  run(other, solver, 0.5);
  CHECK(world.hash() == other.hash());
}

TEST_CASE("typed_block: ids of removed rows stay dead when their slot is used again",
          "[pbd][unit]") {
  World world;
  Shelves shelves;
  const BodyId body = world.add_body({});
  const ConstraintId first = shelves.add(world, {.body = body, .height = 1.0});
  const ConstraintId second = shelves.add(world, {.body = body, .height = 2.0});
  shelves.remove(first);
  CHECK(shelves.size() == 1);
  CHECK_FALSE(shelves.contains(first));
  const ConstraintId third = shelves.add(world, {.body = body, .height = 3.0});
  CHECK(third.index == first.index);
  CHECK(third != first);
  CHECK(shelves.def(third).height == 3.0);
  CHECK(shelves.def(second).height == 2.0);
  for (const ConstraintId id : {first, ConstraintId{}, ConstraintId{57, 0}}) {
    const std::string value = "id " + std::to_string(id.index);
    CHECK(names(refusal([&] { shelves.remove(id); }), "shelf", value, "names no constraint"));
    CHECK(names(refusal([&] { (void)shelves.at(id); }), "shelf", value, "names no constraint"));
    CHECK(names(refusal([&] { shelves.set(world, id, {.body = body}); }), "shelf", value,
                "names no constraint"));
  }
  CHECK(shelves.size() == 2);
}

TEST_CASE("typed_block: a change that breaks a rule leaves the row as it was", "[pbd][fault]") {
  World world;
  Shelves shelves;
  const BodyId body = world.add_body({});
  const ConstraintId id = shelves.add(world, {.body = body, .height = 1.0});
  const double nan = std::nan("");
  CHECK(names(refusal([&] { shelves.set(world, id, {.body = body, .height = nan}); }),
              "shelf: height", "nan", "finite"));
  CHECK(shelves.def(id).height == 1.0);
  shelves.set(world, id, {.body = body, .height = 4.0});
  CHECK(shelves.def(id).height == 4.0);
}

TEST_CASE("typed_block: removed rows and bodies are no longer solved", "[pbd][unit]") {
  World world;
  auto& shelves = world.add_block<Shelves>();
  const BodyId a = world.add_body({});
  const BodyId b = world.add_body({});
  const ConstraintId on_a = shelves.add(world, {.body = a});
  const ConstraintId on_b = shelves.add(world, {.body = b});
  shelves.remove(on_a);
  Solver solver;
  CHECK(solver.step(world, kFrame).blocks[0].rows == 1);
  CHECK(world.pose(a).position.z() < 0.0);
  CHECK(world.pose(b).position.z() == 0.0);
  world.remove_body(b);
  CHECK_FALSE(shelves.contains(on_b));
  CHECK(shelves.empty());
  CHECK(solver.step(world, kFrame).blocks.empty());
}

TEST_CASE("typed_block: the stages of a step run in their documented order", "[pbd][unit]") {
  Log log;
  World world;
  FixedTargets source;
  // Added the other way round: the order is that of solving.
  world.add_block<Recorder>("hard", static_cast<int>(SolveOrder::Contact), &log);
  world.add_block<Recorder>("soft", static_cast<int>(SolveOrder::Compliant), &log);
  const BodyId body = world.add_body({});
  source.targets.push_back({.body = body, .pose = world.pose(body), .share = 0.1});

  const bool shared = GENERATE(false, true);
  CAPTURE(shared);
  if (shared) world.set_target_source(&source);
  Solver solver({.substeps = 3, .position_iterations = 2});
  solver.step(world, kFrame);
  Log expected;
  expect(expected, "begin_step");
  for (int i = 0; i < 3; ++i) {
    expect(expected, "begin_substep");
    expect(expected, "warm_start");
    expect(expected, "project", 2);
    expect(expected, "solve_velocity");
    expect(expected, "finish_velocity");
    if (!shared) continue;
    expect(expected, "begin_displacement");
    expect(expected, "project_displacement");  // what projects poses comes first
    expect(expected, "end_displacement");
  }
  expect(expected, "end_step");
  CHECK(log == expected);
}

TEST_CASE("typed_block: a row keeps its bodies", "[pbd][fault]") {
  World world;
  auto& shelves = world.add_block<TypedBlock<Shelf>>();
  const BodyId body = world.add_body({});
  const BodyId other = world.add_body({});
  const ConstraintId id = shelves.add(world, {.body = body, .height = 1.0});
  CHECK(names(refusal([&] { shelves.set(world, id, {.body = other, .height = 2.0}); }), "shelf",
              std::to_string(other.index), "one that the row was added with"));
  CHECK(shelves.def(id).body == body);
  CHECK(shelves.def(id).height == 1.0);
}

}  // namespace typed_block_test
