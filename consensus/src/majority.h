// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "tandem/consensus/transport.h"
#include "tandem/pbd/types.h"

namespace tandem::consensus {

/// Where another peer has a body, as seen from where it is here: m, rad, or both in metres.
struct Claim {
  PeerId peer = 0;
  pbd::Vec3 way = pbd::Vec3::Zero();
  pbd::Vec3 turn = pbd::Vec3::Zero();
};

/// Who gives way where no average makes sense: those who are fewer, and of equally many those
/// without the lowest id; so of two peers the higher id. All who see the same states come to the
/// same. Whoever is within half of the distance between two of them is on that one's side.
/// @return whether this peer gives way to claims[i]
bool outvoted(std::span<const Claim> claims, std::size_t i, PeerId self);

/// Who leads a body with a reason: those who hold it, or have let go of it lately.
class LeadClaims {
 public:
  /// @param holds  that peer acts on the body now, as far as is known here
  /// @return whether it is believed that it leads
  bool founded(PeerId peer, bool holds, SessionTime now);

 private:
  /// ns: longer than anything flies that was thrown.
  static constexpr SessionTime kLongest = 5'000'000'000;
  std::vector<std::pair<PeerId, SessionTime>> held_;
};

}  // namespace tandem::consensus
