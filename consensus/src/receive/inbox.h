// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "tandem/consensus/plausibility.h"
#include "tandem/consensus/robust.h"
#include "tandem/consensus/shared_id.h"
#include "tandem/consensus/transport.h"
#include "tandem/consensus/update.h"

namespace tandem::consensus {

struct InboxOptions {
  double max_age = 1.0;     ///< s: updates older than this on arrival are refused
  double max_future = 1.0;  ///< s: updates stamped further ahead of now are refused
  /// Between two successive states of a peer.
  PlausibilityOptions plausibility = {};
};

/// Outcome of an update; in the order of InboxCounters, of robust.h.
enum class InboxVerdict : std::uint8_t {
  Accepted,
  Duplicate,    ///< same stamp as the stored one
  Late,         ///< older than the stored one
  Expired,      ///< older than max_age
  Future,       ///< stamped more than max_future ahead
  Implausible,  ///< no body moves like that, see plausible()
  UnknownId,    ///< id not registered here
  UnknownPeer,  ///< peer not added here
};

/// The newest update of each peer for each registered body; all others are dropped by their
/// timestamp and counted. Memory is bounded by registered ids times added peers. The stored update
/// does not depend on the order of arrival if updates are plausible and have distinct stamps.
/// Iteration is by ascending id and peer.
class Inbox {
 public:
  struct Received {
    PeerId peer = 0;
    StateUpdate update;
    SessionTime arrival = 0;  ///< ns, time of offer()
    SessionTime jumped = 0;   ///< ns, arrival of the last jump that was believed; 0 = never
  };

  explicit Inbox(const InboxOptions& options = {});

  /// Register a body. No effect if it is registered.
  void add_id(const SharedId& id);
  /// Drop a body and its updates.
  void remove_id(const SharedId& id);
  std::size_t id_count() const { return bodies_.size(); }

  /// Register a peer. No effect if it is registered.
  void add_peer(PeerId peer);
  /// Drop a peer's updates, as when it leaves. Its counters stay.
  void remove_peer(PeerId peer);
  /// Drop a peer with its counters.
  void forget_peer(PeerId peer);

  /// File one update of an authenticated peer. @param now  session time, ns. Allocates only at a
  /// peer's first update for a body.
  InboxVerdict offer(PeerId from, const StateUpdate& update, SessionTime now);

  /// Stored updates of a body, by ascending peer; empty for unknown ids. They stay until replaced,
  /// pruned or removed: check their age. Valid until the next change.
  std::span<const Received> newest(const SharedId& id) const;
  /// newest() by the index of a registered id, in their order.
  /// @pre index < id_count()
  std::span<const Received> newest_at(std::size_t index) const { return bodies_[index].newest; }
  /// The peer has sent a packet stamped at this session time, ns, however late it came: its earlier
  /// states of resting bodies still hold. Stamps more than max_future ahead are ignored.
  /// @return whether it had been silent for longer than max_age: its states were dropped
  bool note_alive(PeerId from, SessionTime stamp, SessionTime now);
  /// ns, newest stamp of anything that the peer has sent; 0 = none.
  SessionTime alive(PeerId from) const;
  /// ns: until when a stored state holds: its stamp, or for a resting body the newest stamp of
  /// anything that its sender has sent.
  SessionTime holds_until(const Received& received) const;
  /// Drop states that have not held for max_age, or that are further ahead than max_future after a
  /// clock was set back; returns their number.
  std::size_t prune(SessionTime now);

  /// Over all offers of all peers, unknown ones included.
  const InboxCounters& totals() const { return totals_; }
  /// Counters of one peer, also after its removal; zeros if it was never added.
  InboxCounters counters(PeerId peer) const;

 private:
  struct Body {
    SharedId id;
    std::vector<Received> newest;  ///< by peer
  };
  struct Peer {
    PeerId id = 0;
    bool present = false;
    SessionTime alive = 0;  ///< ns, newest stamp; 0 = none yet
    InboxCounters counters;
  };

  static void count(InboxCounters& counters, InboxVerdict verdict);
  InboxVerdict judge(PeerId from, const StateUpdate& update, SessionTime now);
  InboxVerdict store(Body& body, PeerId from, const StateUpdate& update, SessionTime now);

  SessionTime max_age_ns_;
  SessionTime max_future_ns_;
  PlausibilityOptions plausibility_;
  std::vector<Body> bodies_;  ///< by id
  std::vector<Peer> peers_;   ///< by id
  InboxCounters totals_;
  std::size_t next_ = 0;  ///< body after the one last offered: packets have them in order
};

}  // namespace tandem::consensus
