// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "peer_data.h"

#include <algorithm>

namespace tandem::consensus {

double PeerData::confidence() const {
  if (options.authority_ramp <= 0.0) return 1.0;
  const double since = started == 0 ? 0.0 : seconds(now - started);
  return std::clamp(since / options.authority_ramp, 0.0, 1.0);
}

double PeerData::announced(const SharedBody& shared) const {
  if (changes_hands(shared)) return shared.tenure.owner == self() ? 1.0 : 0.0;
  if (shared.def.owner.has_value()) return shared.def.owner == self() ? 1.0 : 0.0;
  return confidence() * announced_share(options.influence, springs.holds_alone(shared.def.body),
                                        shared.initiative.strength() >= 1.0);
}

}  // namespace tandem::consensus
