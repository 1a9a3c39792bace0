// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "centrality.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace tandem::consensus {
namespace {

double distance(const StateOffset& a, const StateOffset& b) {
  double square = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) square += (a[k] - b[k]) * (a[k] - b[k]);
  return std::sqrt(square);
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
    // A cost of nothing: all are in one place.
    const double ratio = vote.cost > 0.0 ? vote.cost / least : 1.0;
    vote.central = std::clamp((outside.none - ratio) / (outside.none - outside.full), 0.0, 1.0);
  }
}

}  // namespace tandem::consensus
