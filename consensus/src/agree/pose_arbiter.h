// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

namespace tandem::consensus {

/// Orientations far apart have no useful average: two peers that pull a cube onto different faces
/// would hold it on its edge for ever. The lower id then leads and the higher follows.
class PoseArbiter {
 public:
  /// rad: below kFromAngle orientations are averaged, above kToAngle a leader ignores the other
  /// state, and between them leading grows. With either three times as large cubes on different
  /// faces do not come together (tests/consensus/jump_test.cpp, peer_agreement_test.cpp).
  static constexpr double kFromAngle = 0.6;
  static constexpr double kToAngle = 1.2;

  /// What is left of `weight`: all of it below kFromAngle; beyond, less for a leader and more for a
  /// follower.
  /// @param angle  rad, between the local orientation at the stamp and the remote one
  static double weight(double weight, double angle, bool follows);
};

}  // namespace tandem::consensus
