// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <Eigen/Dense>

#include "support/catch.h"
#include "support/targets.h"
#include "tandem/pbd/distance_joint.h"
#include "tandem/pbd/joint.h"
#include "tandem/pbd/math.h"
#include "tandem/pbd/pose_target.h"

namespace pose_target_joint_test {

using namespace tandem::pbd;
using namespace tandem::testing;

namespace {

struct Wish {
  double weight = 0.0;  ///< W, against the local weight 1
  Vec3 translation = Vec3::Zero();
  Vec3 rotation = Vec3::Zero();
};

/// Boxes at rest in a row along x, joined where they meet by points off the line of centres.
struct Row {
  World world{weightless()};
  FixedTargets source;
  std::vector<BodyId> bodies;
  std::vector<Wish> wishes;
  std::vector<Vec3> anchors;  ///< m, world; anchors[i] joins i and i + 1

  Row(const std::vector<double>& masses, const std::vector<Wish>& wanted, double off_line)
      : wishes(wanted) {
    auto& joints = world.add_block<JointBlock>();
    const Vec3 half(0.5, 0.2, 0.3);
    for (std::size_t i = 0; i < masses.size(); ++i) {
      const Vec3 at(static_cast<double>(i), 0.0, 0.0);
      bodies.push_back(world.add_body(box_def(masses[i], half, at)));
      if (i == 0) continue;
      anchors.push_back(at - Vec3(0.5, off_line, -0.5 * off_line));
      joints.add(world, ball_joint_at(world, bodies[i - 1], bodies[i], anchors.back()));
    }
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      if (wishes[i].weight == 0.0) continue;
      const Pose& pose = world.pose(bodies[i]);
      source.targets.push_back({.body = bodies[i],
                                .pose = {pose.position + wishes[i].translation,
                                         turn(wishes[i].rotation) * pose.orientation},
                                .share = share_of(wishes[i].weight)});
    }
    world.set_target_source(&source);
  }

  /// The constrained optimum: minimise |y - share wish|_M over the moves y = (dx, rotation vector)
  /// of all bodies, such that the joints hold: nearest to where each would be alone. Dense, and
  /// linearised anew at each iterate until it stands still.
  std::vector<Pose> optimum() const {
    const auto n = static_cast<Eigen::Index>(6 * bodies.size());
    const auto m = static_cast<Eigen::Index>(3 * anchors.size());
    Eigen::MatrixXd mass = Eigen::MatrixXd::Zero(n, n);
    Eigen::VectorXd wanted = Eigen::VectorXd::Zero(n);
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      const auto at = static_cast<Eigen::Index>(6 * i);
      const BodyProps& props = world.props(bodies[i]);
      const double share = share_of(wishes[i].weight);
      mass.block<3, 3>(at, at) = props.mass * Mat3::Identity();
      mass.block<3, 3>(at + 3, at + 3) = props.inertia;
      wanted.segment<3>(at) = share * wishes[i].translation;
      wanted.segment<3>(at + 3) = share * wishes[i].rotation;
    }
    Eigen::VectorXd y = Eigen::VectorXd::Zero(n);
    for (int iteration = 0; iteration < 50; ++iteration) {
      Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(m, n);
      Eigen::VectorXd right(m);
      for (std::size_t k = 0; k < anchors.size(); ++k) {
        const auto row = static_cast<Eigen::Index>(3 * k);
        Vec3 gap = Vec3::Zero();
        for (const std::size_t i : {k, k + 1}) {
          const double sign = i == k ? -1.0 : 1.0;
          const auto at = static_cast<Eigen::Index>(6 * i);
          const Pose start = world.pose(bodies[i]);
          const Vec3 r = turn(y.segment<3>(at + 3)) * (anchors[k] - start.position);
          gap += sign * (start.position + y.segment<3>(at) + r);
          jacobian.block<3, 3>(row, at) = sign * Mat3::Identity();
          jacobian.block<3, 3>(row, at + 3) = -sign * skew(r);
        }
        right.segment<3>(row) = -gap;
      }
      y = constrained_least_squares(mass, wanted, jacobian, right + jacobian * y);
    }
    std::vector<Pose> poses;
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      const auto at = static_cast<Eigen::Index>(6 * i);
      const Pose start = world.pose(bodies[i]);
      poses.push_back(
          {start.position + y.segment<3>(at), turn(y.segment<3>(at + 3)) * start.orientation});
    }
    return poses;
  }
};

SolverOptions converged() {
  return {.substeps = 1, .joint_iterations = 1000, .joint_tolerance = 0.0};
}

/// Largest distance between solved and optimal poses, m and rad.
double error_of(const Row& row, const std::vector<Pose>& optimum) {
  double error = 0.0;
  for (std::size_t i = 0; i < row.bodies.size(); ++i) {
    const Pose& pose = row.world.pose(row.bodies[i]);
    error = std::max({error, (pose.position - optimum[i].position).norm(),
                      angle_between(pose.orientation, optimum[i].orientation)});
  }
  return error;
}

}  // namespace

TEST_CASE("pose_target: across a joint the pair moves by the share of the targeted body's mass",
          "[pbd][consensus][analytic]") {
  // The targeted one goes its share s of the gap, the joint then keeps the centre of mass.
  for (const double weight : {0.1, 1.0, 4.0}) {
    for (const double other : {0.2, 1.0, 5.0}) {
      Row row({1.0, other}, {{weight, Vec3(0.1, 0.0, 0.0)}, {}}, 0.0);
      const auto optimum = row.optimum();
      Solver solver(converged());
      solver.step(row.world, kFrame);
      const double expected = 0.1 * weight / (1.0 + weight) / (1.0 + other);
      CHECK(std::abs(row.world.pose(row.bodies[0]).position.x() - expected) < 1e-9);
      CHECK(std::abs(row.world.pose(row.bodies[1]).position.x() - 1.0 - expected) < 1e-9);
      CHECK(error_of(row, optimum) < 1e-9);
    }
  }
}

TEST_CASE("pose_target: converged once a step, jointed bodies reach the constrained optimum",
          "[pbd][consensus][analytic]") {
  const std::vector<std::vector<double>> masses{{1.0, 1.0}, {2.0, 0.3}, {1.0, 4.0, 0.5, 2.0}};
  for (const auto& m : masses) {
    for (const double weight : {0.1, 1.0, 9.0}) {
      std::vector<Wish> wishes(m.size());
      wishes[0] = {weight, Vec3(2.5e-4, -1e-4, 2e-4), Vec3(5e-5, -5e-5, 2.5e-4)};
      wishes.back() = {0.5 * weight, Vec3(-5e-5, 2.5e-4, 0.0), Vec3(0.0, 1.5e-4, -1e-4)};
      Row row(m, wishes, 0.15);
      const auto optimum = row.optimum();
      Solver solver(converged());
      solver.step(row.world, kFrame);
      INFO(m.size() << " bodies, weight " << weight << ", error " << error_of(row, optimum));
      CHECK(error_of(row, optimum) < 1e-6);
      // The wish is far from what the joints allow, or the case would say nothing.
      const Vec3 free = share_of(weight) * wishes[0].translation;
      CHECK((optimum[0].position - free).norm() > 0.05 * free.norm());
    }
  }
}

TEST_CASE("pose_target: the distance to the optimum falls with the square of the gap",
          "[pbd][consensus][analytic]") {
  // The rest is due to the curvature of the joint, not to a lack of convergence.
  std::vector<double> errors;
  for (const double size : {1e-2, 1e-3, 1e-4}) {
    Row row({1.0, 2.0}, {{1.0, Vec3(0.0, size, -0.5 * size), Vec3(0.0, 0.0, size)}, {}}, 0.15);
    const auto optimum = row.optimum();
    Solver solver(converged());
    solver.step(row.world, kFrame);
    errors.push_back(error_of(row, optimum));
  }
  INFO(errors[0] << " " << errors[1] << " " << errors[2]);
  CHECK(errors[0] < 1e-4);
  CHECK(errors[1] < errors[0] / 50.0);
  CHECK(errors[2] < errors[1] / 50.0);
}

TEST_CASE("pose_target: against a spring, once a step, the move is that of both stiffnesses",
          "[pbd][consensus][analytic]") {
  // Minimise (1 + W) m / 2 (x - s gap)^2 + k dt^2 / 2 x^2, the spring's energy for the whole step:
  // x = s gap (1 + W) m / ((1 + W) m + k dt^2).
  for (const double stiffness : {100.0, 5000.0, 1e6}) {
    World world(weightless());
    FixedTargets source;
    auto& rods = world.add_block<DistanceJoints>();
    auto& balls = world.add_block<JointBlock>();
    const BodyId on_rod = world.add_body(box_def(2.0, Vec3(0.2, 0.2, 0.2), Vec3(1.0, 0.0, 0.0)));
    const BodyId on_ball = world.add_body(box_def(2.0, Vec3(0.2, 0.2, 0.2), Vec3(1.0, 5.0, 0.0)));
    rods.add(world, {.b = on_rod, .rest_length = 1.0, .compliance = 1.0 / stiffness});
    BallJointDef soft = ball_joint_at(world, {}, on_ball, Vec3(1.0, 5.0, 0.0));
    soft.compliance = 1.0 / stiffness;
    balls.add(world, soft);
    const double weight = 3.0;
    const double gap = 0.01;
    for (const BodyId id : {on_rod, on_ball}) {
      source.targets.push_back(
          {.body = id,
           .pose = {world.pose(id).position + Vec3(gap, 0.0, 0.0), Quat::Identity()},
           .share = share_of(weight)});
    }
    world.set_target_source(&source);
    Solver solver({.substeps = 1});
    solver.step(world, kFrame);
    const double mass = 2.0;
    const double expected = share_of(weight) * gap * mass / (mass + stiffness * kFrame * kFrame);
    for (const BodyId id : {on_rod, on_ball}) {
      CHECK(world.correction(id).translation.x() == Approx(expected).epsilon(1e-6));
    }
  }
}

TEST_CASE("pose_target: owners that pull at both ends of a chain do not tear it",
          "[pbd][consensus][regression]") {
  // Twelve links, both ends owned, further apart than the chain is long.
  World world(weightless());
  FixedTargets source;
  auto& balls = world.add_block<JointBlock>();
  std::vector<BodyId> links;
  for (int i = 0; i < 12; ++i) {
    links.push_back(world.add_body(box_def(1.0, Vec3(0.5, 0.05, 0.05), Vec3(i, 0.0, 0.0))));
    if (i > 0)
      balls.add(world, ball_joint_at(world, links[links.size() - 2], links.back(),
                                     Vec3(i - 0.5, 0.0, 0.0)));
  }
  source.targets = {
      {.body = links.front(), .pose = {Vec3(-0.9, 1.5, 0.0), Quat::Identity()}, .share = 1.0},
      {.body = links.back(), .pose = {Vec3(12.5, -0.9, 0.0), Quat::Identity()}, .share = 1.0}};
  world.set_target_source(&source);
  Solver solver;
  solver.step(world, kFrame);
  CHECK(solver.step(world, kFrame).blocks[0].residual < 1e-5);
  CHECK((world.pose(links.front()).position - Vec3::Zero()).norm() > 0.1);  // they did pull
  source.targets.clear();
  for (int k = 0; k < 120; ++k) solver.step(world, kFrame);
  CHECK(world.kinetic_energy() < 1e-9);
}

TEST_CASE("pose_target: each substep asks again for the part that the joint took back",
          "[pbd][consensus][analytic]") {
  // Each substep closes its share s_n of what is missing, and the joint gives half of that to the
  // other of two equal bodies: 1 - (1 - s_n / 2)^n of the gap.
  for (const int n : {1, 4, 10}) {
    for (const double weight : {0.1, 1.0, 9.0}) {
      Row row({1.0, 1.0}, {{weight, Vec3(0.1, 0.0, 0.0)}, {}}, 0.0);
      Solver solver({.substeps = n});
      solver.step(row.world, kFrame);
      const double share = 1.0 - std::pow(1.0 - share_of(weight), 1.0 / n);
      const double expected = 0.1 * (1.0 - std::pow(1.0 - 0.5 * share, n));
      CHECK(std::abs(row.world.pose(row.bodies[0]).position.x() - expected) < 1e-9);
    }
  }
}

TEST_CASE("pose_target: displacement carries no kinetic energy, also through a joint",
          "[pbd][consensus][analytic]") {
  for (const int substeps : {1, 4, 10}) {
    const double gap = 0.05;
    Row row({1.0, 3.0, 1.0}, {{2.0, Vec3(0.0, gap, 0.0), Vec3(0.0, 0.3, 0.0)}, {}, {}}, 0.15);
    Solver solver({.substeps = substeps});
    // Against the energy that the same move would have as a motion.
    const double scale = 1.0 * (gap / kFrame) * (gap / kFrame);
    for (int i = 0; i < 60; ++i) {
      const StepReport& report = solver.step(row.world, kFrame);
      INFO("step " << i << ": " << row.world.kinetic_energy() / scale);
      REQUIRE(row.world.kinetic_energy() <= 1e-12 * scale);
      REQUIRE(std::abs(report.energy.displacement) <= 1e-12 * scale);
    }
    CHECK(row.world.pose(row.bodies[0]).position.y() > 0.1 * gap);  // it did move
  }
}

TEST_CASE("pose_target: an owned body drags its joint partner along and the joint holds",
          "[pbd][consensus][unit]") {
  for (const int substeps : {1, 4, 10}) {
    Row row({1.0, 1.0}, {{}, {}}, 0.15);
    row.source.targets.push_back(
        {.body = row.bodies[0], .pose = {Vec3(0.0, 0.02, 0.0), Quat::Identity()}, .share = 1.0});
    Solver solver({.substeps = substeps});
    for (int i = 0; i < 60; ++i) solver.step(row.world, kFrame);
    CHECK((row.world.pose(row.bodies[0]).position - Vec3(0.0, 0.02, 0.0)).norm() < 1e-9);
    const StepReport& report = solver.step(row.world, kFrame);
    CHECK(report.blocks[0].residual < 1e-4);
    CHECK(row.world.kinetic_energy() < 1e-10);
  }
}

TEST_CASE("pose_target: two owned bodies that contradict their joint do no harm",
          "[pbd][consensus][fault]") {
  for (const int substeps : {1, 4, 10}) {
    Row row({1.0, 1.0}, {{}, {}}, 0.0);
    for (int i = 0; i < 2; ++i) {
      row.source.targets.push_back({.body = row.bodies[static_cast<std::size_t>(i)],
                                    .pose = {Vec3(2.0 * i, 0.1, 0.0), Quat::Identity()},
                                    .share = 1.0});
    }
    Solver solver({.substeps = substeps});
    for (int i = 0; i < 60; ++i) {
      REQUIRE(solver.step(row.world, kFrame).status == StepStatus::Ok);
    }
    row.source.targets.clear();  // let go: the joint closes and nothing flies off
    double fastest = 0.0;
    for (int i = 0; i < 60; ++i) {
      solver.step(row.world, kFrame);
      fastest = std::max(fastest, std::sqrt(2.0 * row.world.kinetic_energy()));
    }
    INFO("fastest " << fastest << " m/s");
    CHECK(std::isfinite(fastest));
    const double distance =
        (row.world.pose(row.bodies[1]).position - row.world.pose(row.bodies[0]).position).norm();
    CHECK(distance == Approx(1.0).margin(1e-3));
    CHECK(fastest < 1e-3);
  }
}

}  // namespace pose_target_joint_test
