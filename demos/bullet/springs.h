// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <span>
#include <vector>

#include "tandem/pbd/body.h"
#include "tandem/pbd/tether.h"

namespace tandem::demos {

/// Users' springs on one body as impulses before the step, for an engine without such springs.
/// Stretch and speed are implicit (end of the step), so any stiffness is stable. Gravity and
/// contacts are assumed to act as in the last step.
class SpringPulls {
 public:
  /// Changes the twist. @param dt  s, > 0
  void pull(std::span<const pbd::Tether::Def> springs, const pbd::BodyProps& props, double dt,
            pbd::BodyState& state);
  /// Learns from the twist that the engine made of `before`. @param dt  s, of the step
  void learn(const pbd::Twist& before, const pbd::Twist& after, double dt);
  /// Resets. @param gravity  m/s^2
  void start(const pbd::Vec3& gravity) { others_ = {gravity, pbd::Vec3::Zero()}; }

 private:
  pbd::Twist others_;  ///< m/s^2 and rad/s^2, without the springs
  std::vector<pbd::Vec3> impulses_;
};

}  // namespace tandem::demos
