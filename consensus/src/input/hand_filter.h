// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>

#include "tandem/pbd/types.h"

namespace tandem::consensus {

/// Where a user's hand is going, apart from its tremor: a Kalman filter of places that are known
/// exactly. A place is a motion plus tremor. The motion's acceleration comes and goes within 0.2 s
/// [singer1970]; tremor is a damped oscillation at 10 Hz that noise keeps going.
class HandFilter {
 public:
  struct Motion {
    pbd::Vec3 position = pbd::Vec3::Zero();      ///< m, world
    pbd::Vec3 velocity = pbd::Vec3::Zero();      ///< m/s
    pbd::Vec3 acceleration = pbd::Vec3::Zero();  ///< m/s^2

    /// @param dt  s, >= 0. What is expected then: the acceleration fades.
    Motion after(double dt) const;
  };

  HandFilter() = default;
  /// A motion that begins.
  HandFilter(const pbd::Vec3& position, const pbd::Vec3& velocity);

  /// @param dt  s since the last place. A clock that went back or stood begins a motion anew, and a
  ///            silence of more than 0.3 s does.
  /// @param velocity  m/s, of a motion that begins
  void add(double dt, const pbd::Vec3& position, const pbd::Vec3& velocity);
  const Motion& motion() const { return motion_; }

 private:
  /// Of one axis: position, velocity, acceleration, tremor (m) and its rate (m/s). The axes share
  /// it, as it depends on the times alone.
  using Covariance = std::array<std::array<double, 5>, 5>;

  Motion motion_;
  std::array<pbd::Vec3, 2> tremor_ = {pbd::Vec3::Zero(), pbd::Vec3::Zero()};
  Covariance covariance_ = {};
};

}  // namespace tandem::consensus
