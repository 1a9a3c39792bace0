// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/pbd/world.h"

#include <functional>
#include <limits>

#include "support/bodies.h"
#include "support/catch.h"
#include "support/toy_contacts.h"
#include "tandem/pbd/distance_joint.h"
#include "tandem/pbd/joint.h"
#include "tandem/pbd/tether.h"

namespace world_test {

using namespace tandem::pbd;
using namespace tandem::testing;

namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

}  // namespace

TEST_CASE("world: a body comes back as it was defined", "[pbd][unit]") {
  World world;
  BodyDef def = box_def(2.0, Vec3(0.1, 0.2, 0.3), Vec3(1.0, 2.0, 3.0), turn(Vec3(0.1, 0.2, 0.3)));
  def.twist = {Vec3(4.0, 5.0, 6.0), Vec3(7.0, 8.0, 9.0)};
  def.gravity_scale = 0.5;
  const BodyId id = world.add_body(def);
  CHECK(world.contains(id));
  CHECK(world.body_count() == 1);
  CHECK(world.pose(id).position == Vec3(1.0, 2.0, 3.0));
  CHECK(angle_between(world.pose(id).orientation, def.pose.orientation) < 1e-15);
  CHECK(world.twist(id).linear == Vec3(4.0, 5.0, 6.0));
  CHECK(world.twist(id).angular == Vec3(7.0, 8.0, 9.0));
  CHECK(world.props(id).mass == 2.0);
  CHECK(world.props(id).inverse_mass == 0.5);
  CHECK(world.props(id).gravity_scale == 0.5);
  CHECK((world.props(id).inverse_inertia * def.inertia - Mat3::Identity()).norm() < 1e-14);
}

TEST_CASE("world: static and kinematic bodies have no inverse mass, static ones no twist",
          "[pbd][unit]") {
  World world;
  const Twist twist{Vec3(1.0, 0.0, 0.0), Vec3(0.0, 1.0, 0.0)};
  const BodyId fixed = world.add_body({.type = BodyType::Static, .twist = twist, .mass = -1.0});
  const BodyId moved = world.add_body({.type = BodyType::Kinematic, .twist = twist, .mass = 0.0});
  for (const BodyId id : {fixed, moved}) {
    CHECK(world.props(id).mass == 0.0);
    CHECK(world.props(id).inverse_mass == 0.0);
    CHECK(world.props(id).inverse_inertia.norm() == 0.0);
  }
  CHECK(world.twist(fixed).linear.norm() == 0.0);
  CHECK(world.twist(moved).linear.x() == 1.0);
}

TEST_CASE("world: user data goes with its body, and with no other one", "[pbd][unit]") {
  World world;
  const BodyId plain = world.add_body({});
  const BodyId named = world.add_body({.user_data = 7});
  CHECK(world.user_data(plain) == 0);
  CHECK(world.user_data(named) == 7);
  const auto before = world.snapshot();
  const auto hash = world.hash();
  world.set_user_data(plain, 3);
  CHECK(world.snapshot() == before);
  CHECK(world.hash() == hash);
  world.restore(before);
  CHECK(world.user_data(plain) == 3);  // the same body before and after
  CHECK(world.user_data(named) == 7);
  world.remove_body(named);
  const BodyId next = world.add_body({});
  CHECK(next.index == named.index);
  CHECK(world.user_data(next) == 0);
  CHECK_FALSE(refusal([&] { world.user_data(named); }).empty());
  CHECK_FALSE(refusal([&] { world.set_user_data(named, 1); }).empty());
}

TEST_CASE("world: a removed body's id stays dead when its slot is used again", "[pbd][unit]") {
  World world;
  const BodyId first = world.add_body({.mass = 1.0});
  const BodyId other = world.add_body({.mass = 2.0});
  world.remove_body(first);
  CHECK_FALSE(world.contains(first));
  CHECK(world.contains(other));
  CHECK(world.body_count() == 1);
  CHECK(world.slot_count() == 2);
  CHECK_FALSE(world.body_at(first.index).valid());

  const BodyId second = world.add_body({.mass = 3.0});
  CHECK(second.index == first.index);
  CHECK(second.generation != first.generation);
  CHECK(world.slot_count() == 2);
  CHECK(world.body_at(second.index) == second);
  CHECK_FALSE(world.contains(first));
  CHECK(world.props(second).mass == 3.0);
}

TEST_CASE("world: every call refuses a stale, foreign or invalid id and changes nothing",
          "[pbd][fault]") {
  World world;
  const BodyId stale = world.add_body({});
  const BodyId alive = world.add_body({});
  world.remove_body(stale);
  world.add_body({});
  const std::uint64_t before = world.hash();
  for (const BodyId id : {stale, BodyId{}, BodyId{99, 0}, BodyId{alive.index, 7}}) {
    const std::string value = "body " + std::to_string(id.index);
    const std::vector<std::function<void()>> calls{
        [&] { world.remove_body(id); },      [&] { (void)world.state(id); },
        [&] { (void)world.props(id); },      [&] { world.set_pose(id, {}); },
        [&] { world.set_twist(id, {}); },    [&] { (void)world.correction(id); },
        [&] { (void)world.in_contact(id); },
    };
    for (const auto& call : calls) {
      CHECK(names(refusal(call), "World", value, "must be a body of this world"));
    }
  }
  CHECK(world.hash() == before);
  CHECK(world.body_count() == 2);
}

TEST_CASE("world: a bad body definition is refused naming field, value and rule", "[pbd][fault]") {
  struct Case {
    const char* field;
    const char* value;
    const char* rule;
    std::function<void(BodyDef&)> spoil;
  };
  const std::vector<Case> cases{
      {"mass", "is 0", "> 0", [](BodyDef& d) { d.mass = 0.0; }},
      {"mass", "is -1", "> 0", [](BodyDef& d) { d.mass = -1.0; }},
      {"mass", "inf", "finite", [](BodyDef& d) { d.mass = kInf; }},
      {"mass", "nan", "finite", [](BodyDef& d) { d.mass = kNan; }},
      {"pose.position", "nan", "finite", [](BodyDef& d) { d.pose.position.y() = kNan; }},
      {"pose.position", "inf", "finite", [](BodyDef& d) { d.pose.position.z() = kInf; }},
      {"pose.orientation", "is 0", "unit norm",
       [](BodyDef& d) { d.pose.orientation = Quat(0.0, 0.0, 0.0, 0.0); }},
      {"pose.orientation", "1.4", "unit norm",
       [](BodyDef& d) { d.pose.orientation = Quat(1.0, 1.0, 0.0, 0.0); }},
      {"pose.orientation", "nan", "unit norm",
       [](BodyDef& d) { d.pose.orientation = Quat(kNan, 0.0, 0.0, 0.0); }},
      {"twist.linear", "nan", "finite", [](BodyDef& d) { d.twist.linear.x() = kNan; }},
      {"twist.angular", "-inf", "finite", [](BodyDef& d) { d.twist.angular.x() = -kInf; }},
      {"gravity_scale", "nan", "finite", [](BodyDef& d) { d.gravity_scale = kNan; }},
      {"inertia", "nan", "finite", [](BodyDef& d) { d.inertia(1, 1) = kNan; }},
      {"inertia", "0.1", "symmetric", [](BodyDef& d) { d.inertia(0, 1) += 0.1; }},
      {"inertia", "is 0", "positive definite", [](BodyDef& d) { d.inertia.setZero(); }},
      {"inertia", "is -1", "positive definite",
       [](BodyDef& d) { d.inertia = Vec3(-1.0, 1.0, 1.0).asDiagonal(); }},
      // No body of positive density has one moment above the sum of the others.
      {"inertia", "is 3", "sum of the other two",
       [](BodyDef& d) { d.inertia = Vec3(1.0, 1.0, 3.0).asDiagonal(); }},
  };
  World world;
  world.add_body({});
  const std::uint64_t before = world.hash();
  for (const Case& c : cases) {
    BodyDef def;
    c.spoil(def);
    const std::string message = refusal([&] { world.add_body(def); });
    INFO(c.field << " " << c.value << ": \"" << message << "\"");
    CHECK(names(message, std::string("BodyDef: ") + c.field, c.value, c.rule));
  }
  CHECK(world.hash() == before);
  CHECK(world.body_count() == 1);
  CHECK(world.slot_count() == 1);
}

TEST_CASE("world: bad poses, twists and gravity are refused and change nothing", "[pbd][fault]") {
  World world;
  const BodyId body = world.add_body({});
  const BodyId ground = add_ground(world);
  const auto before = world.snapshot();
  CHECK(names(refusal([&] {
                world.set_pose(body, {Vec3(0.0, kNan, 0.0), Quat::Identity()});
              }),
              "pose.position", "nan", "finite"));
  CHECK(names(refusal([&] {
                world.set_pose(body, {Vec3::Zero(), Quat(0.5, 0.0, 0.0, 0.0)});
              }),
              "pose.orientation", "0.5", "unit norm"));
  CHECK(names(refusal([&] {
                world.set_twist(body, {Vec3(kInf, 0.0, 0.0), Vec3::Zero()});
              }),
              "twist.linear", "inf", "finite"));
  CHECK(names(refusal([&] {
                world.set_twist(body, {Vec3::Zero(), Vec3(0.0, 0.0, kNan)});
              }),
              "twist.angular", "nan", "finite"));
  CHECK(names(refusal([&] {
                world.set_twist(ground, {Vec3(1.0, 0.0, 0.0), Vec3::Zero()});
              }),
              "twist", "is 1", "zero for a static body"));
  CHECK(
      names(refusal([&] { world.set_gravity(Vec3(0.0, 0.0, kNan)); }), "gravity", "nan", "finite"));
  CHECK(names(refusal([&] { World bad({.gravity = Vec3(kInf, 0.0, 0.0)}); }), "gravity", "inf",
              "finite"));
  CHECK(world.snapshot() == before);
}

TEST_CASE("world: removing a body takes its rows and contacts along", "[pbd][unit]") {
  World world;
  ToyContacts contacts;
  world.set_contact_source(&contacts);
  auto& rods = world.add_block<DistanceJoints>();
  auto& balls = world.add_block<JointBlock>();
  auto& tethers = world.add_block<Tethers>();
  const BodyId ground = add_ground(world);
  const Vec3 half = Vec3::Constant(0.5);
  const BodyId a = world.add_body(box_def(1.0, half, Vec3(0.0, 0.0, 0.5)));
  const BodyId b = world.add_body(box_def(1.0, half, Vec3(5.0, 0.0, 0.5)));
  contacts.box_on_plane(ground, Vec3::UnitZ(), 0.0, a, half, {});
  contacts.box_on_plane(ground, Vec3::UnitZ(), 0.0, b, half, {});
  rods.add(world, {.a = a, .b = b, .rest_length = 5.0});
  balls.add(world, ball_joint_at(world, {}, a, Vec3(0.0, 0.0, 0.5)));
  const BodyId c = world.add_body(box_def(1.0, half, Vec3(9.0, 0.0, 5.0)));
  const ConstraintId kept = balls.add(world, ball_joint_at(world, {}, c, Vec3(9.0, 0.0, 5.0)));
  tethers.add(world, {.body = a});
  Solver solver;
  solver.step(world, kFrame);
  REQUIRE(world.contacts()->contacts().size() == 2);
  CHECK(world.in_contact(b));

  world.remove_body(a);
  CHECK(rods.size() == 0);
  CHECK(tethers.size() == 0);
  CHECK(balls.size() == 1);
  CHECK(balls.contains(kept));
  REQUIRE(world.contacts()->contacts().size() == 1);
  CHECK(world.contacts()->contacts()[0].manifold.body_b == b.index);
  const BodyId in_its_place = world.add_body(box_def(1.0, half, Vec3(0.0, 0.0, 9.0)));
  CHECK(in_its_place.index == a.index);
  CHECK_FALSE(world.in_contact(in_its_place));
  run(world, solver, 0.1);
  // Nothing of the old body holds the new one: it falls freely.
  CHECK(world.twist(in_its_place).linear.z() == Approx(-kGravity * 0.1).epsilon(1e-9));
}

TEST_CASE("world: blocks are kept in the order in which they are solved", "[pbd][unit]") {
  World world;
  ToyContacts contacts;
  world.set_contact_source(&contacts);
  world.add_block<JointBlock>();
  world.add_block<Tethers>();
  world.add_block<DistanceJoints>();
  std::vector<std::string> order;
  for (const auto& block : world.blocks()) order.emplace_back(block->name());
  CHECK(order == std::vector<std::string>{"tether", "distance_joint", "joint", "contact"});
}

TEST_CASE("world: a removed block is solved no more, the others keep their order and rows",
          "[pbd][unit][analytic]") {
  World world;
  auto& rods = world.add_block<DistanceJoints>();
  auto& balls = world.add_block<JointBlock>();
  auto& first = world.add_block<Tethers>();
  auto& removed = world.add_block<Tethers>();
  auto& last = world.add_block<Tethers>();
  const BodyId body = world.add_body({});
  const BodyId other = world.add_body({.pose = {Vec3(5.0, 0.0, 0.0), Quat::Identity()}});
  removed.add(world, {.body = body, .stiffness = 1e4, .damping = 100.0});
  const ConstraintId kept = balls.add(world, ball_joint_at(world, {}, other, Vec3(5.0, 0.0, 0.0)));
  Solver solver;
  run(world, solver, 0.5);
  CHECK(world.pose(body).position.z() == Approx(0.0).margin(1e-2));
  const double z = world.pose(body).position.z();
  const double v = world.twist(body).linear.z();

  world.remove_block(removed);
  const std::vector<const ConstraintBlock*> expected{&rods, &first, &last, &balls};
  std::vector<const ConstraintBlock*> order;
  for (const auto& block : world.blocks()) order.push_back(block.get());
  CHECK(order == expected);
  CHECK(balls.contains(kept));
  run(world, solver, 0.5);
  // Velocities are taken first and poses with the new ones: h = 1/240 s of the substeps shows.
  const double t = 0.5;
  const double fall = v * t - 0.5 * kGravity * t * (t + kFrame / 4.0);
  CHECK(world.pose(body).position.z() == Approx(z + fall).epsilon(1e-9));
  CHECK(world.pose(other).position.z() == Approx(0.0).margin(1e-6));
  // A block may come again, at its place behind those of the same order.
  const auto& again = world.add_block<Tethers>();
  REQUIRE(world.blocks().size() == 5);
  CHECK(world.blocks()[3].get() == &again);
}

TEST_CASE("world: a block that is not the world's to give away is refused", "[pbd][fault]") {
  World world;
  World other;
  ToyContacts contacts;
  world.set_contact_source(&contacts);
  auto& mine = world.add_block<Tethers>();
  const auto& foreign = other.add_block<Tethers>();
  const auto before = world.snapshot();
  CHECK(names(refusal([&] { world.remove_block(foreign); }), "World::remove_block: block",
              "unknown", "one of the world's blocks()"));
  CHECK(names(refusal([&] { world.remove_block(*world.contacts()); }), "World::remove_block: block",
              "that of contacts", "one that add_block() made"));
  CHECK(world.snapshot() == before);
  CHECK(other.blocks().size() == 1);
  world.remove_block(mine);
  // Its memory is free: nothing of it may be read.
  CHECK(names(refusal([&] { world.remove_block(mine); }), "World::remove_block: block", "unknown",
              "one of the world's blocks()"));
}

TEST_CASE("world: with a block go the snapshots that have it, without it fit those from before",
          "[pbd][unit]") {
  World world;
  const BodyId body = world.add_body({});
  const auto before = world.snapshot();
  auto& tethers = world.add_block<Tethers>();
  tethers.add(world, {.body = body});
  const auto with = world.snapshot();
  CHECK(names(refusal([&] { world.restore(before); }), "World::restore", "bytes", "same blocks"));
  world.remove_block(tethers);
  world.restore(before);
  CHECK(world.snapshot() == before);
  CHECK(names(refusal([&] { world.restore(with); }), "World::restore", "bytes", "same blocks"));
}

TEST_CASE("world: kinetic and mechanical energy are those of the textbook",
          "[pbd][unit][analytic]") {
  World world;
  BodyDef def =
      box_def(2.0, Vec3(0.3, 0.4, 0.5), Vec3(0.0, 0.0, 7.0), turn(Vec3(0.0, 0.0, kPi / 2)));
  def.twist = {Vec3(3.0, 0.0, 4.0), Vec3(2.0, 0.0, 0.0)};
  def.gravity_scale = 0.5;
  world.add_body(def);
  world.add_body({.type = BodyType::Kinematic, .twist = {Vec3(100.0, 0.0, 0.0), Vec3::Zero()}});
  // The world's x axis is the body's -y axis: I_yy = m/3 (hx^2 + hz^2).
  const double spin = 0.5 * (2.0 / 3.0 * (0.09 + 0.25)) * 4.0;
  CHECK(world.kinetic_energy() == Approx(0.5 * 2.0 * 25.0 + spin).epsilon(1e-14));
  CHECK(world.mechanical_energy() ==
        Approx(25.0 + spin + 2.0 * 0.5 * kGravity * 7.0).epsilon(1e-14));
}

TEST_CASE("world: a moved world keeps its bodies and the references to its blocks", "[pbd][unit]") {
  World world;
  auto& balls = world.add_block<JointBlock>();
  const BodyId body = world.add_body({});
  balls.add(world, ball_joint_at(world, {}, body, Vec3(0.0, 0.0, 1.0)));
  const std::uint64_t hash = world.hash();
  World moved = std::move(world);
  CHECK(moved.hash() == hash);
  CHECK(moved.contains(body));
  CHECK(moved.blocks().size() == 1);
  CHECK(moved.blocks()[0].get() == &balls);
  CHECK(balls.size() == 1);
}

TEST_CASE("world: one that was moved from is empty, and may be used again", "[pbd][unit]") {
  class NoTargets : public TargetSource {
    void collect(const World&, double, const SolverOptions&, std::vector<PoseTarget>&) override {}
  };
  const auto fall = [](World& world) {
    Solver solver;
    for (int i = 0; i < 3; ++i) solver.step(world, 1.0 / 60.0);
    return world.hash();
  };
  NoTargets targets;
  for (const bool assigned : {false, true}) {
    CAPTURE(assigned);
    World world;
    const BodyId low = world.add_body(ball_def(1.0, 0.5, Vec3::Zero()));
    const BodyId high = world.add_body(ball_def(1.0, 0.5, Vec3(0.0, 0.0, 0.9)));
    ToyContacts balls;
    balls.ball_on_ball(low, 0.5, high, 0.5, {});
    world.set_contact_source(&balls);
    world.set_target_source(&targets);
    fall(world);
    REQUIRE(world.contacts()->contacts().size() == 1);
    World other;
    if (assigned) {
      other = std::move(world);
    } else {
      const World made = std::move(world);
      CHECK(made.contacts()->contacts().size() == 1);
    }
    CHECK(world.body_count() == 0);
    CHECK(world.blocks().empty());
    CHECK(world.contacts() == nullptr);
    CHECK(world.contact_source() == nullptr);
    CHECK(world.target_source() == nullptr);
    World fresh;
    for (World* each : {&world, &fresh}) each->add_body(ball_def(1.0, 0.5, Vec3::Zero()));
    CHECK(fall(world) == fall(fresh));
  }
}

}  // namespace world_test
