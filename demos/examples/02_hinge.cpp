// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// A joint. A rod swings on a hinge; its period is that of a physical pendulum.
#include <cmath>
#include <cstdio>
#include <numbers>

#include "tandem/pbd/joint.h"
#include "tandem/pbd/solver.h"

int main() {
  using namespace tandem::pbd;

  constexpr double kLength = 1.0;                          // m
  constexpr double kMass = 3.0;                            // kg
  constexpr double kAngle = 0.2;                           // rad, at the start
  const double across = kMass * kLength * kLength / 12.0;  // kg m^2, about the middle

  // The hinge is at the origin with its axis along y; the rod starts at kAngle.
  World world;
  const Quat turned(Eigen::AngleAxisd(kAngle, Vec3::UnitY()));
  const BodyId rod = world.add_body(
      {.pose = {.position = turned * Vec3(0.0, 0.0, -0.5 * kLength), .orientation = turned},
       .mass = kMass,
       .inertia = Vec3(across, across, 1e-3 * across).asDiagonal()});
  auto& joints = world.add_block<JointBlock>();
  // A default-constructed body id stands for the world.
  joints.add(world, hinge_joint_at(world, {}, rod, Vec3::Zero(), Vec3::UnitY()));

  Solver solver;
  constexpr double kStep = 1.0 / 60.0;  // s
  double first = 0.0;                   // s, first pass through the middle
  double last = 0.0;
  int passes = 0;
  for (double before = world.pose(rod).position.x(); world.time() < 20.0;) {
    if (solver.step(world, kStep).status != StepStatus::Ok) return 1;
    const double x = world.pose(rod).position.x();
    if (before * x < 0.0) {
      last = world.time() - kStep * x / (x - before);
      if (passes == 0) first = last;
      ++passes;
    }
    before = x;
  }

  // T = 2 pi sqrt(I / (m g l)) for small angles, plus angle^2 / 16 of it for larger ones.
  const double measured = 2.0 * (last - first) / (passes - 1);
  const double inertia = across + kMass * 0.25 * kLength * kLength;
  const double small = 2.0 * std::numbers::pi * std::sqrt(inertia / (kMass * 9.81 * 0.5 * kLength));
  const double formula = small * (1.0 + kAngle * kAngle / 16.0);
  const double length = world.pose(rod).position.norm();
  std::printf("%d passes: period %.4f s (formula %.4f), middle %.6f m from the hinge\n", passes,
              measured, formula, length);
  return std::abs(measured / formula - 1.0) < 2e-3 && std::abs(length - 0.5) < 1e-4 ? 0 : 1;
}
