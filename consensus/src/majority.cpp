// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "majority.h"

#include <algorithm>

#include "centrality.h"

namespace tandem::consensus {
namespace {

double square_of(const Claim& from, const Claim& to) {
  return (to.way - from.way).squaredNorm() + kLever * kLever * (to.turn - from.turn).squaredNorm();
}

}  // namespace

bool outvoted(std::span<const Claim> claims, std::size_t i, PeerId self) {
  const Claim own{.peer = self};
  const double near = 0.25 * square_of(own, claims[i]);  // of half the distance
  int for_own = 1;
  int for_other = 0;
  PeerId first_own = self;
  PeerId first_other = claims[i].peer;
  for (const Claim& claim : claims) {
    if (square_of(own, claim) < near) {
      ++for_own;
      first_own = std::min(first_own, claim.peer);
    } else if (square_of(claims[i], claim) < near || claim.peer == claims[i].peer) {
      ++for_other;
      first_other = std::min(first_other, claim.peer);
    }
  }
  return for_other != for_own ? for_other > for_own : first_other < first_own;
}

bool LeadClaims::founded(PeerId peer, bool holds, SessionTime now) {
  const auto it = std::find_if(held_.begin(), held_.end(),
                               [peer](const auto& entry) { return entry.first == peer; });
  if (holds) {
    if (it == held_.end()) {
      held_.emplace_back(peer, now);
    } else {
      it->second = now;
    }
    return true;
  }
  return it != held_.end() && now - it->second <= kLongest;
}

}  // namespace tandem::consensus
