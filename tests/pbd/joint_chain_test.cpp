// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <Eigen/Dense>

#include "joint_fixture.h"
#include "support/catch.h"
#include "support/targets.h"

namespace joint_chain_test {

using namespace tandem::pbd;
using namespace tandem::testing;

TEST_CASE("joint chain: 50 links and a ball of any mass swing down without parting",
          "[pbd][joint][analytic][long]") {
  for (const double mass : {1.0, 100.0, 1000.0, 1e5}) {
    for (const double compliance : {0.0, 1e-12}) {
      Rope rope(50, mass, compliance);
      Solver solver({.substeps = 4, .sleep_after = 0.0});
      const double energy = rope.world.mechanical_energy();
      double drift = 0.0;
      double separation = 0.0;
      run(rope.world, solver, 1.5, [&] {
        drift = std::max(drift, std::abs(rope.world.mechanical_energy() - energy));
        for (std::size_t i = 1; i < rope.bodies.size(); ++i) {
          const Pose& a = rope.world.pose(rope.bodies[i - 1]);
          const Pose& b = rope.world.pose(rope.bodies[i]);
          const double half = i + 1 < rope.bodies.size() ? 0.5 * Rope::kLink : 0.3;
          separation = std::max(separation, (a.to_world(Vec3(0.5 * Rope::kLink, 0.0, 0.0)) -
                                             b.to_world(Vec3(-half, 0.0, 0.0)))
                                                .norm());
        }
      });
      INFO("end mass " << mass << ", compliance " << compliance << ": separation " << separation
                       << " m, energy " << drift / rope.swing_energy);
      CHECK(separation < 1e-5);
      CHECK(drift < 0.005 * rope.swing_energy);
    }
  }
}

TEST_CASE("joint chain: the ball is where the equations of motion put it",
          "[pbd][joint][analytic]") {
  // After 1, 2, 3, 4 and 5 s; reduced coordinates, fourth order, 64 steps for each 1/60 s.
  const Vec3 expected[] = {Vec3(9.13896, 0.0, -4.72385), Vec3(-1.53253, 0.0, -10.17951),
                           Vec3(-9.84316, 0.0, -2.99100), Vec3(-10.25605, 0.0, -0.22315),
                           Vec3(-7.87329, 0.0, -6.62080)};
  Rope rope(50, 1000.0);
  Solver solver({.substeps = 4, .sleep_after = 0.0});
  for (const Vec3& position : expected) {
    run(rope.world, solver, 1.0);
    CHECK((rope.world.pose(rope.bodies.back()).position - position).norm() < 0.05);
  }
}

TEST_CASE("joint chain: in a hanging chain each joint carries all links below it",
          "[pbd][joint][analytic]") {
  World world;
  auto& joints = world.add_block<JointBlock>();
  std::vector<JointId> ids;
  BodyId before;
  for (int i = 0; i < 8; ++i) {
    const BodyId link =
        world.add_body(box_def(1.0, Vec3(0.03, 0.03, 0.1), Vec3(0.0, 0.0, -0.2 * (i + 0.5))));
    ids.push_back(joints.add(world, ball_joint_at(world, before, link, Vec3(0.0, 0.0, -0.2 * i))));
    before = link;
  }
  Solver solver({.substeps = 10, .sleep_after = 0.0});
  run(world, solver, 0.5);
  for (int i = 0; i < 8; ++i) {
    const Vec3 weight(0.0, 0.0, kGravity * (8 - i));
    CHECK((joints.at(ids[static_cast<std::size_t>(i)]).force - weight).norm() < 1e-6);
  }
  CHECK((world.pose(before).position - Vec3(0.0, 0.0, -1.5)).norm() < 1e-6);
}

namespace {

/// A chain of balls on the world, written down again: one unknown for each component of each force,
/// all gaps of a substep closed by Newton's method with a numerical derivative.
struct DenseChain {
  struct Ball {
    double mass, inertia;
    BodyState state;
    Vec3 front_l, back_l;  ///< m, where it hangs and where the next one hangs
  };
  std::vector<Ball> balls;

  /// Final positions of the balls under forces lambda (N s^2); their lever arms are those of the
  /// start of the substep.
  std::vector<BodyState> moved(const Eigen::VectorXd& lambda, double h) const {
    std::vector<BodyState> ends;
    for (std::size_t i = 0; i < balls.size(); ++i) {
      const Ball& ball = balls[i];
      BodyState end = ball.state;
      const auto row = static_cast<Eigen::Index>(3 * i);
      const Vec3 front = lambda.segment<3>(row);
      const Vec3 back = i + 1 < balls.size() ? Vec3(-lambda.segment<3>(row + 3)) : Vec3::Zero();
      const Quat q = end.pose.orientation;
      const Vec3 dx = (front + back) / ball.mass;
      const Vec3 turned =
          ((q * ball.front_l).cross(front) + (q * ball.back_l).cross(back)) / ball.inertia;
      end.pose.position += h * end.twist.linear + dx;
      end.pose.orientation = turn(turned + h * end.twist.angular) * q;  // a kick, then free turning
      end.twist.linear += dx / h;
      end.twist.angular += turned / h;
      ends.push_back(end);
    }
    return ends;
  }
  Eigen::VectorXd gaps(const std::vector<BodyState>& ends) const {
    Eigen::VectorXd gaps(static_cast<Eigen::Index>(3 * ends.size()));
    Vec3 hook = Vec3::Zero();
    for (std::size_t i = 0; i < ends.size(); ++i) {
      gaps.segment<3>(static_cast<Eigen::Index>(3 * i)) =
          ends[i].pose.to_world(balls[i].front_l) - hook;
      hook = ends[i].pose.to_world(balls[i].back_l);
    }
    return gaps;
  }
  void step(double h) {
    Eigen::VectorXd lambda = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(3 * balls.size()));
    for (int iteration = 0; iteration < 8; ++iteration) {
      Eigen::MatrixXd slope(lambda.size(), lambda.size());
      for (Eigen::Index k = 0; k < lambda.size(); ++k) {
        const Eigen::VectorXd nudge = 1e-6 * Eigen::VectorXd::Unit(lambda.size(), k);
        slope.col(k) = (gaps(moved(lambda + nudge, h)) - gaps(moved(lambda - nudge, h))) / 2e-6;
      }
      lambda -= slope.partialPivLu().solve(gaps(moved(lambda, h)));
    }
    const std::vector<BodyState> ends = moved(lambda, h);
    for (std::size_t i = 0; i < balls.size(); ++i) balls[i].state = ends[i];
  }
};

}  // namespace

TEST_CASE("joint chain: the sparse solve of a step is the dense one", "[pbd][joint][analytic]") {
  World world(weightless());
  auto& joints = world.add_block<JointBlock>();
  DenseChain dense;
  BodyId before;
  for (int i = 0; i < 6; ++i) {
    BodyDef def = ball_def(1.0 + i, 0.1, Vec3(0.2 * i + 0.1, 0.0, 0.0));
    def.twist = {Vec3(0.0, 0.3 * i, 0.1), Vec3(0.2, 0.1, 0.4 * i)};
    const BodyId link = world.add_body(def);
    joints.add(world, ball_joint_at(world, before, link, Vec3(0.2 * i, 0.0, 0.0)));
    before = link;
    dense.balls.push_back({def.mass,
                           def.inertia(0, 0),
                           {def.pose, def.twist},
                           Vec3(-0.1, 0.0, 0.0),
                           Vec3(0.1, 0.0, 0.0)});
  }
  Solver solver({.joint_iterations = 1000, .joint_tolerance = 1e-15, .refine = false});
  run(world, solver, 0.2);
  const double h = kFrame / solver.options().substeps;
  for (int k = 0; k < 12 * solver.options().substeps; ++k) dense.step(h);
  for (std::uint32_t i = 0; i < world.slot_count(); ++i) {
    const Vec3 expected = dense.balls[i].state.pose.position;
    CHECK((world.states()[i].pose.position - expected).norm() < 1e-9);
  }
}

TEST_CASE("joint chain: arms on a hub hold, and momentum stays", "[pbd][joint][unit][long]") {
  // Twenty arms of two links each on one body: the hub becomes an unknown of its own.
  World world(weightless());
  auto& joints = world.add_block<JointBlock>();
  const BodyId hub = world.add_body(ball_def(5.0, 0.5, Vec3::Zero()));
  std::vector<JointId> ids;
  for (int i = 0; i < 20; ++i) {
    const double angle = 0.1 * kPi * i;
    const Vec3 out(std::cos(angle), std::sin(angle), 0.0);
    BodyId before = hub;
    for (int k = 0; k < 2; ++k) {
      BodyDef def = ball_def(1.0, 0.1, (0.7 + 0.4 * k) * out);
      def.twist.linear = Vec3(0.3 * i, 1.0, 0.2 * (k - 2 * i));
      const BodyId link = world.add_body(def);
      const Vec3 anchor = (0.5 + 0.4 * k) * out;
      if (k == 0) {
        ids.push_back(joints.add(world, ball_joint_at(world, before, link, anchor, out)));
      } else {
        ids.push_back(joints.add(world, hinge_joint_at(world, before, link, anchor, out)));
      }
      before = link;
    }
  }
  const Vec3 p = linear_momentum(world);
  const Vec3 l = angular_momentum(world);
  Solver solver({.substeps = 40, .joint_tolerance = 1e-12});
  double separation = 0.0;
  run(world, solver, 0.5, [&] {
    for (const JointId id : ids) separation = std::max(separation, joints.at(id).residual);
  });
  CHECK(separation < 1e-8);
  CHECK((linear_momentum(world) - p).norm() < 1e-10 * p.norm());
  CHECK((angular_momentum(world) - l).norm() < 1e-9 * l.norm());
}

TEST_CASE("joint chain: a rope between two hooks hangs as a catenary",
          "[pbd][joint][analytic][long]") {
  // 50 links of 0.2 m over a span of 8 m. a sinh(s / a) = half the length, s = 4 m.
  constexpr int kCount = 50;
  const double half_length = 0.5 * kCount * Rope::kLink;
  double a = 4.0;
  for (int i = 0; i < 100; ++i) {
    const double f = a * std::sinh(4.0 / a) - half_length;
    const double slope = std::sinh(4.0 / a) - 4.0 / a * std::cosh(4.0 / a);
    a -= f / slope;
  }
  const double sag = a * (std::cosh(4.0 / a) - 1.0);
  // Start on the catenary, link by link, and let it find its own rest.
  World world;
  auto& joints = world.add_block<JointBlock>();
  std::vector<Vec3> points;
  for (int i = 0; i <= kCount; ++i) {
    const double s = -half_length + Rope::kLink * i;
    points.push_back(Vec3(a * std::asinh(s / a), 0.0, std::sqrt(a * a + s * s)));
  }
  BodyId before;
  for (std::size_t i = 0; i < kCount; ++i) {
    const Vec3 along = points[i + 1] - points[i];
    const double pitch = -std::atan2(along.z(), along.x());
    const BodyId link =
        world.add_body(box_def(1.0, Vec3(0.1, 0.025, 0.025), 0.5 * (points[i] + points[i + 1]),
                               turn(Vec3(0.0, pitch, 0.0))));
    BallJointDef def = ball_joint_at(world, before, link, points[i]);
    def.frame_b.anchor = Vec3(-0.1, 0.0, 0.0);
    if (i > 0) def.frame_a.anchor = Vec3(0.1, 0.0, 0.0);
    joints.add(world, def);
    before = link;
  }
  BallJointDef hook = ball_joint_at(world, {}, before, points.back());
  hook.frame_b.anchor = Vec3(0.1, 0.0, 0.0);
  joints.add(world, hook);
  Solver solver({.substeps = 10, .sleep_after = 0.0});
  double mean = 0.0;
  int samples = 0;
  run(world, solver, 10.0, [&] {
    double lowest = 1e9;
    for (const BodyState& state : world.states())
      lowest = std::min(lowest, state.pose.position.z());
    mean += lowest;
    ++samples;
  });
  CHECK(points.front().z() - mean / samples == Approx(sag).epsilon(5e-3));
}

TEST_CASE("joint chain: constraints that contradict each other stay bounded and come to rest",
          "[pbd][joint][fault]") {
  World world;
  auto& joints = world.add_block<JointBlock>();
  const BodyId box = world.add_body(box_def(1.0, Vec3(0.5, 0.1, 0.1), Vec3::Zero()));
  joints.add(
      world,
      BallJointDef{.b = box, .frame_a = {Vec3(-1.0, 0.0, 0.0)}, .frame_b = {Vec3(-0.5, 0.0, 0.0)}});
  joints.add(
      world,
      BallJointDef{.b = box, .frame_a = {Vec3(1.0, 0.0, 0.0)}, .frame_b = {Vec3(0.5, 0.0, 0.0)}});
  Solver solver({.substeps = 10, .sleep_after = 0.0});
  bool finite = true;
  run(world, solver, 3.0, [&] { finite = finite && world.pose(box).position.allFinite(); });
  CHECK(finite);
  CHECK(world.pose(box).position.norm() < 1e-3);
  CHECK(world.twist(box).linear.norm() < 1e-3);
  CHECK(world.twist(box).angular.norm() < 1e-2);
}

TEST_CASE("joint chain: a slider-crank stays closed", "[pbd][joint][analytic]") {
  World world;
  auto& joints = world.add_block<JointBlock>();
  const Vec3 y = Vec3::UnitY();
  const BodyId crank = world.add_body(box_def(1.0, Vec3(0.15, 0.02, 0.02), Vec3(0.15, 0.0, 0.0)));
  const BodyId rod = world.add_body(box_def(1.0, Vec3(0.4, 0.02, 0.02), Vec3(0.7, 0.0, 0.0)));
  const BodyId piston = world.add_body(box_def(2.0, Vec3(0.1, 0.1, 0.1), Vec3(1.1, 0.0, 0.0)));
  HingeJointDef drive = hinge_joint_at(world, {}, crank, Vec3::Zero(), y);
  drive.axis.motor = {.mode = MotorMode::Velocity, .target = 10.0};
  std::vector<JointId> ids;
  ids.push_back(joints.add(world, drive));
  ids.push_back(joints.add(world, hinge_joint_at(world, crank, rod, Vec3(0.3, 0.0, 0.0), y)));
  ids.push_back(joints.add(world, hinge_joint_at(world, rod, piston, Vec3(1.1, 0.0, 0.0), y)));
  ids.push_back(
      joints.add(world, slider_joint_at(world, {}, piston, Vec3(1.1, 0.0, 0.0), Vec3::UnitX())));
  Solver solver({.substeps = 10, .sleep_after = 0.0});
  double closure = 0.0;
  double error = 0.0;
  run(world, solver, 10.0, [&] {
    for (const JointId id : ids) closure = std::max(closure, joints.at(id).residual);
    const double angle = joints.at(ids[0]).position[3];
    const double exact =
        0.3 * std::cos(angle) + std::sqrt(0.64 - 0.09 * std::sin(angle) * std::sin(angle));
    error = std::max(error, std::abs(world.pose(piston).position.x() - exact));
  });
  INFO("closure " << closure << ", piston " << error);
  CHECK(closure < 1e-6);
  CHECK(error < 1e-6);
  CHECK(joints.at(ids[0]).position[3] == Approx(100.0).epsilon(1e-3));
}

TEST_CASE("joint chain: a snapshot goes on bit for bit", "[pbd][joint][unit]") {
  const auto build = [](World& world) {
    auto& joints = world.add_block<JointBlock>();
    BodyId before;
    for (int i = 0; i < 5; ++i) {
      const BodyId link =
          world.add_body(box_def(1.0, Vec3(0.1, 0.03, 0.02), Vec3(0.2 * i + 0.1, 0.0, 0.0)));
      const Vec3 anchor(0.2 * i, 0.0, 0.0);
      if (i % 2 == 0) {
        BallJointDef def = ball_joint_at(world, before, link, anchor);
        def.cone = 0.4;
        joints.add(world, def);
      } else {
        HingeJointDef def = hinge_joint_at(world, before, link, anchor, Vec3(0.0, 1.0, 0.2));
        def.axis.spring = {.stiffness = 0.3, .damping = 0.01};
        joints.add(world, def);
      }
      before = link;
    }
  };
  World one;
  World two;
  build(one);
  build(two);
  Solver solver({.substeps = 10, .sleep_after = 0.0});
  run(one, solver, 0.5);
  two.restore(one.snapshot());
  run(one, solver, 0.5);
  run(two, solver, 0.5);
  CHECK(one.hash() == two.hash());
  CHECK(one.snapshot() == two.snapshot());
}

TEST_CASE("joint chain: agreement moves it without motion and without parting it",
          "[pbd][joint][consensus]") {
  for (const int substeps : {1, 4, 10}) {
    World world(weightless());
    FixedTargets source;
    auto& joints = world.add_block<JointBlock>();
    std::vector<BodyId> bodies;
    std::vector<JointId> ids;
    for (int i = 0; i < 4; ++i) {
      bodies.push_back(world.add_body(box_def(1.0 + i, Vec3(0.5, 0.2, 0.3), Vec3(i, 0.0, 0.0))));
      if (i == 0) continue;
      const Vec3 anchor(i - 0.5, 0.1, 0.0);
      const BodyId a = bodies[bodies.size() - 2];
      if (i == 1) ids.push_back(joints.add(world, fixed_joint_at(world, a, bodies.back(), anchor)));
      if (i == 2) {
        HingeJointDef def = hinge_joint_at(world, a, bodies.back(), anchor, Vec3::UnitZ());
        def.axis.freedom = Freedom::Limited;  // at its stop
        def.axis.upper = 0.5;
        ids.push_back(joints.add(world, def));
      }
      if (i == 3) {
        ids.push_back(joints.add(world, ball_joint_at(world, a, bodies.back(), anchor)));
      }
    }
    source.targets = {{.body = bodies[0],
                       .pose = {Vec3(0.0, 0.1, 0.05), turn(Vec3(0.1, 0.2, 0.3))},
                       .share = 0.3}};
    world.set_target_source(&source);
    Solver solver({.substeps = substeps});
    double parted = 0.0;
    double energy = 0.0;
    run(world, solver, 1.0, [&] {
      for (const JointId id : ids) parted = std::max(parted, joints.at(id).residual);
      energy = std::max(energy, world.kinetic_energy());
    });
    INFO("parted " << parted << ", energy " << energy);
    CHECK(parted < 1e-5);
    CHECK(energy < 1e-12);
    CHECK((world.pose(bodies[0]).position - Vec3(0.0, 0.1, 0.05)).norm() < 0.03);
    source.targets.clear();
    run(world, solver, 0.5);
    CHECK(world.kinetic_energy() < 1e-8);
  }
}

}  // namespace joint_chain_test
