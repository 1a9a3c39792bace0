// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/pbd/solver.h"

#include <algorithm>
#include <functional>
#include <limits>

#include "support/catch.h"
#include "support/targets.h"
#include "support/toy_contacts.h"
#include "tandem/pbd/distance_joint.h"
#include "tandem/pbd/joint.h"

namespace solver_test {

using namespace tandem::pbd;
using namespace tandem::testing;

namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();
const Vec3 kHalf(0.5, 0.5, 0.5);

/// Spoils one body in the middle of the pass of one step, as an overflow would.
class Spoiler final : public ConstraintBlock {
 public:
  explicit Spoiler(std::uint32_t body) : body_(body) {}
  void arm() { armed_ = true; }
  std::string_view name() const override { return "spoiler"; }
  int order() const override { return static_cast<int>(SolveOrder::Compliant) - 1; }
  bool empty() const override { return false; }
  double project(const SubstepContext& ctx) override {
    if (armed_) ctx.bodies[body_].x.x() = kNan;
    return 0.0;
  }
  void end_step(const SubstepContext&, std::span<double>) override { armed_ = false; }
  BlockReport report() const override { return {.name = name()}; }
  void save(ByteWriter&) const override {}
  void load(ByteReader&) override {}

 private:
  std::uint32_t body_;
  bool armed_ = false;
};

}  // namespace

TEST_CASE("solver: options out of range are refused naming field, value and rule", "[pbd][fault]") {
  struct Case {
    const char* field;
    const char* value;
    std::function<void(SolverOptions&)> spoil;
  };
  const std::vector<Case> cases{
      {"substeps", "is 0", [](SolverOptions& o) { o.substeps = 0; }},
      {"substeps", "is 1001", [](SolverOptions& o) { o.substeps = 1001; }},
      {"position_iterations", "is 0", [](SolverOptions& o) { o.position_iterations = 0; }},
      {"joint_iterations", "is -1", [](SolverOptions& o) { o.joint_iterations = -1; }},
      {"joint_tolerance", "nan", [](SolverOptions& o) { o.joint_tolerance = kNan; }},
      {"velocity_iterations", "is -1", [](SolverOptions& o) { o.velocity_iterations = -1; }},
      {"velocity_tolerance", "-0.5", [](SolverOptions& o) { o.velocity_tolerance = -0.5; }},
      {"contact.push_speed", "inf", [](SolverOptions& o) { o.contact.push_speed = kInf; }},
      {"contact.extra_sweeps", "is -1", [](SolverOptions& o) { o.contact.extra_sweeps = -1; }},
      {"contact.resting_tolerance", "is -1",
       [](SolverOptions& o) { o.contact.resting_tolerance = -1.0; }},
      {"contact.warm_start_gap", "nan", [](SolverOptions& o) { o.contact.warm_start_gap = kNan; }},
      {"contact.restitution_threshold", "is -1",
       [](SolverOptions& o) { o.contact.restitution_threshold = -1.0; }},
  };
  for (const Case& c : cases) {
    SolverOptions options;
    REQUIRE(options.validate());
    c.spoil(options);
    std::string error;
    CHECK_FALSE(options.validate(&error));
    CHECK_FALSE(options.validate());
    INFO("\"" << error << "\"");
    CHECK(names(error, std::string("SolverOptions: ") + c.field + " must be", c.value, "from"));
    CHECK(refusal([&] { Solver solver(options); }) == error);
  }
}

TEST_CASE("solver: a step that is not a positive number leaves the world as it is",
          "[pbd][fault]") {
  World world;
  world.add_body({.twist = {Vec3(1.0, 0.0, 0.0), Vec3::Zero()}});
  const auto before = world.snapshot();
  Solver solver;
  for (const double dt : {0.0, -0.01, 1e-12, 9e-6, kNan, kInf, -kInf}) {
    const StepReport& report = solver.step(world, dt);
    CHECK(report.substeps == 0);
    CHECK(report.status == StepStatus::InvalidStep);
    CHECK(world.snapshot() == before);
  }
}

TEST_CASE("solver: free fall and free flight are those of semi-implicit Euler", "[pbd][analytic]") {
  World world({.gravity = Vec3(1.0, 0.0, -9.81)});
  BodyDef def;
  def.twist.linear = Vec3(2.0, 3.0, 4.0);
  def.gravity_scale = 0.5;
  const BodyId body = world.add_body(def);
  const BodyId cart = world.add_body(
      {.type = BodyType::Kinematic, .twist = {Vec3(1.0, 0.0, 0.0), Vec3(0.0, 0.0, 2.0)}});
  Solver solver({.substeps = 10});
  run(world, solver, 1.0);
  const double h = kFrame / 10.0;
  const Vec3 g = 0.5 * Vec3(1.0, 0.0, -9.81);
  CHECK((world.pose(body).position - (Vec3(2.0, 3.0, 4.0) + 0.5 * g * (1.0 + h))).norm() < 1e-12);
  CHECK((world.twist(body).linear - (Vec3(2.0, 3.0, 4.0) + g)).norm() < 1e-12);
  CHECK((world.pose(cart).position - Vec3(1.0, 0.0, 0.0)).norm() < 1e-12);
  CHECK(angle_between(world.pose(cart).orientation, turn(Vec3(0.0, 0.0, 2.0))) < 1e-12);
  CHECK(world.time() == Approx(1.0).epsilon(1e-12));
}

TEST_CASE("solver: a free body's spin keeps energy and angular momentum, flips included",
          "[pbd][analytic]") {
  World world(weightless());
  BodyDef def = box_def(1.0, Vec3(0.1, 0.2, 0.3), Vec3::Zero());
  def.twist.angular = Vec3(0.01, 20.0, 0.01);  // about the middle axis: it tumbles
  const BodyId body = world.add_body(def);
  const Vec3 momentum = angular_momentum(world);
  const double energy = world.kinetic_energy();
  Solver solver;
  double lowest = 20.0;
  run(world, solver, 10.0, [&] {
    const Vec3 w_l = world.pose(body).orientation.conjugate() * world.twist(body).angular;
    lowest = std::min(lowest, w_l.y());
  });
  CHECK(lowest < -15.0);  // it did flip
  CHECK(world.kinetic_energy() == Approx(energy).epsilon(1e-6));
  CHECK((angular_momentum(world) - momentum).norm() < 0.01 * momentum.norm());
}

TEST_CASE("solver: bodies that leave the numbers are named, put back and stopped", "[pbd][fault]") {
  struct Case {
    Vec3 v, w;
  };
  for (const Case& c :
       {Case{Vec3(1e308, 0.0, 0.0), Vec3::Zero()}, Case{Vec3::Zero(), Vec3(0.0, 1e200, 0.0)}}) {
    World world;
    const BodyId good = world.add_body({});
    BodyDef def = box_def(1.0, Vec3(0.1, 0.2, 0.3), Vec3(3.0, 4.0, 5.0));
    def.twist = {c.v, c.w};
    const BodyId bad = world.add_body(def);
    def.pose.position.x() = 30.0;
    world.add_body(def);  // bad too, but later
    Solver solver;
    const StepReport& report = solver.step(world, 10.0);
    CHECK(report.status == StepStatus::NonFinite);
    CHECK(report.first_bad_body == bad);
    CHECK(world.pose(bad).position == Vec3(3.0, 4.0, 5.0));
    CHECK(world.twist(bad).linear.norm() == 0.0);
    CHECK(world.twist(bad).angular.norm() == 0.0);
    CHECK(world.twist(good).linear.z() == Approx(-98.1).epsilon(1e-12));
    CHECK(solver.step(world, kFrame).status == StepStatus::Ok);
    CHECK_FALSE(report.first_bad_body.valid());
    CHECK(world.twist(bad).linear.z() == Approx(-kGravity * kFrame).epsilon(1e-12));
  }
}

TEST_CASE("solver: a world recovers from a step that spoiled its joints and contacts",
          "[pbd][fault]") {
  for (const bool with_target : {false, true}) {
    World world;
    ToyContacts contacts;
    FixedTargets source;
    world.set_contact_source(&contacts);
    auto& balls = world.add_block<JointBlock>();
    auto& rods = world.add_block<DistanceJoints>();
    const BodyId ground = add_ground(world);
    const BodyId a = world.add_body(box_def(1.0, kHalf, Vec3(0.0, 0.0, 0.5)));
    const BodyId b = world.add_body(box_def(1.0, kHalf, Vec3(1.0, 0.0, 0.5)));
    const BodyId c = world.add_body(box_def(1.0, kHalf, Vec3(3.0, 0.0, 0.5)));
    for (const BodyId id : {a, b, c}) {
      contacts.box_on_plane(ground, Vec3::UnitZ(), 0.0, id, kHalf, {});
    }
    balls.add(world, ball_joint_at(world, a, b, Vec3(0.5, 0.0, 0.8)));
    rods.add(world, {.a = b, .b = c, .rest_length = 2.0});
    source.targets.push_back({.body = a, .pose = world.pose(a), .share = 0.3});
    if (with_target) world.set_target_source(&source);
    auto& spoiler = world.add_block<Spoiler>(a.index);
    Solver solver;
    run(world, solver, 0.5);
    spoiler.arm();
    CHECK(solver.step(world, kFrame).status == StepStatus::NonFinite);
    for (const BodyId id : {a, b, c}) {
      REQUIRE(world.pose(id).position.allFinite());
      REQUIRE(world.twist(id).linear.allFinite());
    }
    for (int k = 0; k < 120; ++k) REQUIRE(solver.step(world, kFrame).status == StepStatus::Ok);
    INFO("with target: " << with_target);
    CHECK(std::abs(world.pose(a).position.z() - 0.5) < 1e-3);
    CHECK(world.twist(a).linear.norm() < 1e-3);
    CHECK((world.pose(b).position - world.pose(a).position).norm() == Approx(1.0).margin(1e-3));
  }
}

TEST_CASE("solver: the report counts rows, bodies and stages", "[pbd][unit]") {
  World world;
  ToyContacts contacts;
  world.set_contact_source(&contacts);
  auto& balls = world.add_block<JointBlock>();
  world.add_block<DistanceJoints>();  // stays empty
  const BodyId ground = add_ground(world);
  const BodyId box = world.add_body(box_def(1.0, kHalf, Vec3(0.0, 0.0, 0.4)));
  const BodyId other = world.add_body(box_def(1.0, kHalf, Vec3(3.0, 0.0, 3.0)));
  contacts.box_on_plane(ground, Vec3::UnitZ(), 0.0, box, kHalf, {});
  balls.add(world, ball_joint_at(world, {}, other, Vec3(3.0, 0.0, 3.0)));
  balls.add(world, ball_joint_at(world, {}, other, Vec3(3.0, 0.0, 3.2)));
  Solver solver({.substeps = 7});
  const StepReport& report = solver.step(world, kFrame);
  CHECK(report.substeps == 7);
  CHECK(report.bodies == 3);
  CHECK(report.targets == 0);
  CHECK(report.velocity_iterations >= 7);
  CHECK(report.velocity_iterations <= 7 * solver.options().velocity_iterations);
  REQUIRE(report.blocks.size() == 2);
  CHECK(report.blocks[0].name == "joint");
  CHECK(report.blocks[0].rows == 2);
  CHECK(report.blocks[1].name == "contact");
  CHECK(report.blocks[1].rows == 1);
  double lowest = 0.0;
  for (std::uint32_t i = 0; i < 8; ++i) {
    const Vec3 corner_l((i & 1u) != 0 ? kHalf.x() : -kHalf.x(),
                        (i & 2u) != 0 ? kHalf.y() : -kHalf.y(),
                        (i & 4u) != 0 ? kHalf.z() : -kHalf.z());
    lowest = std::min(lowest, world.pose(box).to_world(corner_l).z());
  }
  CHECK(report.blocks[1].residual == Approx(-lowest).margin(1e-9));
  double sum = 0.0;
  for (const double s : report.stage_s) {
    CHECK(s >= 0.0);
    sum += s;
  }
  CHECK(report.total_s() == sum);
  CHECK(sum > 0.0);
  STATIC_REQUIRE(kStageNames.size() == static_cast<std::size_t>(Stage::End) + 1);

  Solver quiet({.measure_stages = false});
  CHECK(quiet.step(world, kFrame).total_s() == 0.0);
}

TEST_CASE("solver: it keeps nothing between steps but scratch", "[pbd][golden]") {
  const auto build = [](World& world, ToyContacts& contacts, double speed) {
    world.set_contact_source(&contacts);
    const BodyId ground = add_ground(world);
    BodyDef def = box_def(1.0, kHalf, Vec3(0.0, 0.0, 0.6), turn(Vec3(0.1, 0.2, 0.0)));
    def.twist.linear.x() = speed;
    const BodyId box = world.add_body(def);
    contacts.box_on_plane(ground, Vec3::UnitZ(), 0.0, box, kHalf, {});
  };
  World a, b, alone;
  ToyContacts contacts_a, contacts_b, contacts_alone;
  build(a, contacts_a, 1.0);
  build(b, contacts_b, -2.0);
  build(alone, contacts_alone, 1.0);
  Solver shared;
  Solver own;
  for (int k = 0; k < 100; ++k) {
    shared.step(a, kFrame);
    shared.step(b, kFrame);
    own.step(alone, kFrame);
  }
  CHECK(a.hash() == alone.hash());
  CHECK(a.hash() != b.hash());
}

TEST_CASE("solver: the order in which kinds of constraints were added does not matter",
          "[pbd][golden]") {
  std::vector<std::uint64_t> hashes;
  for (const bool reversed : {false, true}) {
    World world;
    ToyContacts contacts;
    if (!reversed) world.set_contact_source(&contacts);
    DistanceJoints* rods = nullptr;
    JointBlock* balls = nullptr;
    if (reversed) {
      balls = &world.add_block<JointBlock>();
      rods = &world.add_block<DistanceJoints>();
      world.set_contact_source(&contacts);
    } else {
      rods = &world.add_block<DistanceJoints>();
      balls = &world.add_block<JointBlock>();
    }
    const BodyId ground = add_ground(world);
    const BodyId a =
        world.add_body(box_def(1.0, kHalf, Vec3(0.0, 0.0, 0.6), turn(Vec3(0.1, 0, 0))));
    const BodyId b = world.add_body(box_def(2.0, kHalf, Vec3(1.5, 0.0, 0.9)));
    contacts.box_on_plane(ground, Vec3::UnitZ(), 0.0, a, kHalf, {});
    contacts.box_on_plane(ground, Vec3::UnitZ(), 0.0, b, kHalf, {});
    balls->add(world, ball_joint_at(world, a, b, Vec3(0.7, 0.0, 0.8)));
    rods->add(world, {.a = a,
                      .b = b,
                      .anchor_b_l = Vec3(0.0, 0.3, 0.0),
                      .rest_length = 1.5,
                      .compliance = 1e-3,
                      .damping = 1.0});
    Solver solver;
    run(world, solver, 2.0);
    hashes.push_back(world.hash());
  }
  CHECK(hashes[0] == hashes[1]);
}

}  // namespace solver_test
