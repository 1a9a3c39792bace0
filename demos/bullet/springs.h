// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <span>
#include <vector>

#include "tandem/pbd/body.h"
#include "tandem/pbd/tether.h"

namespace tandem::demos {

/// Users' springs on one body, as impulses before the step of an engine that has no such springs.
/// Stretch and speed are taken at the end of the step, so that no spring is too stiff for it; what
/// gravity and contacts are going to do until then is taken from what they did in the step before.
class SpringPulls {
 public:
  /// Changes the twist. @param dt  s, > 0
  void pull(std::span<const pbd::Tether::Def> springs, const pbd::BodyProps& props, double dt,
            pbd::BodyState& state);
  /// What came of the twist that was handed over. @param dt  s, of the step
  void learn(const pbd::Twist& before, const pbd::Twist& after, double dt);
  /// Nothing is known yet. @param gravity  m/s^2
  void start(const pbd::Vec3& gravity) { others_ = {gravity, pbd::Vec3::Zero()}; }

 private:
  pbd::Twist others_;  ///< m/s^2 and rad/s^2, by all but springs
  std::vector<pbd::Vec3> impulses_;
};

}  // namespace tandem::demos
