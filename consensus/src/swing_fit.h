// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "tandem/consensus/predictor.h"

namespace tandem::consensus::detail {

// Copies of what swings differ by something that swings as well: when news of it comes, it has
// turned. For one mode of angular frequency w, after an age A
//   y = cos(wA) apart + sin(wA)/(wA) drift,   drift = A times the difference of velocities,
// and both parts are found by least squares from what was seen. No linear rule that has one answer
// for all modes is stable at every frequency: of an undamped one whose difference has turned round
// within the age, each share drives the next. So where the modes are mixed and the fit explains
// little, little is believed, and what is done about it takes energy from the body and gives none.

/// Take in a state: compare what was seen at times up to its stamp with what it came to.
/// @param before, position, velocity  stamp (ns; 0 = there was none), m and m/s of the state before
void learn(SwingFit& fit, SessionTime before, const pbd::Vec3& position, const pbd::Vec3& velocity,
           const StateUpdate& update);

/// Remember what is seen now (ns), to learn from it.
/// @param age  s, of what is seen     @param own  this copy
void expect(SwingFit& fit, SessionTime now, double age, const MotionSample& own,
            const pbd::Vec3& apart, const pbd::Vec3& drift);

/// What is to be believed, 0 to 1.
struct SwingParts {
  double apart = 1.0;     ///< of a difference, in what it is now
  double drift = 0.0;     ///< of its drift, in what it is now
  double velocity = 1.0;  ///< of a difference of velocities, in what that is now
  /// Of what would give the body energy, how much is to be left out.
  double unknown = 0.0;
};
/// As the members are by default where nothing is known.
SwingParts parts_of(const SwingFit& fit);

/// `change` without a part of its component along `way`, where that is forwards.
pbd::Vec3 without_forward(double part, const pbd::Vec3& change, const pbd::Vec3& way);

}  // namespace tandem::consensus::detail
