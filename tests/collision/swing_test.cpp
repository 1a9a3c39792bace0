// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// What turns far within a step.
#include "inner_core.h"
#include "motion_path.h"
#include "scenes.h"
#include "tandem/pbd/joint.h"
#include "tandem/pbd/solver.h"

namespace swing_test {

using namespace tandem::collision;
using namespace tandem::collision::testing;
using tandem::pbd::JointBlock;
using tandem::pbd::Solver;
using tandem::pbd::Twist;

namespace {

/// A bat of 1.2 m that turns about z through one of its ends, and a ball in its way.
struct Swing {
  Fixture f;
  BodyId bat, ball;

  Swing(double angle, double rate, bool driven, double distance, double radius) {
    constexpr double kHalf = 0.6;
    f.world.set_gravity(Vec3::Zero());
    const Quat turned = tandem::pbd::exp_map(Vec3(0, 0, angle));
    const Vec3 arm = turned * Vec3(kHalf, 0, 0);
    // A thin rod of 1 kg.
    bat = f.world.add_body({.pose = {arm, turned},
                            .mass = 1.0,
                            .inertia = Vec3(1e-3, inertia(), inertia()).asDiagonal()});
    f.scene.add(f.world, {.body = bat, .shape = Box{Vec3(kHalf, 0.03, 0.03)}});
    const Vec3 spin(0, 0, rate);
    f.world.set_twist(bat, {spin.cross(arm), spin});
    auto hinge = hinge_joint_at(f.world, {}, bat, Vec3::Zero(), Vec3::UnitZ());
    if (driven) {
      hinge.axis.motor.mode = tandem::pbd::MotorMode::Velocity;
      hinge.axis.motor.target = rate;
    }
    f.world.add_block<JointBlock>().add(f.world, hinge);
    ball = f.world.add_body({.pose = at(distance, 0, 0),
                             .mass = kBall,
                             .inertia = 0.4 * kBall * radius * radius * Mat3::Identity()});
    f.scene.add(f.world, {.body = ball, .shape = Sphere{radius}});
    f.world.set_contact_source(&f.scene);
  }
  static constexpr double kBall = 0.15;                     // kg
  static double inertia() { return 1.0 * 1.2 * 1.2 / 12; }  // kg m^2, about its middle
};

}  // namespace

TEST_CASE("swing: a bat hits the ball in its way at any phase", "[collision][analytic]") {
  Random random(31);
  for (int i = 0; i < 160; ++i) {
    const double rate = random.in(20.0, 120.0);
    const double distance = random.in(0.3, 1.15);
    const double radius = random.in(0.03, 0.1);
    const bool driven = i % 2 == 1;
    const double start = -random.in(1.0, 1.0 + rate * kDt);
    Swing swing(start, rate, driven, distance, radius);
    const double energy = swing.f.world.mechanical_energy();
    Solver solver;
    const int passes = static_cast<int>((0.8 - start) / (rate * kDt)) + 2;
    for (int k = 0; k < passes; ++k) (void)solver.step(swing.f.world, kDt);
    INFO("case " << i << ": " << rate << " rad/s, ball of " << radius << " m at " << distance);
    // Without a bounce both go on at what angular momentum about the hinge leaves; as it slides
    // along the bat the ball gets faster.
    const double bat = 4.0 * Swing::inertia();
    const double shared = driven ? rate : rate * bat / (bat + Swing::kBall * distance * distance);
    CHECK(swing.f.world.twist(swing.ball).linear.norm() > 0.4 * shared * distance);
    if (!driven) CHECK(swing.f.world.mechanical_energy() < energy * (1.0 + 1e-6));
  }
}

TEST_CASE("swing: on its way to where a sweep stops it a body is apart from the other one",
          "[collision][unit]") {
  Random random(8);
  const std::vector<Shape> shapes = convex_shapes(0.4);
  int met = 0;
  for (std::size_t i = 0; i < 400; ++i) {
    const auto path = [&](double x) {
      const Pose from{Vec3(x, 0, 0) + random.vec(0.5), random.quat()};
      const Pose to{from.position + Vec3(-1.2 * x, 0, 0) + random.vec(0.6), random.quat()};
      return MotionPath(from, to, {random.vec(60.0), random.vec(60.0)}, kDt);
    };
    const auto moving = [&](std::size_t shape, double x) {
      const Collider c =
          make_collider({.shape = shapes[shape % shapes.size()]}, CollisionOptions{});
      return MovingCore{body_core(c), c.reach, path(x)};
    };
    const MovingCore a = moving(i, -1.2);
    const MovingCore b = moving(i / 7, 1.2);
    const auto apart = [&](double t) {
      ConvexCore one = a.core;
      ConvexCore two = b.core;
      for (auto [moved, way] : {std::pair(&one, &a.path), std::pair(&two, &b.path)}) {
        const Pose pose = way->at(t);
        moved->centre = pose.to_world(moved->centre);
        moved->axes = pose.orientation.toRotationMatrix() * moved->axes;
      }
      const CoreDistance d = core_distance(one, two);
      return d.apart ? d.distance - one.radius - two.radius : 0.0;
    };
    const SweepHit hit = sweep(a, b, 1e-3);
    if (hit.apart <= 0.0) continue;
    INFO("case " << i << " share " << hit.share);
    for (int k = 0; k <= 50; ++k) REQUIRE(apart(hit.share * k / 50.0) > 0.0);
    if (hit.share >= 1.0) continue;
    ++met;
    CHECK(apart(hit.share) < 1.1e-3);
  }
  CHECK(met > 50);
}

TEST_CASE("swing: a body on a hinge moves on its circle within the step", "[collision][analytic]") {
  Random random(4);
  for (int i = 0; i < 100; ++i) {
    const Vec3 hinge = random.vec(2.0);
    const Vec3 arm = random.vec(1.0);
    const Vec3 spin = random.vec(100.0);
    const Quat start = random.quat();
    const auto pose = [&](double t) {
      const Quat turned = tandem::pbd::exp_map(t * kDt * spin);
      return Pose{hinge + turned * arm, turned * start};
    };
    const MotionPath round(pose(0.0), pose(1.0), {spin.cross(arm), spin}, kDt);
    for (const double t : {0.2, 0.5, 0.9}) {
      CHECK((round.at(t).position - pose(t).position).norm() < 1e-9);
      CHECK(round.at(t).orientation.angularDistance(pose(t).orientation) < 1e-9);
    }
  }
}

}  // namespace swing_test
