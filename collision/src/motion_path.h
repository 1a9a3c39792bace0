// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "gjk.h"
#include "tandem/collision/triangle_mesh.h"
#include "tandem/pbd/body.h"

namespace tandem::collision {

/// The way of a body within a step, of which only both ends are known. It turns evenly; its origin
/// goes straight or, where that is how it sets out, round an axis, as what hangs on a hinge does.
class MotionPath {
 public:
  /// @param twist  at the start     @param dt  s
  MotionPath(const pbd::Pose& from, const pbd::Pose& to, const pbd::Twist& twist, double dt);
  /// A body that stays.
  explicit MotionPath(const pbd::Pose& pose) : from_(pose) {}

  /// Where it is after the share `t` of the step.
  pbd::Pose at(double t) const;
  /// m in a step: no point within `reach` of the origin goes faster along the unit direction n.
  double speed(const Vec3& n, double reach) const;
  /// Where points within `reach` of the origin come by.
  Aabb bounds(double reach) const;

 private:
  pbd::Pose from_;
  Vec3 turn_ = Vec3::Zero();  ///< rad in the step, world
  Vec3 go_ = Vec3::Zero();    ///< m in the step, evenly
  Vec3 arm_ = Vec3::Zero();   ///< m, from the axis to the origin at the start; 0: straight
};

/// A convex part of a body on its way.
struct MovingCore {
  ConvexCore core;     ///< in the body's frame
  double reach = 0.0;  ///< m, farthest point from the body's origin
  MotionPath path{pbd::Pose{}};
  double stop = 1.0;  ///< share of the step after which the body stays where it is
};

struct SweepHit {
  double apart = 0.0;           ///< m, at the start; <= 0: touching, nothing else is set
  double share = 1.0;           ///< of the step; 1: they do not meet
  Vec3 normal = Vec3::UnitZ();  ///< unit, world, out of b, where they meet
};

/// When a, on its way, comes nearer to b than `gap` (m), or than half of what they are apart at the
/// start where that is less. Conservative advancement, turning included: on the way up to the
/// share that is returned they are further apart. Source: [mirtich1996].
SweepHit sweep(const MovingCore& a, const MovingCore& b, double gap);

}  // namespace tandem::collision
