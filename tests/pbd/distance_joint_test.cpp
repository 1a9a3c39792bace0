// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/pbd/distance_joint.h"

#include <cmath>
#include <functional>
#include <limits>

#include "support/bodies.h"
#include "support/catch.h"
#include "support/gradient.h"
#include "tandem/pbd/corrections.h"
#include "tandem/pbd/world_copy.h"

namespace distance_joint_test {

using namespace tandem::pbd;
using namespace tandem::testing;

namespace {

const Vec3 kHalf(0.2, 0.2, 0.2);

/// Two free boxes that tumble, joined off-centre.
struct FreePair {
  World world{weightless()};
  BodyId a, b;
  DistanceJoints* joints = nullptr;
  ConstraintId joint;

  FreePair(const Vec3& half, double rest_length, double compliance, double damping,
           bool swapped = false) {
    joints = &world.add_block<DistanceJoints>();
    BodyDef def = box_def(1.0, half, Vec3(0.0, 0.0, 0.0));
    def.twist = {Vec3(0.2, -0.1, 0.3), Vec3(0.0, 2.0, 1.0)};
    a = world.add_body(def);
    def = box_def(3.0, half, Vec3(1.0, 0.2, 0.0), turn(Vec3(0.3, 0.2, 0.1)));
    def.twist = {Vec3(-0.1, 0.4, 0.0), Vec3(1.0, 0.0, -2.0)};
    b = world.add_body(def);
    DistanceJoint::Def row{.a = a,
                           .b = b,
                           .anchor_a_l = Vec3(0.2, 0.1, 0.0),
                           .anchor_b_l = Vec3(-0.2, 0.0, 0.1),
                           .rest_length = rest_length,
                           .compliance = compliance,
                           .damping = damping};
    if (swapped) {
      std::swap(row.a, row.b);
      std::swap(row.anchor_a_l, row.anchor_b_l);
    }
    joint = joints->add(world, row);
  }
  double length() const {
    const DistanceJoint::Def& def = joints->def(joint);
    return (world.pose(def.b).to_world(def.anchor_b_l) - world.pose(def.a).to_world(def.anchor_a_l))
        .norm();
  }
};

/// A 2 kg body on a spring to the world along x.
struct Oscillator {
  World world{weightless()};
  BodyId body;
  DistanceJoints* joints = nullptr;
  ConstraintId joint;

  Oscillator(double stiffness, double damping, double x) {
    joints = &world.add_block<DistanceJoints>();
    body = world.add_body(box_def(2.0, kHalf, Vec3(1.0 + x, 0.0, 0.0)));
    joint = joints->add(
        world, {.b = body, .rest_length = 1.0, .compliance = 1.0 / stiffness, .damping = damping});
  }
  double x() const { return world.pose(body).position.x() - 1.0; }
};

}  // namespace

TEST_CASE("distance_joint: a spring is implicit Euler to rounding, damped or not",
          "[pbd][analytic]") {
  for (const double damping : {0.0, 3.0, 80.0}) {
    for (const int substeps : {1, 10}) {
      Oscillator scene(500.0, damping, 0.1);
      ImplicitSpring exact{.mass = 2.0, .stiffness = 500.0, .damping = damping, .x = 0.1};
      Solver solver({.substeps = substeps, .sleep_after = 0.0});
      for (int i = 0; i < 120; ++i) {
        solver.step(scene.world, kFrame);
        for (int k = 0; k < substeps; ++k) exact.step(kFrame / substeps);
        INFO("damping " << damping << " substeps " << substeps << " step " << i);
        REQUIRE(std::abs(scene.x() - exact.x) < 1e-12);
        REQUIRE(std::abs(scene.world.twist(scene.body).linear.x() - exact.v) < 1e-10);
      }
    }
  }
}

TEST_CASE("distance_joint: a free pair swings with the period of its reduced mass",
          "[pbd][analytic]") {
  World world(weightless());
  auto& joints = world.add_block<DistanceJoints>();
  const BodyId a = world.add_body(box_def(1.0, kHalf, Vec3(0.0, 0.0, 0.0)));
  const BodyId b = world.add_body(box_def(3.0, kHalf, Vec3(1.1, 0.0, 0.0)));
  const double k = 40.0;
  joints.add(world, {.a = a, .b = b, .rest_length = 1.0, .compliance = 1.0 / k});
  Solver solver({.substeps = 100, .sleep_after = 0.0});
  std::vector<double> stretch;
  run(world, solver, 4.0,
      [&] { stretch.push_back((world.pose(b).position - world.pose(a).position).norm() - 1.0); });
  const double omega = std::sqrt(k / (1.0 * 3.0 / 4.0));
  // Implicit Euler turns by atan(omega h) in each substep; interpolation between frames adds 1e-4.
  const double h = kFrame / 100.0;
  const double period = 2.0 * kPi * h / std::atan(omega * h);
  CHECK(mean_period(stretch, kFrame) == Approx(period).epsilon(1e-3));
  CHECK(period == Approx(2.0 * kPi / omega).epsilon(1e-4));
}

TEST_CASE("distance_joint: stretch under load is F / k for any iterations", "[pbd][analytic]") {
  for (const int joint_iterations : {1, 5, 50}) {
    for (const int position_iterations : {1, 4}) {
      World world;
      auto& joints = world.add_block<DistanceJoints>();
      const BodyId body = world.add_body(box_def(2.0, kHalf, Vec3(0.0, 0.0, -1.0)));
      joints.add(world,
                 {.b = body, .rest_length = 1.0, .compliance = 1.0 / 400.0, .damping = 40.0});
      Solver solver({.position_iterations = position_iterations,
                     .joint_iterations = joint_iterations,
                     .joint_tolerance = 0.0,
                     .sleep_after = 0.0});
      run(world, solver, 5.0);
      INFO(joint_iterations << " joint, " << position_iterations << " position iterations");
      CHECK(std::abs(-world.pose(body).position.z() - 1.0 - 2.0 * kGravity / 400.0) < 1e-9);
    }
  }
}

TEST_CASE("distance_joint: springs in series carry each the weight below it", "[pbd][analytic]") {
  for (const int position_iterations : {1, 4}) {
    World world;
    auto& joints = world.add_block<DistanceJoints>();
    const BodyId upper = world.add_body(box_def(2.0, kHalf, Vec3(0.0, 0.0, -1.0)));
    const BodyId lower = world.add_body(box_def(1.0, kHalf, Vec3(0.0, 0.0, -2.0)));
    joints.add(world, {.b = upper, .rest_length = 1.0, .compliance = 1.0 / 400.0, .damping = 30.0});
    joints.add(
        world,
        {.a = upper, .b = lower, .rest_length = 1.0, .compliance = 1.0 / 250.0, .damping = 30.0});
    Solver solver({.position_iterations = position_iterations,
                   .joint_iterations = 200,
                   .joint_tolerance = 1e-15,
                   .sleep_after = 0.0});
    run(world, solver, 5.0);
    const double sag_upper = 3.0 * kGravity / 400.0;
    const double sag_lower = sag_upper + 1.0 * kGravity / 250.0;
    CHECK(std::abs(-world.pose(upper).position.z() - 1.0 - sag_upper) < 1e-6);
    CHECK(std::abs(-world.pose(lower).position.z() - 2.0 - sag_lower) < 1e-6);
  }
}

TEST_CASE("distance_joint: force() is Hooke's force and has a sign", "[pbd][analytic]") {
  World world;
  auto& joints = world.add_block<DistanceJoints>();
  const BodyId body = world.add_body(box_def(2.0, kHalf, Vec3(0.0, 0.0, -1.0)));
  const ConstraintId id = joints.add(
      world, {.b = body, .rest_length = 1.0, .compliance = 1.0 / 400.0, .damping = 60.0});
  Solver solver({.substeps = 10, .sleep_after = 0.0});
  run(world, solver, 8.0);
  // Stretched by the weight, it pulls: negative.
  CHECK(joints.at(id).force() == Approx(-2.0 * kGravity).epsilon(1e-6));
}

TEST_CASE("distance_joint: an agreed stretch decays, a set one closes without velocity",
          "[pbd][unit]") {
  World world({.gravity = Vec3::Zero()});
  const BodyId body = world.add_body(box_def(1.0, kHalf, Vec3(1.0, 0.0, 0.0)));
  world.add_block<DistanceJoints>().add(world, {.b = body, .rest_length = 1.0});
  const bool agreed = GENERATE(true, false);
  WorldCopy copy;
  REQUIRE(copy.assign(world));
  BodyState stretched = world.state(body);
  stretched.pose.position.x() = 1.1;
  if (agreed) copy.displace(body.index, stretched);
  if (!agreed) copy.set_state(body.index, stretched, true);
  constexpr int kSubsteps = 4;
  Solver solver({.substeps = kSubsteps, .sleep_after = 0.0});
  solver.step(copy.world(), 1.0 / 60.0);
  const BodyState& after = copy.world().state(body);
  if (agreed) {
    // The rest decays once in each substep, and that motion is the only speed.
    const double left = residual_decay(1.0 / 60.0 / kSubsteps);
    const double before_last = 0.1 * std::pow(left, kSubsteps - 1);
    const double way = (1.0 - left) * before_last;  // m, of the last substep
    CHECK(after.pose.position.x() == Approx(1.0 + before_last - way).epsilon(1e-9));
    CHECK(after.twist.linear.x() == Approx(-way * kSubsteps * 60.0).epsilon(1e-6));
  } else {
    CHECK(after.pose.position.x() < 1.1);
    for (int i = 0; i < 10; ++i) solver.step(copy.world(), 1.0 / 60.0);
    CHECK(after.pose.position.x() == Approx(1.0).margin(1e-6));
    CHECK(after.twist.linear.norm() < 1e-9);
  }
}

TEST_CASE("distance_joint: an infinitely soft spring leaves the motion alone", "[pbd][unit]") {
  World with;
  World without;
  auto& joints = with.add_block<DistanceJoints>();
  const BodyDef def = box_def(1.0, kHalf, Vec3(0.3, 0.0, 0.0));
  const BodyId body = with.add_body(def);
  without.add_body(def);
  joints.add(with, {.b = body, .anchor_b_l = Vec3(0.1, 0.0, 0.0), .compliance = 1e15});
  Solver solver({.substeps = 10, .sleep_after = 0.0});
  run(with, solver, 1.0);
  run(without, solver, 1.0);
  CHECK((with.pose(body).position - without.pose(body).position).norm() < 1e-12);
}

TEST_CASE("distance_joint: without compliance it is a rod", "[pbd][unit]") {
  World world;
  auto& joints = world.add_block<DistanceJoints>();
  const BodyId body = world.add_body(box_def(1.0, kHalf, Vec3(1.0, 0.0, 0.0)));
  joints.add(world, {.b = body, .rest_length = 1.0});
  Solver solver({.substeps = 10, .sleep_after = 0.0});
  const double energy = world.mechanical_energy();
  double worst = 0.0;
  double worst_energy = 0.0;
  run(world, solver, 5.0, [&] {
    worst = std::max(worst, std::abs(world.pose(body).position.norm() - 1.0));
    worst_energy = std::max(worst_energy, std::abs(world.mechanical_energy() - energy));
  });
  // The joint stops at its tolerance of 1e-6 m; m g L is 9.8 J.
  CHECK(worst < 2e-6);
  CHECK(worst_energy < 0.01 * kGravity);
}

TEST_CASE("distance_joint: a rod that starts too long or too short comes to its length",
          "[pbd][unit]") {
  for (const double rest : {0.4, 0.8}) {
    FreePair pair(kHalf, rest, 0.0, 0.0);
    Solver solver({.substeps = 10, .sleep_after = 0.0});
    run(pair.world, solver, 0.5);
    const StepReport& report = solver.step(pair.world, kFrame);
    INFO("rest length " << rest);
    CHECK(std::abs(pair.length() - rest) < 1e-5);
    REQUIRE(report.blocks.size() == 1);
    CHECK(report.blocks[0].residual == Approx(std::abs(pair.length() - rest)).margin(1e-12));
  }
}

TEST_CASE("distance_joint: one projection follows the numerical gradient", "[pbd][gradient]") {
  for (const double rest : {0.2, 1.3}) {
    World world;
    const BodyId a = world.add_body({});
    const BodyId b = world.add_body({});
    const DistanceJoint::Def def{.a = a,
                                 .b = b,
                                 .anchor_a_l = Vec3(0.2, 0.1, -0.3),
                                 .anchor_b_l = Vec3(-0.1, 0.4, 0.2),
                                 .rest_length = rest};
    std::vector<SolverBody> bodies{solver_body({Vec3(0.1, 0.2, 0.3), turn(Vec3(0.5, -0.2, 0.9))},
                                               1.5, box_inertia(1.5, Vec3(0.1, 0.3, 0.2))),
                                   solver_body({Vec3(0.9, 0.4, -0.2), turn(Vec3(-1.0, 0.3, 0.2))},
                                               0.7, box_inertia(0.7, Vec3(0.3, 0.1, 0.1)))};
    const auto c = [&](const std::vector<Pose>& poses) {
      Eigen::VectorXd value(1);
      value[0] = (poses[1].to_world(def.anchor_b_l) - poses[0].to_world(def.anchor_a_l)).norm() -
                 def.rest_length;
      return value;
    };
    const Eigen::VectorXd expected = expected_projection(c, bodies);
    DistanceJoint joint(def);
    const SubstepContext context{.bodies = bodies, .h = 0.01};
    joint.begin_substep(context);
    joint.project(context);
    CHECK((corrections_of(bodies) - expected).norm() < 1e-8 * expected.norm());
  }
}

TEST_CASE("distance_joint: linear and angular momentum of a free pair are kept",
          "[pbd][analytic]") {
  for (const double compliance : {0.0, 1e-3}) {
    FreePair pair(kHalf, 0.8, compliance, compliance > 0.0 ? 2.0 : 0.0);
    // Closing a rod that starts too long gives no velocity, so the momentum of a tumbling pair
    // changes.
    Solver solver({.substeps = 10, .sleep_after = 0.0});
    run(pair.world, solver, 0.5);
    const Vec3 p = linear_momentum(pair.world);
    const Vec3 l = angular_momentum(pair.world);
    run(pair.world, solver, 5.0);
    INFO("compliance " << compliance);
    CHECK((linear_momentum(pair.world) - p).norm() < 1e-12);
    CHECK((angular_momentum(pair.world) - l).norm() < 1e-12);
  }
}

TEST_CASE("distance_joint: the order of the two bodies does not matter", "[pbd][unit]") {
  for (const double compliance : {0.0, 1e-3}) {
    FreePair one(kHalf, 0.8, compliance, 1.0);
    FreePair two(kHalf, 0.8, compliance, 1.0, true);
    Solver solver({.substeps = 10, .sleep_after = 0.0});
    run(one.world, solver, 1.0);
    run(two.world, solver, 1.0);
    for (const BodyId id : {one.a, one.b}) {
      CHECK((one.world.pose(id).position - two.world.pose(id).position).norm() < 1e-9);
      CHECK(angle_between(one.world.pose(id).orientation, two.world.pose(id).orientation) < 1e-9);
    }
  }
}

TEST_CASE("distance_joint: against an immovable side only the other one moves", "[pbd][unit]") {
  World world(weightless());
  auto& joints = world.add_block<DistanceJoints>();
  const BodyId wall = add_ground(world);
  const BodyId cart = world.add_body({.type = BodyType::Kinematic,
                                      .pose = {Vec3(0.0, 3.0, 0.0), Quat::Identity()},
                                      .twist = {Vec3(1.0, 0.0, 0.0), Vec3::Zero()}});
  const BodyId a = world.add_body(box_def(1.0, kHalf, Vec3(1.5, 0.0, 0.0)));
  const BodyId b = world.add_body(box_def(1.0, kHalf, Vec3(0.0, 4.0, 0.0)));
  joints.add(world, {.a = wall, .b = a, .rest_length = 1.0});
  joints.add(world, {.a = b, .b = cart, .rest_length = 1.0});
  joints.add(world, {.a = wall, .b = cart, .rest_length = 1.0});  // neither can move
  Solver solver({.substeps = 10, .sleep_after = 0.0});
  run(world, solver, 1.0);
  CHECK(world.pose(wall).position.norm() == 0.0);
  CHECK((world.pose(cart).position - Vec3(1.0, 3.0, 0.0)).norm() < 1e-12);
  CHECK((world.pose(a).position - Vec3(0.0, 0.0, 0.0)).norm() == Approx(1.0).margin(1e-5));
  CHECK((world.pose(b).position - world.pose(cart).position).norm() == Approx(1.0).margin(1e-5));
}

TEST_CASE("distance_joint: points that coincide have no direction and do no harm", "[pbd][fault]") {
  World world(weightless());
  auto& joints = world.add_block<DistanceJoints>();
  const BodyId a = world.add_body(box_def(1.0, kHalf, Vec3::Zero()));
  const BodyId b = world.add_body(box_def(1.0, kHalf, Vec3::Zero()));
  joints.add(world, {.a = a, .b = b, .rest_length = 0.5});
  Solver solver({.substeps = 10, .sleep_after = 0.0});
  CHECK(solver.step(world, kFrame).status == StepStatus::Ok);
  CHECK((world.pose(a).position.norm() == 0.0 && world.pose(b).position.norm() == 0.0));
  world.set_pose(b, {Vec3(1e-3, 0.0, 0.0), Quat::Identity()});  // now there is one
  run(world, solver, 0.5);
  CHECK((world.pose(b).position - world.pose(a).position).norm() == Approx(0.5).margin(1e-5));
}

TEST_CASE("distance_joint: a bad definition is refused naming field, value and rule",
          "[pbd][fault]") {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInf = std::numeric_limits<double>::infinity();
  using Def = DistanceJoint::Def;
  World world;
  auto& joints = world.add_block<DistanceJoints>();
  const BodyId a = world.add_body({});
  const BodyId b = world.add_body({});
  const BodyId stale = world.add_body({});
  world.remove_body(stale);
  const auto refused = [&](const char* field, const char* value, const char* rule,
                           const std::function<void(Def&)>& spoil) {
    Def def{.a = a, .b = b};
    spoil(def);
    const std::string message = refusal([&] { joints.add(world, def); });
    INFO("\"" << message << "\"");
    CHECK(names(message, std::string("distance_joint: ") + field, value, rule));
  };
  refused("a", "body 2", "a body of this world", [&](Def& d) { d.a = stale; });
  refused("b", "body 2", "a body of this world", [&](Def& d) { d.b = stale; });
  refused("b", "body 4294967295", "a body of this world", [&](Def& d) { d.b = {}; });
  refused("b", "is 0", "another body than a", [&](Def& d) { d.b = a; });
  refused("anchor_a_l", "nan", "finite", [&](Def& d) { d.anchor_a_l.x() = kNan; });
  refused("anchor_b_l", "inf", "finite", [&](Def& d) { d.anchor_b_l.z() = kInf; });
  refused("rest_length", "-0.1", ">= 0", [&](Def& d) { d.rest_length = -0.1; });
  refused("rest_length", "nan", "finite", [&](Def& d) { d.rest_length = kNan; });
  refused("compliance", "is -1", "at least 1e-100", [&](Def& d) { d.compliance = -1.0; });
  refused("compliance", "inf", "finite", [&](Def& d) { d.compliance = kInf; });
  refused("damping", "is -2", ">= 0", [&](Def& d) { d.damping = -2.0; });
  refused("damping", "nan", "finite", [&](Def& d) { d.damping = kNan; });
  CHECK(joints.size() == 0);
}

TEST_CASE("distance_joint: a rope is slack up to its length and holds there", "[pbd][analytic]") {
  World world;
  auto& joints = world.add_block<DistanceJoints>();
  const BodyId body = world.add_body(box_def(2.0, kHalf, Vec3(0.0, 0.0, -0.5)));
  const ConstraintId id = joints.add(world, {.b = body, .elastic = false, .max_length = 1.0});
  Solver solver({.substeps = 10, .sleep_after = 0.0});
  run(world, solver, 0.25);
  CHECK(world.twist(body).linear.z() == Approx(-0.25 * kGravity).epsilon(1e-9));
  CHECK(joints.at(id).force() == 0.0);
  run(world, solver, 1.0);
  CHECK(world.pose(body).position.z() == Approx(-1.0).margin(1e-9));
  CHECK(joints.at(id).force() == Approx(-2.0 * kGravity).epsilon(1e-6));
  world.set_twist(body, {Vec3(0.0, 0.0, 2.0), Vec3::Zero()});
  run(world, solver, 0.1);
  CHECK(joints.at(id).force() == 0.0);
  CHECK(world.pose(body).position.z() > -0.9);
}

TEST_CASE("distance_joint: a spring stops at the ends of its range", "[pbd][analytic]") {
  World world;
  auto& joints = world.add_block<DistanceJoints>();
  const BodyId body = world.add_body(box_def(2.0, kHalf, Vec3(0.0, 0.0, -1.0)));
  const ConstraintId id = joints.add(
      world,
      {.b = body, .rest_length = 1.0, .compliance = 0.1, .min_length = 0.9, .max_length = 1.2});
  Solver solver({.substeps = 10, .sleep_after = 0.0});
  double longest = 0.0;
  run(world, solver, 3.0, [&] { longest = std::max(longest, -world.pose(body).position.z()); });
  CHECK(longest == Approx(1.2).margin(1e-9));
  // The weight alone would stretch it by 1.96 m: the stop carries what the spring does not.
  CHECK(world.pose(body).position.z() == Approx(-1.2).margin(1e-9));
  CHECK(joints.at(id).force() == Approx(-2.0 * kGravity).epsilon(1e-6));
  const DistanceJoint::Def bad{.b = body, .rest_length = 2.0, .max_length = 1.0};
  CHECK(names(refusal([&] { joints.add(world, bad); }), "distance_joint: rest_length", "is 2",
              "max_length"));
}

TEST_CASE("distance_joint: points that coincide have no force until they part", "[pbd][fault]") {
  World world(weightless());
  auto& joints = world.add_block<DistanceJoints>();
  const BodyId body = world.add_body(box_def(1.0, kHalf, Vec3::Zero()));
  const ConstraintId id = joints.add(world, {.b = body, .rest_length = 1.0, .compliance = 1e-3});
  Solver solver({.sleep_after = 0.0});
  run(world, solver, 0.5);
  CHECK(joints.at(id).force() == 0.0);
  CHECK(world.pose(body).position.norm() == 0.0);
}

TEST_CASE("distance_joint: its force is a vector on b, its opposite on a", "[pbd][analytic]") {
  World world;
  auto& joints = world.add_block<DistanceJoints>();
  const BodyId body = world.add_body(ball_def(2.0, 0.1, Vec3(0.0, 0.0, -1.0)));
  const ConstraintId id = joints.add(world, {.b = body, .rest_length = 1.0});
  Solver solver({.sleep_after = 0.0});
  run(world, solver, 1.0);
  CHECK((joints.at(id).force_on_b() - Vec3(0.0, 0.0, 2.0 * kGravity)).norm() < 1e-6);
}

TEST_CASE("distance_joint: it breaks at its force and not below, and mends when enabled",
          "[pbd][analytic]") {
  World world;
  auto& joints = world.add_block<DistanceJoints>();
  const BodyId body = world.add_body(ball_def(2.0, 0.1, Vec3(0.0, 0.0, -1.0)));
  DistanceJoint::Def def{.b = body, .rest_length = 1.0};
  def.break_force = 30.0;  // the weight is 20 N
  const ConstraintId id = joints.add(world, def);
  Solver solver({.sleep_after = 0.0});
  run(world, solver, 0.5);
  REQUIRE_FALSE(joints.at(id).broken());
  world.apply_force(body, Vec3(0.0, 0.0, -20.0));
  solver.step(world, kFrame);
  CHECK(joints.at(id).broken());
  CHECK(joints.at(id).force() == Approx(-(20.0 + 2.0 * kGravity)).epsilon(1e-3));
  const auto bytes = world.snapshot();
  run(world, solver, 0.5);
  CHECK(joints.at(id).force() == 0.0);
  CHECK(joints.at(id).residual() == 0.0);
  CHECK(world.pose(body).position.z() < -2.0);
  world.restore(bytes);
  CHECK(joints.at(id).broken());
  world.set_pose(body, {Vec3(0.0, 0.0, -1.0), Quat::Identity()});
  world.set_twist(body, {});
  joints.set(world, id, def);
  run(world, solver, 0.5);
  CHECK_FALSE(joints.at(id).broken());
  CHECK(world.pose(body).position.z() == Approx(-1.0).margin(1e-3));
}

TEST_CASE("distance_joint: switched off it joins nothing", "[pbd][unit]") {
  World world;
  auto& joints = world.add_block<DistanceJoints>();
  const BodyId body = world.add_body(ball_def(2.0, 0.1, Vec3(0.0, 0.0, -1.0)));
  DistanceJoint::Def def{.b = body, .rest_length = 1.0};
  def.enabled = false;
  joints.add(world, def);
  Solver solver;
  run(world, solver, 1.0);
  CHECK(world.twist(body).linear.z() == Approx(-kGravity));
}

TEST_CASE("distance_joint: a soft range gives way by load times compliance", "[pbd][analytic]") {
  World world;
  auto& joints = world.add_block<DistanceJoints>();
  const BodyId body = world.add_body(ball_def(2.0, 0.1, Vec3(0.0, 0.0, -0.5)));
  DistanceJoint::Def def{.b = body, .elastic = false, .max_length = 1.0};
  def.range_compliance = 1e-3;
  def.range_damping = 60.0;
  const ConstraintId id = joints.add(world, def);
  Solver solver({.sleep_after = 0.0});
  run(world, solver, 4.0);
  CHECK(world.pose(body).position.z() == Approx(-1.0 - 2.0 * kGravity * 1e-3).epsilon(1e-6));
  CHECK(joints.at(id).force() == Approx(-2.0 * kGravity).epsilon(1e-6));
  def.range_compliance = 1e-310;
  CHECK(
      names(refusal([&] { joints.set(world, id, def); }), "range_compliance", "1e-310", "1e-100"));
}

}  // namespace distance_joint_test
