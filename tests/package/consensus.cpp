// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <array>
#include <cmath>
#include <cstdio>

#include "tandem/consensus/aggregate.h"
#include "tandem/pbd/joint.h"
#include "tandem/pbd/solver.h"

// A shared pendulum without shapes: a joint, a remote state, and one step.
int main() {
  using namespace tandem;
  pbd::World world;
  const pbd::BodyId ball = world.add_body({.pose = {.position = pbd::Vec3(0, 0, -1)}});
  auto& joints = world.add_block<pbd::JointBlock>();
  joints.add(world, pbd::BallJointDef{.b = ball, .frame_b = {pbd::Vec3(0, 0, 1)}});
  pbd::Solver solver;
  if (solver.step(world, 1.0 / 60.0).status != pbd::StepStatus::Ok) return 1;

  std::array<consensus::PeerEstimate, 1> remote;
  remote[0] = {.peer = 2, .pose = {.position = pbd::Vec3(0.1, 0, -1)}, .share = 0.5};
  pbd::PoseTarget target;
  if (!consensus::fuse(world.pose(ball), remote, target)) return 1;
  std::printf("consensus: target at x = %.3f m with share %.3f\n", target.pose.position.x(),
              target.share);
  return std::abs(target.pose.position.x() - 0.1) < 1e-12 && std::abs(target.share - 0.5) < 1e-12
             ? 0
             : 1;
}
