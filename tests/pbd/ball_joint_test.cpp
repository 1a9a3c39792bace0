// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "support/bodies.h"
#include "support/catch.h"
#include "tandem/pbd/joint.h"

namespace ball_joint_test {

using namespace tandem::pbd;
using namespace tandem::testing;

namespace {

const Vec3 kHalf(0.2, 0.2, 0.2);

/// A thin rod of 1 m and 1 kg that hangs from the world by its end and swings about y.
struct Pendulum {
  static constexpr double kDistance = 0.5;  ///< m, pivot to centre of mass
  World world;
  BodyId rod;
  JointBlock* joints = nullptr;

  explicit Pendulum(double amplitude) {
    joints = &world.add_block<JointBlock>();
    const Vec3 centre(kDistance * std::sin(amplitude), 0.0, -kDistance * std::cos(amplitude));
    // The rod lies along its own x axis.
    rod = world.add_body(
        box_def(1.0, Vec3(0.5, 0.01, 0.01), centre, turn(Vec3(0.0, 0.5 * kPi - amplitude, 0.0))));
    joints->add(world, ball_joint_at(world, {}, rod, Vec3::Zero()));
  }
  /// Inertia about the pivot, kg m^2.
  double inertia() const { return world.props(rod).inertia(1, 1) + kDistance * kDistance; }
  double angle() const {
    const Vec3& p = world.pose(rod).position;
    return std::atan2(p.x(), -p.z());
  }
};

/// Two free boxes that tumble, joined at a point off both centres.
struct FreePair {
  World world{weightless()};
  BodyId a, b;
  JointBlock* joints = nullptr;
  ConstraintId joint;

  explicit FreePair(const Vec3& half, double compliance = 0.0, bool swapped = false) {
    joints = &world.add_block<JointBlock>();
    BodyDef def = box_def(1.0, half, Vec3(0.0, 0.0, 0.0));
    def.twist = {Vec3(0.2, -0.1, 0.3), Vec3(0.0, 2.0, 1.0)};
    a = world.add_body(def);
    def = box_def(3.0, half, Vec3(0.6, 0.2, 0.0), turn(Vec3(0.3, 0.2, 0.1)));
    def.twist = {Vec3(-0.1, 0.4, 0.0), Vec3(1.0, 0.0, -2.0)};
    b = world.add_body(def);
    const Vec3 anchor(0.3, 0.1, 0.05);
    BallJointDef row =
        swapped ? ball_joint_at(world, b, a, anchor) : ball_joint_at(world, a, b, anchor);
    row.compliance = compliance;
    joint = joints->add(world, row);
  }
};

}  // namespace

TEST_CASE("ball_joint: a rod keeps its energy within 1 % over 5 s, at any amplitude",
          "[pbd][analytic]") {
  for (const double amplitude : {10.0, 90.0, 170.0}) {
    Pendulum pendulum(amplitude * kPi / 180.0);
    Solver solver({.substeps = 10, .sleep_after = 0.0});
    const double start = pendulum.world.mechanical_energy();
    // Energy of the swinging body: from the turning point down to the lowest.
    const double scale = start + kGravity * Pendulum::kDistance;
    double worst = 0.0;
    run(pendulum.world, solver, 5.0,
        [&] { worst = std::max(worst, std::abs(pendulum.world.mechanical_energy() - start)); });
    INFO("amplitude " << amplitude << " degrees, relative error " << worst / scale);
    CHECK(worst < 0.01 * scale);
  }
}

TEST_CASE("ball_joint: a rod's period is that of the elliptic integral", "[pbd][analytic]") {
  for (const double amplitude : {10.0, 90.0, 150.0}) {
    Pendulum pendulum(amplitude * kPi / 180.0);
    const double w0 = std::sqrt(kGravity * Pendulum::kDistance / pendulum.inertia());
    Solver solver({.substeps = 10, .sleep_after = 0.0});
    std::vector<double> angles;
    run(pendulum.world, solver, 10.0, [&] { angles.push_back(pendulum.angle()); });
    const double period = pendulum_period(w0, amplitude * kPi / 180.0);
    INFO("amplitude " << amplitude << " degrees: " << mean_period(angles, kFrame) << " s against "
                      << period << " s");
    // A step of SHAKE shortens the period by (w h)^2 / 24, 2e-6 here; the rest is how crossings are
    // read from 60 Hz samples.
    CHECK(std::abs(mean_period(angles, kFrame) / period - 1.0) < 2e-4);
  }
}

TEST_CASE("ball_joint: the force of a hanging body is its weight", "[pbd][analytic]") {
  World world;
  auto& joints = world.add_block<JointBlock>();
  const BodyId body = world.add_body(box_def(2.0, kHalf, Vec3(0.0, 0.0, -1.0)));
  const ConstraintId id = joints.add(world, ball_joint_at(world, {}, body, Vec3::Zero()));
  Solver solver({.substeps = 10, .sleep_after = 0.0});
  run(world, solver, 1.0);
  CHECK((joints.at(id).force - Vec3(0.0, 0.0, 2.0 * kGravity)).norm() < 1e-6);
  CHECK((world.pose(body).position - Vec3(0.0, 0.0, -1.0)).norm() < 1e-6);
}

TEST_CASE("ball_joint: a compliant one stretches by F times its compliance", "[pbd][analytic]") {
  for (const double compliance : {1e-4, 1e-3}) {
    World world;
    auto& joints = world.add_block<JointBlock>();
    const BodyId body = world.add_body(box_def(2.0, kHalf, Vec3(0.0, 0.0, -1.0)));
    BallJointDef def = ball_joint_at(world, {}, body, Vec3::Zero());
    def.compliance = compliance;
    def.damping = 0.7 * std::sqrt(2.0 / compliance);
    joints.add(world, def);
    Solver solver({.substeps = 10, .sleep_after = 0.0});
    run(world, solver, 4.0);
    const double stretch = -1.0 - world.pose(body).position.z();
    CHECK(stretch == Approx(2.0 * kGravity * compliance).epsilon(1e-6));
  }
}

TEST_CASE("ball_joint: an infinitely soft one leaves the motion alone", "[pbd][unit]") {
  World with;
  World without;
  auto& joints = with.add_block<JointBlock>();
  const BodyDef def = box_def(1.0, kHalf, Vec3(0.3, 0.0, 0.0));
  const BodyId body = with.add_body(def);
  without.add_body(def);
  joints.add(with, BallJointDef{.b = body, .frame_b = {Vec3(0.1, 0.0, 0.0)}, .compliance = 1e15});
  Solver solver({.substeps = 10, .sleep_after = 0.0});
  run(with, solver, 1.0);
  run(without, solver, 1.0);
  CHECK((with.pose(body).position - without.pose(body).position).norm() < 1e-12);
}

TEST_CASE("ball_joint: linear and angular momentum of a free pair are kept", "[pbd][analytic]") {
  FreePair pair(kHalf);
  const Vec3 p = linear_momentum(pair.world);
  const Vec3 l = angular_momentum(pair.world);
  Solver solver({.joint_iterations = 100, .joint_tolerance = 1e-15});
  run(pair.world, solver, 5.0);
  CHECK((linear_momentum(pair.world) - p).norm() < 1e-12);
  CHECK((angular_momentum(pair.world) - l).norm() < 1e-12);
}

TEST_CASE("ball_joint: stretched, it keeps angular momentum to first order in the substep",
          "[pbd][analytic]") {
  // The force follows the gap as it is at the end of the substep, the lever arms the start.
  std::vector<double> errors;
  for (const int substeps : {10, 40}) {
    FreePair pair(kHalf, 1e-4);
    const Vec3 p = linear_momentum(pair.world);
    const Vec3 l = angular_momentum(pair.world);
    Solver solver({.substeps = substeps, .sleep_after = 0.0});
    double largest = 0.0;
    run(pair.world, solver, 5.0,
        [&] { largest = std::max(largest, (angular_momentum(pair.world) - l).norm()); });
    CHECK((linear_momentum(pair.world) - p).norm() < 1e-12);
    errors.push_back(largest / l.norm());
  }
  INFO(errors[0] << " " << errors[1]);
  CHECK(errors[0] < 1e-3);
  CHECK(errors[1] < errors[0] / 2.0);
}

TEST_CASE("ball_joint: a free pair keeps its energy", "[pbd][analytic]") {
  FreePair pair(Vec3(0.1, 0.2, 0.3));
  Solver solver({.substeps = 10, .sleep_after = 0.0});
  solver.step(pair.world, kFrame);  // the anchors' velocities agree from here on
  const double energy = pair.world.kinetic_energy();
  double worst = 0.0;
  run(pair.world, solver, 5.0,
      [&] { worst = std::max(worst, std::abs(pair.world.kinetic_energy() - energy)); });
  CHECK(worst < 0.01 * energy);
}

TEST_CASE("ball_joint: the order of the two bodies does not matter", "[pbd][unit]") {
  FreePair one(Vec3(0.1, 0.2, 0.3));
  FreePair two(Vec3(0.1, 0.2, 0.3), 0.0, true);
  Solver solver({.substeps = 10, .sleep_after = 0.0});
  run(one.world, solver, 1.0);
  run(two.world, solver, 1.0);
  for (const BodyId id : {one.a, one.b}) {
    CHECK((one.world.pose(id).position - two.world.pose(id).position).norm() < 1e-9);
    CHECK(angle_between(one.world.pose(id).orientation, two.world.pose(id).orientation) < 1e-9);
  }
  CHECK((one.joints->at(one.joint).force + two.joints->at(two.joint).force).norm() <
        1e-6 * one.joints->at(one.joint).force.norm());
}

TEST_CASE("ball_joint: a kinematic side drags, a static side holds, two of them do no harm",
          "[pbd][unit]") {
  World world(weightless());
  auto& joints = world.add_block<JointBlock>();
  const BodyId wall = add_ground(world);
  const BodyId cart = world.add_body({.type = BodyType::Kinematic,
                                      .pose = {Vec3(0.0, 3.0, 0.0), Quat::Identity()},
                                      .twist = {Vec3(1.0, 0.0, 0.0), Vec3::Zero()}});
  const BodyId a = world.add_body(box_def(1.0, kHalf, Vec3(0.5, 0.0, 0.0)));
  const BodyId b = world.add_body(box_def(1.0, kHalf, Vec3(0.0, 3.5, 0.0)));
  world.set_twist(a, {Vec3::Zero(), Vec3(0.0, 0.0, 3.0)});
  const ConstraintId on_wall = joints.add(world, ball_joint_at(world, wall, a, Vec3::Zero()));
  const ConstraintId on_cart =
      joints.add(world, ball_joint_at(world, b, cart, Vec3(0.0, 3.0, 0.0)));
  const ConstraintId both = joints.add(world, ball_joint_at(world, wall, cart, Vec3::Zero()));
  Solver solver({.substeps = 10, .sleep_after = 0.0});
  run(world, solver, 1.0);
  CHECK(world.pose(wall).position.norm() == 0.0);
  CHECK((world.pose(cart).position - Vec3(1.0, 3.0, 0.0)).norm() < 1e-12);
  CHECK(std::abs(world.pose(a).position.norm() - 0.5) < 1e-5);
  CHECK((world.pose(b).position - world.pose(cart).position).norm() == Approx(0.5).margin(1e-5));
  for (const ConstraintId id : {on_wall, on_cart, both}) CHECK(joints.at(id).force.allFinite());
}

TEST_CASE("ball_joint: parts that start apart come together without gaining energy",
          "[pbd][fault]") {
  World world(weightless());
  auto& joints = world.add_block<JointBlock>();
  const BodyId a = world.add_body(box_def(1.0, kHalf, Vec3::Zero()));
  const BodyId b = world.add_body(box_def(1.0, kHalf, Vec3(1.0, 0.0, 0.0)));
  const ConstraintId id =
      joints.add(world, BallJointDef{.a = a, .b = b});  // centre on centre, 1 m apart
  Solver solver({.substeps = 10, .sleep_after = 0.0});
  run(world, solver, 0.5, [&] { CHECK(world.twist(b).linear.norm() < 1e-9); });
  const StepReport& report = solver.step(world, kFrame);
  CHECK(report.status == StepStatus::Ok);
  CHECK(report.blocks[0].residual < 1e-6);
  CHECK(joints.at(id).residual == report.blocks[0].residual);
  CHECK((world.pose(a).position - Vec3(0.5, 0.0, 0.0)).norm() < 1e-5);
}

}  // namespace ball_joint_test
