// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "scenes/pointer_hand.h"

#include "tandem/pbd/portable.h"

namespace tandem::demos {

namespace {

pbd::Vec3 at_most(const pbd::Vec3& way, double length) {
  const double norm = way.norm();
  return norm > length ? pbd::Vec3(way * (length / norm)) : way;
}

}  // namespace

void PointerHand::follow(const pbd::Vec3& wanted, const pbd::Vec3& held, double dt) {
  // A critically damped spring pulls the hand to the pointer: its exact motion over a step.
  constexpr double kRate = 1.0 / kSmooth;
  const pbd::Vec3 behind = smooth_ - wanted;
  const pbd::Vec3 drift = (velocity_ + kRate * behind) * dt;
  const double left = pbd::portable::exp(-kRate * dt);
  velocity_ = left * (velocity_ - kRate * drift);
  smooth_ = wanted + left * (behind + drift);
  anchor_ += at_most(smooth_ - anchor_, kFastest * dt);
  anchor_ = held + at_most(anchor_ - held, kReach);
}

}  // namespace tandem::demos
