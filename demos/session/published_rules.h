// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "tandem/consensus/peer.h"

namespace tandem::consensus {

/// The options with only the prediction and the share of the paper's prototype, for any coupling:
/// positions extrapolated by velocity, orientations not at all (Sec. 4.2, Eq. 3); the baseline
/// share (more while only this peer knows the user's constraint, Sec. 3.2; all for an owner, Sec.
/// 6.3) at any age, since Sec. 3.3 gives no law; no initiative, no arbitration, full authority at
/// once. Shares are per 1/60 s.
inline PeerOptions with_published_rules(PeerOptions options) {
  options.predictor = PredictorKind::Euler;
  options.own_predictor = nullptr;
  options.prediction.extrapolates_orientation = false;
  options.influence.limits_guesses = false;
  options.initiative = false;
  options.arbitration = false;
  options.authority_ramp = 0.0;
  options.robust.outvote = false;
  return options;
}

}  // namespace tandem::consensus
