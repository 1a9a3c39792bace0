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
  bool first = false;                     ///< this peer's user holds or leads the body
  pbd::Vec3 gravity = pbd::Vec3::Zero();  ///< m/s^2, on this body
  StateUpdate update;
};

/// Messages with anchors, one behind the other. Each fits a packet, and says nothing of the hands
/// in the others.
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

/// Chooses which states go to whom, within a budget, and puts them into packets: see SendOptions.
///
/// For each of the others it keeps what was last sent of each body, and with it what the other side
/// expects of the body now. Bodies that are due gather priority until they are sent.
class Outbox {
 public:
  Outbox(const SendOptions& options, Transport& transport, PeerStats& stats)
      : options_(options), transport_(transport), stats_(stats) {}

  /// A number for a body that is new here, until renew().
  /// @pre fewer than kMaxIndices bodies are shared
  std::uint16_t assign_index(const SharedId& id);
  static constexpr std::size_t kMaxIndices = 0x10000;
  /// Bytes that a packet costs beside what is in it; those of UdpTransport over IPv4.
  static constexpr double kPacketOverhead = 74.0;
  /// Indices are given once. Where more than `most` are, because bodies have come and gone, all are
  /// forgotten. @return whether they are: all bodies need new ones
  bool renew(std::size_t most);

  /// @param peers   all that the transport knows
  /// @param states    by ascending index, stamped `now`
  /// @param anchors   go along where the budget allows, in turn where it does not for all of them
  /// @param interest  may be null
  void send(std::span<const PeerStatus> peers, std::span<const OutgoingState> states,
            const AnchorMessages& anchors, const Interest* interest, SessionTime now);
  /// Something else was sent to everybody, bytes with headers.
  void charge(double bytes);
  /// A peer lacks indices or states: it is told everything again.
  void tell_again(PeerId peer, SessionTime now);

 private:
  /// What was last sent of one body to one peer.
  struct Sent {
    SessionTime stamp = 0;  ///< ns; 0 = nothing yet
    pbd::Pose pose;
    pbd::Twist twist;
    UpdateFlags flags;
    bool indexed = false;
    bool here = false;        ///< it is shared and concerns the peer
    bool jumping = false;     ///< the body has just jumped
    bool committed = false;   ///< reliably, and it rests since
    std::uint8_t news = 0;    ///< times that the state is still to be sent since something changed
    std::uint8_t jumped = 0;  ///< times that it still is to tell of a jump
    float influence = 0.0F;   ///< as it was sent
    float announced = 0.0F;   ///< as it was at the last look
    double priority = 0.0;
  };
  struct Link {
    PeerId to = 0;
    bool up = false;
    double kbit_per_s = 0.0;    ///< budget; 0 = none
    double room = 0.0;          ///< bytes that may be sent now; below 0 they are owed
    double anchor_room = 0.0;   ///< of these, for anchors
    SessionTime last = 0;       ///< ns, of the last send()
    SessionTime posted = 0;     ///< ns, when something was last sent
    SessionTime committed = 0;  ///< ns, when what rests was last said
    SessionTime told = 0;       ///< ns, when all was told again
    std::size_t turn = 0;       ///< of the messages with anchors, which is the next
    std::vector<Sent> sent;     ///< by index
  };
  struct Due {
    double priority = 0.0;
    std::uint32_t at = 0;  ///< index into the states
    bool reliable = false;
  };

  /// Forget whom the transport has forgotten.
  void forget_strangers(std::span<const PeerStatus> peers);
  Link& link_to(PeerId peer);
  LinkStats& counters_of(const Link& link) {
    return stats_.links[static_cast<std::size_t>(&link - links_.data())];
  }
  /// bytes
  double most_saved(const Link& link) const;
  void refill(Link& link, SessionTime now) const;
  /// Whether anchors of so many bytes may go now.
  bool has_room(const Link& link, double anchors) const;
  /// Which messages with anchors go now, into taken_.
  /// @return bytes, with the headers of packets beyond the first
  double take_anchors(Link& link, const AnchorMessages& anchors);
  /// Which states are due, into due_.
  void look(Link& link, std::span<const OutgoingState> states, const Interest* interest,
            SessionTime now);
  /// Whether the other side has a wrong influence. One that grows steadily is said now and then.
  static bool influence_differs(Sent& sent, float influence);
  /// Whether one state is due.
  /// @param limited  the link has a budget
  bool is_due(Sent& sent, const OutgoingState& state, bool limited, SessionTime now,
              Due& due) const;
  /// How far off the other side is, in tolerances.
  double missed(const Sent& sent, const OutgoingState& state, SessionTime now) const;
  /// Leave in due_ what the budget has room for, by ascending index.
  /// @param along  bytes that go in any case
  void choose(Link& link, std::span<const OutgoingState> states, double along);
  /// Of bodies that are shared no longer, or do not concern the peer: that they rest is not
  /// promised any more.
  void withdraw(Link& link);
  void post_indices(Link& link, std::span<const OutgoingState> states);
  /// All of taken_ but the last message, which is returned: states have room behind it.
  std::span<const std::byte> post_anchors(Link& link, const AnchorMessages& anchors);
  void post_states(Link& link, std::span<const OutgoingState> states,
                   std::span<const std::byte> anchors, bool reliable, SessionTime now);
  bool post(Link& link, Delivery delivery);
  double size_of(const StateUpdate& update) const;

  SendOptions options_;
  Transport& transport_;
  PeerStats& stats_;  ///< its links are those of links_
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
