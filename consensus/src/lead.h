// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "tandem/consensus/transport.h"

namespace tandem::consensus {

/// Orientations far apart have no useful average: two peers that pull a cube onto different faces
/// would hold it on its edge for ever. Then the lower id leads and the higher follows.
/// One object for each shared body.
class Lead {
 public:
  /// The share that is left of `share` while an average makes sense, and what a leader gives and a
  /// follower hears beyond.
  /// @param angle  rad, between the own orientation at the stamp and the remote one
  double share(double share, double angle, bool follows, SessionTime now);

 private:
  SessionTime since_ = 0;  ///< when the leader's orientation was last close; 0 = never
};

}  // namespace tandem::consensus
