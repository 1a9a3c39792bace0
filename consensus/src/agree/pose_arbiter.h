// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

namespace tandem::consensus {

/// Orientations far apart have no useful average: two peers that pull a cube onto different faces
/// would hold it on its edge for ever. Then the lower id leads and the higher follows.
class PoseArbiter {
 public:
  /// rad: closer orientations are an average's business, further apart than the second nothing is
  /// left of a weight, and between them leading grows. With either three times as large cubes on
  /// different faces do not come together (tests/consensus/jump_test.cpp, peer_agreement_test.cpp).
  static constexpr double kFromAngle = 0.6;
  static constexpr double kToAngle = 1.2;

  /// The weight that is left of `weight` while an average makes sense, and what a leader gives and
  /// a follower hears beyond.
  /// @param angle  rad, between the own orientation at the stamp and the remote one
  static double weight(double weight, double angle, bool follows);
};

}  // namespace tandem::consensus
