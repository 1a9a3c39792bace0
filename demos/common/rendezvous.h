// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/remote_view.h"
#include "tandem/consensus/transport.h"

namespace tandem::demos {

/// Agrees on the session time at which the users' scripts begin, and shows passing packets to a
/// RemoteView. It stands between a peer and its transport.
///
/// Each process says every half second which epoch it knows. Who has heard all its connected peers
/// and nobody knows one: the lowest peer id sets it. Who knows none takes over the earliest that it
/// hears, so that a process that comes late, or comes back, joins the script where it is.
/// @par Thread safety  Distinct objects: safe. One object: one thread at a time.
class Rendezvous final : public consensus::Transport {
 public:
  /// Both must outlive it.
  Rendezvous(consensus::Transport& inner, RemoteView& view) : inner_(inner), view_(view) {}

  /// Speak where it is time, and decide. @param now  session time, ns
  void update(consensus::SessionTime now);
  /// ns, session time; nothing until it is agreed.
  std::optional<consensus::SessionTime> epoch() const { return epoch_; }
  /// Whether anybody is connected.
  bool connected() const { return connected_; }

  // consensus::Transport
  consensus::PeerId self() const override { return inner_.self(); }
  bool post(consensus::PeerId to, std::span<const std::byte> bytes,
            consensus::Delivery delivery) override {
    return inner_.post(to, bytes, delivery);
  }
  void drain(std::vector<consensus::Packet>& out) override;
  void drop(consensus::PeerId peer, const std::string& reason) override {
    inner_.drop(peer, reason);
  }
  std::vector<consensus::PeerStatus> peers() const override { return inner_.peers(); }

 private:
  static constexpr consensus::SessionTime kInterval = 500'000'000;  // ns, between two words
  static constexpr consensus::SessionTime kLead = 1'000'000'000;    // ns, from decision to epoch
  static constexpr consensus::SessionTime kMaxDistance = 86'400'000'000'000;  // ns, one day

  /// Whether the packet is one of ours.
  bool hear(const consensus::Packet& packet);
  void say(consensus::PeerId to);

  consensus::Transport& inner_;
  RemoteView& view_;
  std::optional<consensus::SessionTime> epoch_;
  std::map<consensus::PeerId, consensus::SessionTime> heard_;  ///< epoch of each peer; 0 = none
  consensus::SessionTime now_ = 0;
  consensus::SessionTime next_word_ = 0;
  bool connected_ = false;
};

}  // namespace tandem::demos
