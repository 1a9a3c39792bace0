// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "tandem/pbd/math.h"

namespace tandem::demos {

/// The position of a hand that follows a mouse or finger, as in the rooms' page
/// (tools/room/page/hand.js). It does not jump, and a long pull tows instead of throwing.
class PointerHand {
 public:
  /// s. A pointer moves in steps, once per picture, and other peers would extrapolate each step.
  /// With recorded pointers in `cubes`, profile 3, copies of moving bodies are 8 mm apart instead
  /// of 17 (p95) and pop 181 times a minute instead of 1150. The hand lags by twice this time.
  static constexpr double kSmooth = 0.03;
  static constexpr double kFastest = 2.0;  ///< m/s
  /// m, from the held point. A spring as stiff as single_spring() is at its maximum force from 4 cm
  /// on; a hand farther ahead would pull on after the body reached the pointer.
  static constexpr double kReach = 0.1;

  /// @param at  m, world
  explicit PointerHand(const pbd::Vec3& at = pbd::Vec3::Zero()) : smooth_(at), anchor_(at) {}

  /// One step. @param wanted  m, world: the pointer @param held  m, world: the held point
  void follow(const pbd::Vec3& wanted, const pbd::Vec3& held, double dt);
  /// m, world.
  const pbd::Vec3& anchor() const { return anchor_; }

 private:
  pbd::Vec3 smooth_;                        ///< m, world: the smoothed pointer
  pbd::Vec3 velocity_ = pbd::Vec3::Zero();  ///< m/s, of smooth_
  pbd::Vec3 anchor_;
};

}  // namespace tandem::demos
