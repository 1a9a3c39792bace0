// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <span>
#include <vector>

#include "members/shared_bodies.h"
#include "peer_data.h"

namespace tandem::consensus {

/// Whose states are so much older than the others' that the replay does not go back to them. It
/// would for everybody: one member's way would be all members' cost.
class Latecomers {
 public:
  explicit Latecomers(PeerData& data) : data_(data) {}

  /// Before the estimates of a step. Who is late is counted in its report.
  void look();
  /// Nobody is, or nobody is looked for.
  bool none() const { return none_; }
  void forget() { none_ = true; }
  /// Of the last look().
  bool is_late(PeerId peer) const;
  /// Likewise, of two: the older one, to whose states the replay does not go back either, as they
  /// can be carried to where it begins. Of two nobody can tell who is usual, and without the older
  /// one the newer would have the only say.
  bool is_carried(PeerId peer) const { return peer != 0 && peer == carried_; }
  /// What those say of a body who are in time, and who owns it; all of it where nobody is. Valid
  /// until the next call.
  /// @param guessed  set: nobody is in time, so that where the body is now has to be guessed
  std::span<const Inbox::Received> in_time(const SharedBody& shared,
                                           std::span<const Inbox::Received> newest, bool& guessed);

 private:
  struct Member {
    PeerId peer = 0;
    SessionTime newest = 0;  ///< ns, stamp of the newest state of what moves; 0 = nothing does
    bool late = false;
  };
  bool is_late(const Inbox::Received& received) const;

  PeerData& data_;
  std::vector<Member> members_;  ///< by peer
  std::vector<double> ages_;     ///< s
  std::vector<Inbox::Received> heard_;
  SessionTime oldest_ = 0;  ///< ns, stamp of a single body
  PeerId carried_ = 0;
  bool none_ = true;
};

}  // namespace tandem::consensus
