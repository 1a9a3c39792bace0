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

/// Tells the others of own bodies and springs.
class Sender {
 public:
  Sender(PeerData& data, Connections& connections, const Activity& activity);

  /// Where it is time.
  void send();
  /// Send again from now on: the clock was set back.
  void restart() { next_send_ = data_.now; }
  /// A peer lacks indices or states.
  void tell_again(PeerId peer) {
    if (outbox_ != nullptr) outbox_->tell_again(peer, data_.now);
  }
  /// Bodies that may be shared.
  std::size_t most_bodies() const;
  void set_interest(const Interest* interest) { interest_ = interest; }

 private:
  void send_all();
  /// The states that concern each of the others.
  void post_states();
  /// Those of states_ that concern a peer, into concerning_.
  void collect_concerning(PeerId peer);
  /// Tell who is new all that is to be known, reliably.
  void send_full_state_to_new();
  StateUpdate state_of(SharedBody& shared) const;
  /// Whether a body has been at rest for a while.
  bool rests(SharedBody& shared, const pbd::BodyState& state) const;
  /// By the outbox: what is due, to each of the others.
  void send_selected();
  /// Into selectable_.
  void collect_selectable();
  /// The anchors of spring_states_ into anchors_. What is left there is to be told in full.
  void encode_own_anchors();
  /// Springs as they are, events, and acts. @return bytes, with headers
  double post_springs();
  void renew_indices(std::size_t most);

  PeerData& data_;
  Connections& connections_;
  const Activity& activity_;
  const Interest* interest_ = nullptr;
  std::unique_ptr<Outbox> outbox_;  ///< null: all in full to everybody
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
