// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "agree/votes.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/ranges.h"

namespace tandem::consensus {
namespace {

double distance(const StateOffset& a, const StateOffset& b) {
  double square = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) square += (a[k] - b[k]) * (a[k] - b[k]);
  return std::sqrt(square);
}

double square_of(const Claim& from, const Claim& to) {
  return (to.way - from.way).squaredNorm() + kLever * kLever * (to.turn - from.turn).squaredNorm();
}

}  // namespace

StateOffset offset_of(const pbd::Correction& apart) {
  StateOffset offset;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    offset[k] = apart.translation[i];
    offset[3 + k] = kLever * apart.rotation[i];
    offset[6 + k] = kHorizon * apart.twist.linear[i];
    offset[9 + k] = kLever * kHorizon * apart.twist.angular[i];
  }
  return offset;
}

void weigh_centrality(std::span<Vote> votes) {
  for (Vote& vote : votes) vote.cost = 0.0;
  for (std::size_t i = 0; i < votes.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const double apart = distance(votes[i].at, votes[j].at);
      votes[i].cost += votes[j].weight * apart;
      votes[j].cost += votes[i].weight * apart;
    }
  }
  double least = std::numeric_limits<double>::infinity();
  for (const Vote& vote : votes) {
    if (vote.weight > 0.0) least = std::min(least, vote.cost);
  }
  const Periphery outside = periphery(votes.size());
  for (Vote& vote : votes) {
    // Zero cost: all votes are in one place.
    const double ratio = vote.cost > 0.0 ? vote.cost / least : 1.0;
    vote.central = std::clamp((outside.none - ratio) / (outside.none - outside.full), 0.0, 1.0);
  }
}

bool outvoted(std::span<const Claim> claims, std::size_t i, PeerId self) {
  const Claim own{.peer = self};
  const double near = 0.25 * square_of(own, claims[i]);  // square of half the distance
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
  const auto it = ranges::find(held_, peer, [](const auto& entry) { return entry.first; });
  if (holds) {
    if (it == held_.end()) {
      std::erase_if(held_, [now](const auto& entry) { return now - entry.second > kLongest; });
      held_.emplace_back(peer, now);
    } else {
      it->second = now;
    }
    return true;
  }
  return it != held_.end() && now - it->second <= kLongest;
}

}  // namespace tandem::consensus
