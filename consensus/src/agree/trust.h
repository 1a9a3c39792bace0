// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "agree/estimates.h"
#include "peer_data.h"

namespace tandem::consensus {

/// How far others are believed: votes in place of a mean, limits of what is asked for, and what is
/// noted about whom.
class Trust {
 public:
  explicit Trust(PeerData& data) : data_(data) {}

  /// Whether a peer that says so leads a body, as far as can be known here.
  bool believes_lead(SharedBody& shared, PeerId from);
  /// Whether a hand is believed in that nobody else knows.
  bool believes_hands(std::size_t others) const;
  /// Whether more say what newest[i] says of the orientation than what is so here.
  bool outvoted_at_stamp(const SharedBody& shared, std::span<const Inbox::Received> newest,
                         std::size_t i);
  /// Of several estimates those far from the rest count less.
  /// @param equal  weight of one who announces as much as this peer
  void weigh_votes(const pbd::BodyState& own, double equal, std::span<PeerEstimate> estimates);
  /// Ask for no more than RobustOptions allow.
  void limit(const pbd::BodyState& own, Wanted& wanted);

 private:
  void note_outliers(std::span<const PeerEstimate> estimates);

  PeerData& data_;
  std::vector<Vote> votes_;
  std::vector<Claim> turns_;
};

}  // namespace tandem::consensus
