// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "gjk.h"
#include "tandem/collision/triangle_mesh.h"
#include "tandem/pbd/body.h"

namespace tandem::collision {

/// The path of a body within a step, of which only both ends are known. Rotation is uniform; the
/// origin moves straight or, if its initial velocity says so, about an axis, like a body on a
/// hinge.
class MotionPath {
 public:
  /// @param twist  at the start     @param dt  s
  MotionPath(const pbd::Pose& from, const pbd::Pose& to, const pbd::Twist& twist, double dt);
  /// A body at rest.
  explicit MotionPath(const pbd::Pose& pose) : from_(pose) {}

  /// Pose after the share `t` of the step.
  pbd::Pose at(double t) const;
  /// m per step, bound on the speed of points within `reach` of the origin along the unit direction
  /// n.
  double speed(const Vec3& n, double reach) const;
  /// Bounds of the path of points within `reach` of the origin.
  Aabb bounds(double reach) const;

 private:
  pbd::Pose from_;
  Vec3 turn_ = Vec3::Zero();  ///< rad in the step, world
  Vec3 go_ = Vec3::Zero();    ///< m in the step, uniform
  Vec3 arm_ = Vec3::Zero();   ///< m, from the axis to the origin at the start; 0: straight path
};

/// A convex part of a moving body.
struct MovingCore {
  ConvexCore core;     ///< in the body's frame
  double reach = 0.0;  ///< m, farthest point from the body's origin
  MotionPath path{pbd::Pose{}};
  double stop = 1.0;  ///< share of the step at which the body stops
};

struct SweepHit {
  double apart = 0.0;           ///< m, at the start; <= 0: touching, nothing else is set
  double share = 1.0;           ///< of the step; 1: they do not meet
  Vec3 normal = Vec3::UnitZ();  ///< unit, world, out of b, where they meet
};

/// When a, on its path, comes nearer to b than `gap` (m), or than half of their initial distance if
/// that is less. Conservative advancement with rotation: until the returned share they are further
/// apart. Source: [mirtich1996].
SweepHit sweep(const MovingCore& a, const MovingCore& b, double gap);

}  // namespace tandem::collision
