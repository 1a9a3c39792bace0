// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "members/connections.h"
#include "tandem/consensus/compact.h"
#include "tandem/consensus/peer.h"

namespace tandem::consensus {

/// A state that may be sent.
struct OutgoingState {
  std::uint16_t index = 0;                ///< of its body, by Outbox::assign_index()
  bool first = false;                     ///< whether this peer's user holds or leads the body
  pbd::Vec3 gravity = pbd::Vec3::Zero();  ///< m/s^2, on this body
  StateUpdate update;
};

/// Messages with anchors, one after the other. Each fits a packet and is independent of the others.
struct AnchorMessages {
  std::vector<std::byte> bytes;
  std::vector<std::size_t> ends;  ///< of each message in `bytes`

  void clear() {
    bytes.clear();
    ends.clear();
  }
  std::span<const std::byte> operator[](std::size_t i) const {
    const std::size_t begin = i > 0 ? ends[i - 1] : 0;
    return std::span(bytes).subspan(begin, ends[i] - begin);
  }
};

/// Chooses which states go to which peer within a budget, and packs them: see SendOptions.
///
/// For each peer it stores the last state sent of each body, and so what that peer predicts for it.
/// Bodies that are due gain priority until they are sent.
class Outbox {
 public:
  Outbox(const SendOptions& options, Transport& transport, PeerStats& stats)
      : options_(options), transport_(transport), stats_(stats) {}

  /// Index of a body that is new here, until renew().
  /// @pre fewer than kMaxIndices bodies are shared
  std::uint16_t assign_index(const SharedId& id);
  static constexpr std::size_t kMaxIndices = 0x10000;
  /// Bytes of a packet beside its contents; those of UdpTransport over IPv4.
  static constexpr double kPacketOverhead = 74.0;
  /// Indices are never reused. If more than `most` were assigned, as bodies have come and gone, all
  /// are dropped. @return whether they were: all bodies need new ones
  bool renew(std::size_t most);

  /// @param peers  all known to the transport
  /// @param states    by ascending index, stamped `now`
  /// @param anchors  sent along if the budget allows, in turn if not for all
  /// @param interest  may be null
  void send(std::span<const PeerStatus> peers, std::span<const OutgoingState> states,
            const AnchorMessages& anchors, const Interest* interest, SessionTime now);
  /// Account for other bytes sent to every peer, headers included.
  void charge(double bytes);
  /// A peer lacks indices or states: everything is sent to it again.
  void tell_again(PeerId peer, SessionTime now);

 private:
  /// The last state of one body sent to one peer.
  struct Sent {
    SessionTime stamp = 0;  ///< ns; 0 = none yet
    pbd::Pose pose;
    pbd::Twist twist;
    UpdateFlags flags;
    bool indexed = false;
    bool here = false;        ///< whether it is shared and concerns the peer
    bool jumping = false;     ///< whether the body has just jumped
    bool committed = false;   ///< whether it was sent reliably, and has rested since
    std::uint8_t news = 0;    ///< times the state is still to be sent after a change
    std::uint8_t jumped = 0;  ///< times it is still to announce a jump
    float influence = 0.0F;   ///< as sent
    float announced = 0.0F;   ///< as last examined
    double priority = 0.0;
  };
  struct Link {
    PeerId to = 0;
    bool up = false;
    double kbit_per_s = 0.0;    ///< budget; 0 = none
    double room = 0.0;          ///< bytes that may be sent now; below 0 = owed
    double anchor_room = 0.0;   ///< the part of it for anchors
    SessionTime last = 0;       ///< ns, of the last send()
    SessionTime posted = 0;     ///< ns, when a packet was last sent
    SessionTime committed = 0;  ///< ns, when resting bodies were last sent
    SessionTime told = 0;       ///< ns, when everything was last repeated
    std::size_t turn = 0;       ///< next message with anchors
    std::vector<Sent> sent;     ///< by index
  };
  struct Due {
    double priority = 0.0;
    std::uint32_t at = 0;  ///< index into the states
    bool reliable = false;
  };

  /// Drop peers that the transport has dropped.
  void forget_strangers(std::span<const PeerStatus> peers);
  Link& link_to(PeerId peer);
  LinkStats& counters_of(const Link& link) {
    return stats_.links[static_cast<std::size_t>(&link - links_.data())];
  }
  /// Bytes that may be saved.
  double most_saved(const Link& link) const;
  void refill(Link& link, SessionTime now) const;
  /// Whether anchors of this size may be sent now.
  bool has_room(const Link& link, double anchors) const;
  /// Choose the messages with anchors to send now, into taken_.
  /// @return bytes, with the headers of packets beyond the first
  double take_anchors(Link& link, const AnchorMessages& anchors);
  /// Collect the states that are due, into due_.
  void look(Link& link, std::span<const OutgoingState> states, const Interest* interest,
            SessionTime now);
  /// Whether the influence last sent is wrong. Steady growth is sent only now and then.
  static bool influence_differs(Sent& sent, float influence);
  /// Whether one state is due.
  /// @param limited  whether the link has a budget
  bool is_due(Sent& sent, const OutgoingState& state, bool limited, SessionTime now,
              Due& due) const;
  /// Error of the peer's prediction, in tolerances.
  double missed(const Sent& sent, const OutgoingState& state, SessionTime now) const;
  /// Reduce due_ to what the budget allows, by ascending index.
  /// @param along  bytes that are sent in any case
  void choose(Link& link, std::span<const OutgoingState> states, double along);
  /// Tell the peer that bodies no longer shared, or that do not concern it, are no longer promised
  /// to rest.
  void withdraw(Link& link);
  void post_indices(Link& link, std::span<const OutgoingState> states);
  /// Post all of taken_ but the last message, which is returned: states can share its packet.
  std::span<const std::byte> post_anchors(Link& link, const AnchorMessages& anchors);
  void post_states(Link& link, std::span<const OutgoingState> states,
                   std::span<const std::byte> anchors, bool reliable, SessionTime now);
  bool post(Link& link, Delivery delivery);
  double size_of(const StateUpdate& update) const;

  SendOptions options_;
  Transport& transport_;
  PeerStats& stats_;  ///< its links match links_
  std::uint32_t table_ = 0;
  std::vector<SharedId> indexed_;
  std::vector<Link> links_;  ///< by peer

  // Scratch, kept for its capacity.
  std::vector<Due> due_;
  std::vector<IndexedState> withdrawn_;
  std::vector<std::size_t> taken_;
  std::vector<SharedId> ids_;
  std::vector<IndexedState> compact_;
  std::vector<StateUpdate> full_;
  std::vector<std::uint32_t> places_;
  std::vector<std::byte> packet_;
};

}  // namespace tandem::consensus
