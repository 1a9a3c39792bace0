// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>

#include "tandem/pbd/types.h"

namespace tandem::consensus {

/// A user's hand motion separated from tremor: a Kalman filter of positions that are known exactly
/// and are the sum of motion and tremor. The motion's acceleration decays within 0.2 s
/// [singer1970]; tremor is a damped oscillation at 10 Hz driven by noise.
class HandFilter {
 public:
  struct Motion {
    pbd::Vec3 position = pbd::Vec3::Zero();      ///< m, world
    pbd::Vec3 velocity = pbd::Vec3::Zero();      ///< m/s
    pbd::Vec3 acceleration = pbd::Vec3::Zero();  ///< m/s^2

    /// @param dt  s, >= 0. The motion expected then: the acceleration decays.
    Motion after(double dt) const;
  };

  HandFilter() = default;
  /// Begins a motion.
  HandFilter(const pbd::Vec3& position, const pbd::Vec3& velocity);

  /// @param dt  s since the last position. A motion begins anew if the clock went back or stood
  /// still, or after 0.3 s of silence.
  /// @param velocity  m/s, used if a motion begins
  void add(double dt, const pbd::Vec3& position, const pbd::Vec3& velocity);
  const Motion& motion() const { return motion_; }

 private:
  /// For one axis: position, velocity, acceleration, tremor (m) and its rate (m/s). All axes share
  /// it, as it depends on times alone.
  using Covariance = std::array<std::array<double, 5>, 5>;

  Motion motion_;
  std::array<pbd::Vec3, 2> tremor_ = {pbd::Vec3::Zero(), pbd::Vec3::Zero()};
  Covariance covariance_ = {};
};

}  // namespace tandem::consensus
