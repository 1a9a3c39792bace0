// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "session/remote_view.h"
#include "session/side_channel.h"
#include "tandem/consensus/peer.h"

namespace tandem::demos {

/// Agrees on the session time at which the users' scripts begin, and shows passing packets to a
/// RemoteView. It stands between a peer and its transport.
///
/// Each process says every half second which epoch it knows. Who has heard all its connected peers
/// and nobody knows one: the lowest peer id sets it. Who knows none takes over the earliest that it
/// hears, so that a process that comes late, or comes back, joins the script where it is.
/// @par Thread safety  Distinct objects: safe. One object: one thread at a time.
class Rendezvous final : public SideChannel {
 public:
  /// Both must outlive it.
  /// @param timestamps  by what the times of others are read
  Rendezvous(consensus::Transport& inner, RemoteView& view,
             consensus::TimestampSource timestamps = consensus::TimestampSource::Sender)
      : SideChannel(inner), view_(view), timestamps_(timestamps) {}

  /// Speak where it is time, and decide. @param now  session time, ns
  void update(consensus::SessionTime now);
  /// ns, session time; nothing until it is agreed.
  std::optional<consensus::SessionTime> epoch() const { return epoch_; }
  /// Whether anybody is connected.
  bool connected() const { return connected_; }

  void drain(std::vector<consensus::Packet>& out) override;

 private:
  static constexpr consensus::SessionTime kInterval = 500'000'000;  // ns, between two words
  static constexpr consensus::SessionTime kLead = 1'000'000'000;    // ns, from decision to epoch

  bool hear(const consensus::Packet& packet) override;
  void say(consensus::PeerId to);

  RemoteView& view_;
  consensus::TimestampSource timestamps_;
  std::vector<consensus::PeerStatus> company_;  ///< at the last update()
  std::optional<consensus::SessionTime> epoch_;
  std::map<consensus::PeerId, consensus::SessionTime> heard_;  ///< epoch of each peer; 0 = none
  consensus::SessionTime now_ = 0;
  consensus::SessionTime next_word_ = 0;
  bool connected_ = false;
};

}  // namespace tandem::demos
