// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "tandem/consensus/transport.h"
#include "tandem/pbd/types.h"

namespace tandem::consensus {

/// Orientations far apart have no useful average: two peers that pull a cube onto different faces
/// would hold it on its edge for ever. Then the lower id leads and the higher follows.
/// One object for each shared body.
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

  /// Something solid between two copies keeps them apart for ever: no average brings a ball through
  /// a table, and none turns a cube over its edge. Whether the follower's has been held back in the
  /// same way for so long that it had better be put where the leader has it, whatever is in
  /// between. Where that was in vain, since the follower's surroundings are others, it is left
  /// alone.
  /// @param missing  m, from the follower's copy to the leader's     @param turn  rad, likewise
  /// @param blocked  agreement could not move the follower's in the last step
  bool parted(const pbd::Vec3& missing, const pbd::Vec3& turn, bool blocked, SessionTime now);

 private:
  /// Something that is missing and does not become less.
  class Stuck {
   public:
    /// @param least     less counts as nothing
    /// @param patience  ns
    bool look(const pbd::Vec3& missing, double least, SessionTime patience, SessionTime now);

   private:
    SessionTime waits_ = 0;     ///< ns, since then nothing has become better; 0 = all is well
    SessionTime together_ = 0;  ///< ns, since when nothing is missing; 0 = something is
    pbd::Vec3 missed_ = pbd::Vec3::Zero();   ///< when it began to wait
    pbd::Vec3 in_vain_ = pbd::Vec3::Zero();  ///< what was missing when it was put there; 0 = never
  };

  Stuck apart_;
  Stuck turned_;
};

}  // namespace tandem::consensus
