// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "tandem/pbd/body.h"
#include "tandem/pbd/math.h"
#include "tandem/pbd/pose_target.h"

/// States of a body and their differences (translation, rotation and twist), in world axes.
namespace tandem::consensus {

/// m: lever that turns rotations and spins into distances and speeds.
inline constexpr double kLeverArm = 0.1;

inline pbd::Twist difference(const pbd::Twist& a, const pbd::Twist& b) {
  return {a.linear - b.linear, a.angular - b.angular};
}

/// The correction from `from` to `to`.
inline pbd::Correction gap(const pbd::BodyState& from, const pbd::BodyState& to) {
  return {to.pose.position - from.pose.position,
          pbd::rotation_between(from.pose.orientation, to.pose.orientation),
          difference(to.twist, from.twist)};
}

/// `state` after `part` of a correction.
inline pbd::BodyState moved(const pbd::BodyState& state, const pbd::Correction& gap,
                            double part = 1.0) {
  return {{state.pose.position + part * gap.translation,
           pbd::rotated(state.pose.orientation, part * gap.rotation)},
          {state.twist.linear + part * gap.twist.linear,
           state.twist.angular + part * gap.twist.angular}};
}

/// `state` after `dt` s at its twist.
inline pbd::BodyState carried(const pbd::BodyState& state, double dt) {
  return {{state.pose.position + dt * state.twist.linear,
           pbd::rotated(state.pose.orientation, dt * state.twist.angular)},
          state.twist};
}

/// The mean of `own` and the states fused relative to it.
inline pbd::BodyState mean_with(const pbd::BodyState& own, const pbd::PoseTarget& fused) {
  return moved(own,
               pbd::Correction{fused.pose.position - own.pose.position, fused.rotation_error,
                               difference(fused.twist, own.twist)},
               fused.share);
}

/// rad: twice the sine of half the angle; for small angles, the angle.
inline double small_angle(const pbd::Quat& a, const pbd::Quat& b) {
  return 2.0 * (a.conjugate() * b).vec().norm();
}

/// m, rad: a body at rest stays within these of one place. At three times the distance damped
/// bodies are declared at rest 4 mm short of their end (tests/consensus/sending_test.cpp).
inline constexpr double kRestDistance = 5e-4;
inline constexpr double kRestAngle = 2e-3;

/// Whether a body is slow enough to be at rest.
inline bool is_slow(const pbd::Twist& twist) {
  constexpr double kSpeed = 0.01;  // m/s
  constexpr double kSpin = 0.02;   // rad/s
  return twist.linear.squaredNorm() < kSpeed * kSpeed &&
         twist.angular.squaredNorm() < kSpin * kSpin;
}

/// m/s, including spin at kLeverArm.
inline double speed(const pbd::Twist& twist) {
  return twist.linear.norm() + kLeverArm * twist.angular.norm();
}

}  // namespace tandem::consensus
