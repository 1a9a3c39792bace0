// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "tandem/pbd/math.h"

namespace tandem::demos {

/// Where the hand of a mouse or finger is, given where the pointer is: as pages of rooms have it
/// (tools/room/page/hand.js). It does not leap, and a long pull tows and does not throw.
class PointerHand {
 public:
  /// s. A pointer moves in steps, one for each picture, and others would carry each on as if it
  /// lasted. With records of pointers in `cubes`, profile 3, copies of what moves are 8 mm apart in
  /// place of 17 (p95) and jump 181 times a minute in place of 1150; with 0.02 s 10 mm and 277,
  /// with 0.05 s 7 mm and 76. The hand is late by twice as much.
  static constexpr double kSmooth = 0.03;
  static constexpr double kFastest = 2.0;  ///< m/s
  /// m, from the point that it holds. A spring as stiff as single_spring() pulls with all its force
  /// from 4 cm on; a hand that is farther ahead would pull on after the body has come to where the
  /// pointer wants it.
  static constexpr double kReach = 0.1;

  /// @param at  m, world
  explicit PointerHand(const pbd::Vec3& at = pbd::Vec3::Zero()) : smooth_(at), anchor_(at) {}

  /// A step on. @param wanted  m, world: the pointer @param held  m, world: the point that it holds
  void follow(const pbd::Vec3& wanted, const pbd::Vec3& held, double dt);
  /// m, world.
  const pbd::Vec3& anchor() const { return anchor_; }

 private:
  pbd::Vec3 smooth_;                        ///< m, world: the pointer without its steps
  pbd::Vec3 velocity_ = pbd::Vec3::Zero();  ///< m/s, of that
  pbd::Vec3 anchor_;
};

}  // namespace tandem::demos
