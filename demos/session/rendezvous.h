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

/// Agrees on the session time at which the users' scripts begin, and passes packets to a
/// RemoteView. It sits between a peer and its transport.
///
/// Each process sends its epoch every half second. Once a process has heard all its connected peers
/// and none has an epoch, the lowest peer id sets it. A process without one adopts the earliest
/// heard, and so joins the running script.
/// @par Thread safety  Distinct objects: safe. One object: one thread at a time.
class Rendezvous final : public SideChannel {
 public:
  /// Both must outlive it.
  /// @param timestamps  how to read the times of others
  Rendezvous(consensus::Transport& inner, RemoteView& view,
             consensus::TimestampSource timestamps = consensus::TimestampSource::Sender)
      : SideChannel(inner), view_(view), timestamps_(timestamps) {}

  /// Sends if due, and decides. @param now  session time, ns
  void update(consensus::SessionTime now);
  /// ns, session time; nothing before agreement.
  std::optional<consensus::SessionTime> epoch() const { return epoch_; }
  /// True if another peer is connected.
  bool connected() const { return connected_; }

  void drain(std::vector<consensus::Packet>& out) override;

 private:
  static constexpr consensus::SessionTime kInterval = 500'000'000;  // ns, between messages
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
