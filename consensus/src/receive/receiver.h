// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <limits>
#include <span>
#include <vector>

#include "members/connections.h"
#include "peer_data.h"
#include "tandem/consensus/sender_clocks.h"
#include "tandem/consensus/update.h"
#include "tandem/pbd/token_bucket.h"

namespace tandem::consensus {

/// Decodes, checks and dates packets and files their records into the inbox and the springs.
class Receiver {
 public:
  /// A message about a body's owner.
  struct OwnershipNews {
    PeerId from = 0;
    OwnershipUpdate update;
  };

  Receiver(PeerData& data, Connections& connections) : data_(data), connections_(connections) {}

  void receive();

  // Results of the last receive().
  std::span<const UnknownState> unknown() const { return unknown_; }
  std::span<const OwnershipNews> ownership() const { return ownership_; }
  /// Peers that lack indices or states.
  std::span<const PeerId> wants_all() const { return wants_all_; }

 private:
  /// Another peer, from when it was first heard.
  struct Met {
    PeerId peer = 0;
    SessionTime since = 0;  ///< ns, when it was first heard
    SessionTime last = 0;   ///< ns, when it was last heard
    pbd::TokenBucket budget;
    pbd::TokenBucket acts;         ///< limits of Acts
    int astray = 0;                ///< successive packets with stamps of another clock
    SessionTime astray_since = 0;  ///< ns
    /// Stamp of its farewell; the minimum if it has not left.
    SessionTime farewell = std::numeric_limits<SessionTime>::min();
  };

  /// A packet within its sender's budget, decoded.
  struct Decoded {
    const Packet* packet = nullptr;
    DecodedPacket content;
  };

  /// False if its sender has exceeded its budget, or the packet cannot be decoded.
  bool decode_admitted(const Packet& packet, DecodedPacket& out);
  void take_packet(Decoded& decoded);
  /// Whether the stamps in incoming_ are unrelated to session time, as after its sender's clock was
  /// set and it restarted.
  bool is_of_another_clock(Met& met);
  /// Shift the stamps of incoming_ to the local clock.
  void date(const Packet& packet);
  /// Budget for one member's packets, in the units of work_of().
  void set_budget(pbd::TokenBucket& budget) const;
  /// Remove from incoming_ the records that the role forbids.
  void keep_allowed(PeerId from, Role role);
  /// Record that a peer was heard, and make room for it. Valid until the next call.
  Met& meet(PeerId from);
  /// Ignore everything that a peer has sent.
  void part_from(PeerId peer);
  void forget(PeerId peer);
  void take_in(Met& sender);
  void take_in_state(PeerId from, const StateUpdate& update, SessionTime farewell);
  void take_in_compact(PeerId from, SessionTime farewell);
  /// Full springs, and anchors of known ones.
  void take_in_springs(PeerId from);
  /// The others' acts and receipts.
  void take_in_acts(Met& sender);
  void take_in_spring(PeerId from, const SpringUpdate& update);
  /// Invalid if the body is not shared here, or gone.
  pbd::BodyId instance_of(const SharedId& id) const;

  PeerData& data_;
  Connections& connections_;
  SenderClocks sender_clocks_;
  std::vector<Met> met_;  ///< by id
  std::vector<UnknownState> unknown_;
  std::vector<OwnershipNews> ownership_;
  std::vector<PeerId> wants_all_;

  // Scratch, kept for its capacity.
  std::vector<Packet> packets_;
  std::vector<PeerStatus> senders_;  ///< of packets_, if any is dated by arrival
  DecodedPacket incoming_;
  /// Packets are decoded in batches of this size before they are processed: reading the processor's
  /// clock, for each of the two, costs as much as a state.
  std::array<Decoded, 16> batch_;
};

}  // namespace tandem::consensus
