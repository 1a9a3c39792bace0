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
  double max_age = 1.0;     ///< s: updates that are older when they arrive are refused
  double max_future = 1.0;  ///< s: updates stamped further ahead of now are refused
  /// Of two states of a peer in a row.
  PlausibilityOptions plausibility = {};
};

/// Why an update was kept or not; in the order of InboxCounters, of robust.h.
enum class InboxVerdict : std::uint8_t {
  Accepted,
  Duplicate,    ///< same stamp as the one kept
  Late,         ///< older than the one kept
  Expired,      ///< older than max_age
  Future,       ///< stamped more than max_future ahead
  Implausible,  ///< nothing moves like that, see plausible()
  UnknownId,    ///< id not registered here
  UnknownPeer,  ///< peer not added here
};

/// The newest update of each peer for each registered body; everything else is dropped by its
/// timestamp and counted. Memory is bounded by registered ids times added peers, whatever arrives.
/// Of plausible updates with distinct stamps the same one is kept in whatever order they arrive;
/// everything is iterated by ascending id and peer.
class Inbox {
 public:
  struct Received {
    PeerId peer = 0;
    StateUpdate update;
    SessionTime arrival = 0;  ///< ns, when it was offered
    SessionTime jumped = 0;   ///< ns, arrival of the last jump that was believed; 0 = never
  };

  explicit Inbox(const InboxOptions& options = {});

  /// Start to keep updates of a body. No effect where it is registered already.
  void add_id(const SharedId& id);
  /// Forget a body and its updates.
  void remove_id(const SharedId& id);
  std::size_t id_count() const { return bodies_.size(); }

  /// Start to keep updates of a peer. No effect where it is there already.
  void add_peer(PeerId peer);
  /// Forget a peer's updates, as when it leaves. Its counters stay.
  void remove_peer(PeerId peer);
  /// The same, its counters as well.
  void forget_peer(PeerId peer);

  /// Look at one update from an authenticated peer. @param now  session time, ns.
  /// No allocation but at the first update of a peer for a body.
  InboxVerdict offer(PeerId from, const StateUpdate& update, SessionTime now);

  /// What is kept of a body, by ascending peer; empty for unknown ids. Updates stay until a newer
  /// one, prune() or a removal: mind their age. Valid until the next change.
  std::span<const Received> newest(const SharedId& id) const;
  /// The same of the `index`th of all registered ids, in their order.
  /// @pre index < id_count()
  std::span<const Received> newest_at(std::size_t index) const { return bodies_[index].newest; }
  /// The peer has sent something at this session time, ns, however late that came: what it said of
  /// resting bodies before still holds. Stamps more than max_future ahead are ignored.
  /// @return whether it had fallen silent for longer than max_age: what it said was dropped
  bool note_alive(PeerId from, SessionTime stamp, SessionTime now);
  /// ns: the newest stamp of anything that the peer has sent; 0 = nothing yet.
  SessionTime alive(PeerId from) const;
  /// ns: until when a state of this inbox is known to hold: its stamp; of a resting body the newest
  /// stamp of anything that its sender has sent.
  SessionTime holds_until(const Received& received) const;
  /// Drop what has not held for max_age, or after a clock was set back is further ahead than
  /// max_future; returns how many.
  std::size_t prune(SessionTime now);

  /// All offers of all peers, unknown ones included.
  const InboxCounters& totals() const { return totals_; }
  /// Of one peer, also after its removal; zeros where it was never added.
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
  std::size_t next_ = 0;  ///< body after the last one offered: packets name them in order
};

}  // namespace tandem::consensus
