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

/// Takes in what has come: packets are decoded, checked, dated and sorted into inbox and springs.
class Receiver {
 public:
  /// What another peer says of who owns a body.
  struct OwnershipNews {
    PeerId from = 0;
    OwnershipUpdate update;
  };

  Receiver(PeerData& data, Connections& connections) : data_(data), connections_(connections) {}

  void receive();

  // Of the last receive().
  std::span<const UnknownState> unknown() const { return unknown_; }
  std::span<const OwnershipNews> ownership() const { return ownership_; }
  /// Who lacks indices, or states.
  std::span<const PeerId> wants_all() const { return wants_all_; }

 private:
  /// Another peer since it was first heard.
  struct Met {
    PeerId peer = 0;
    SessionTime since = 0;  ///< ns, when it was heard first,
    SessionTime last = 0;   ///< and when last
    pbd::TokenBucket budget;
    pbd::TokenBucket acts;         ///< as Acts has it
    int astray = 0;                ///< packets in a row with stamps of another time
    SessionTime astray_since = 0;  ///< ns
    /// Stamp of its farewell; the beginning of time where it has not left.
    SessionTime farewell = std::numeric_limits<SessionTime>::min();
  };

  /// A packet that was admitted, and what is in it.
  struct Decoded {
    const Packet* packet = nullptr;
    DecodedPacket content;
  };

  /// False where its sender may not say so much, or it is no packet.
  bool decode_admitted(const Packet& packet, DecodedPacket& out);
  void take_packet(Decoded& decoded);
  /// Whether the stamps in incoming_ say nothing of session time, as where its sender's clock was
  /// set and it started again.
  bool is_of_another_clock(Met& met);
  /// Shift the stamps of incoming_ to the own clock.
  void date(const Packet& packet);
  /// What one member may have this peer do: budget, in what work_of() counts.
  void set_budget(pbd::TokenBucket& budget) const;
  /// Take out of incoming_ what that role may not say.
  void keep_allowed(PeerId from, Role role);
  /// Note that a peer was heard; make room for it. Valid until the next call.
  Met& meet(PeerId from);
  /// What a peer has said counts no more.
  void part_from(PeerId peer);
  void forget(PeerId peer);
  void take_in(Met& sender);
  void take_in_state(PeerId from, const StateUpdate& update, SessionTime farewell);
  void take_in_compact(PeerId from, SessionTime farewell);
  /// Springs as they are told in full, and anchors of known ones.
  void take_in_springs(PeerId from);
  /// Others' acts, and who has which.
  void take_in_acts(Met& sender);
  void take_in_spring(PeerId from, const SpringUpdate& update);
  /// Invalid where the body is not shared here, or gone.
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
  std::vector<PeerStatus> senders_;  ///< of packets_, where any is dated on arrival
  DecodedPacket incoming_;
  /// So many are decoded before they are looked at: a reading of the processor's clock, for each of
  /// the two, costs as much as a state (benchmarks/network/receive_cost).
  std::array<Decoded, 16> batch_;
};

}  // namespace tandem::consensus
