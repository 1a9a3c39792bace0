// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <memory>
#include <vector>

#include "input/activity.h"
#include "members/connections.h"
#include "peer_data.h"
#include "send/outbox.h"

namespace tandem::consensus {

/// Sends own bodies, springs and acts to the others.
class Sender {
 public:
  Sender(PeerData& data, Connections& connections, const Activity& activity);

  /// Send if it is time.
  void send();
  /// Send from now on: the clock was set back.
  void restart() { next_send_ = data_.now; }
  /// A peer lacks indices or states.
  void tell_again(PeerId peer) {
    if (outbox_ != nullptr) outbox_->tell_again(peer, data_.now);
  }
  /// Largest number of shared bodies.
  std::size_t most_bodies() const;
  void set_interest(const Interest* interest) { interest_ = interest; }

 private:
  void send_all();
  /// Post to each peer the states that concern it.
  void post_states();
  /// Collect the states of states_ that concern a peer, into concerning_.
  void collect_concerning(PeerId peer);
  /// Send the full state to newcomers, reliably.
  void send_full_state_to_new();
  StateUpdate state_of(SharedBody& shared) const;
  /// Whether a body has been at rest for a while.
  bool rests(SharedBody& shared, const pbd::BodyState& state) const;
  /// Send what is due to each peer, by the outbox.
  void send_selected();
  /// Fill selectable_.
  void collect_selectable();
  /// Encode the anchors of spring_states_ into anchors_. Springs left in it have to be sent in
  /// full.
  void encode_own_anchors();
  /// Post springs, events and acts. @return bytes, with headers
  double post_springs();
  void renew_indices(std::size_t most);

  PeerData& data_;
  Connections& connections_;
  const Activity& activity_;
  const Interest* interest_ = nullptr;
  std::unique_ptr<Outbox> outbox_;  ///< null: every state in full to every peer
  SessionTime next_send_ = 0;
  SessionTime springs_told_ = 0;  ///< ns, when springs were last sent in full

  // Scratch, kept for its capacity.
  std::vector<StateUpdate> states_;
  std::vector<StateUpdate> concerning_;
  std::vector<SpringUpdate> spring_states_;
  std::vector<SpringUpdate> spring_events_;
  std::vector<SpringUpdate> told_in_full_;
  std::vector<ActUpdate> acts_;
  std::vector<ActReceipt> receipts_;
  AnchorMessages anchors_;
  std::vector<OutgoingState> selectable_;
};

}  // namespace tandem::consensus
