// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "tandem/consensus/predictor.h"

namespace tandem::consensus::detail {

// Copies of what swings differ by something that swings as well: when news of it comes, it has
// turned. For one mode of angular frequency w, after an age A
//   y = cos(wA) apart + sin(wA)/(wA) drift,   drift = A times the difference of velocities,
// and both parts are found by least squares from what was seen. Where many modes are mixed they
// explain little, and little is believed: whatever the delay, no linear rule with one answer for
// all modes is stable for every frequency.

/// Take in a state: compare what was expected at times up to its stamp.
/// @param before, at  stamp (ns) and position (m) of the state before; 0 = none
void learn(SwingFit& fit, SessionTime before, const pbd::Vec3& at, const StateUpdate& update);

/// Remember what is seen now (ns), to learn from it. @param age  s, of what is seen
void expect(SwingFit& fit, SessionTime now, double age, const pbd::Vec3& own,
            const pbd::Vec3& apart, const pbd::Vec3& drift);

/// How much of a difference, and of its drift, is to be believed.
struct SwingParts {
  double apart = 1.0;
  double drift = 0.0;
};
/// 0 to 1 each; 1 and 0 where nothing is known.
SwingParts parts_of(const SwingFit& fit);

}  // namespace tandem::consensus::detail
