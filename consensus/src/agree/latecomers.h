// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <span>
#include <vector>

#include "members/shared_bodies.h"
#include "peer_data.h"

namespace tandem::consensus {

/// Peers whose states are so much older than the others' that the replay does not go back to them:
/// one member's delay would cost everybody.
class Latecomers {
 public:
  explicit Latecomers(PeerData& data) : data_(data) {}

  /// Call before the estimates of a step. Counts late peers in their reports.
  void look();
  /// Whether no peer is late, or none was looked for.
  bool none() const { return none_; }
  void forget() { none_ = true; }
  /// As of the last look().
  bool is_late(PeerId peer) const;
  /// Of two peers, whether this is the older one, which the replay does not go back to: its states
  /// are extrapolated to the replay's start. With two there is no median, and without the older one
  /// the newer would decide alone.
  bool is_carried(PeerId peer) const { return peer != 0 && peer == carried_; }
  /// States of a body from peers that are in time, and its owner's; all of them if no peer is late.
  /// Valid until the next call.
  /// @param guessed  set: no peer is in time, so that the present pose has to be extrapolated
  std::span<const Inbox::Received> in_time(const SharedBody& shared,
                                           std::span<const Inbox::Received> newest, bool& guessed);

 private:
  struct Member {
    PeerId peer = 0;
    SessionTime newest = 0;  ///< ns, newest stamp of a moving body; 0 = none moves
    bool late = false;
  };
  bool is_late(const Inbox::Received& received) const;

  PeerData& data_;
  std::vector<Member> members_;  ///< by peer
  std::vector<double> ages_;     ///< s
  std::vector<Inbox::Received> heard_;
  SessionTime oldest_ = 0;  ///< ns, oldest stamp in time for a single body
  PeerId carried_ = 0;
  bool none_ = true;
};

}  // namespace tandem::consensus
