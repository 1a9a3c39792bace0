// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "agree/estimates.h"
#include "peer_data.h"

namespace tandem::consensus {

/// Limits how far other peers are believed: votes in place of a mean, bounds on corrections, and
/// counts in the reports.
class Trust {
 public:
  explicit Trust(PeerData& data) : data_(data) {}

  /// Whether a peer's claim to lead a body is believed, as far as can be known here.
  bool believes_lead(SharedBody& shared, PeerId from);
  /// Whether a claimed hand is believed that no other peer knows.
  bool believes_hands(std::size_t others) const;
  /// Whether a majority agrees with newest[i] on the orientation rather than with the local state.
  bool outvoted_at_stamp(const SharedBody& shared, std::span<const Inbox::Received> newest,
                         std::size_t i);
  /// Reduce the weights of estimates far from the rest.
  /// @param equal  weight of a peer that announces the same share as this one
  void weigh_votes(const pbd::BodyState& own, double equal, std::span<PeerEstimate> estimates);
  /// Limit the correction to RobustOptions.
  void limit(const pbd::BodyState& own, Wanted& wanted);

 private:
  void note_outliers(std::span<const PeerEstimate> estimates);

  PeerData& data_;
  std::vector<Vote> votes_;
  std::vector<Claim> turns_;
};

}  // namespace tandem::consensus
