// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "input/hand_track.h"
#include "input/spring_limits.h"
#include "replay/world_history.h"
#include "tandem/consensus/peer.h"
#include "tandem/consensus/update.h"
#include "tandem/pbd/tether.h"

namespace tandem::consensus {

/// All users' springs on one peer's world, each a tether: its own, which it announces, and the
/// others', extrapolated from their last message.
class Springs {
 public:
  /// Live springs accepted from one peer; further ones are refused. It covers ten fingers that each
  /// hold a pose by three points, twice; a page of the demos takes eight. 64 that are 100 ms late
  /// cost a step of 64 bodies 0.6 ms, 256 2.1 (member_budget_test, [.measure]).
  static constexpr std::size_t kMaxPerPeer = 64;
  /// Springs of all peers; at the limit the peer with most loses one to a peer with fewer.
  static constexpr std::size_t kMaxOfAll = 1024;

  Springs(pbd::World& world, const PeerOptions& options);
  /// Removes all springs and their block: the world's earlier snapshots fit again, and it may get
  /// another peer.
  ~Springs();
  Springs(const Springs&) = delete;
  Springs& operator=(const Springs&) = delete;

  GrabId grab(const GrabDef& def, pbd::BodyId body);
  void move(GrabId id, const pbd::Vec3& anchor_w, SessionTime now);
  void release(GrabId id, SessionTime now);

  enum class Verdict : std::uint8_t {
    Taken,
    Limited,  ///< accepted with reduced strength or speed
    Refused,
  };
  /// Apply another peer's message. `body` is the local instance of update.body. Without one the
  /// spring is remembered, and pulls from the first anchor after the instance appears.
  Verdict receive(PeerId from, const SpringUpdate& update, pbd::BodyId body, SessionTime now);
  /// A peer's last message about a spring; null if there is none.
  const SpringUpdate* last_of(PeerId from, std::uint32_t spring);
  /// Release a peer's springs for good.
  void drop_peer(PeerId from, SessionTime now);
  /// Release all springs on a body.
  void forget_body(pbd::BodyId body, SessionTime now);
  /// Release springs not heard of for too long, or heard before the clock was set back, and set all
  /// anchors for a step from `now` on.
  /// @param dt  s, of that step
  void prepare(SessionTime now, double dt);

  /// Own springs as they are at `now`, and events not announced yet, which then count as announced.
  void announce(SessionTime now, std::vector<SpringUpdate>& states,
                std::vector<SpringUpdate>& events);

  /// All springs that pull, own and remote, as in the step to come; appended.
  void pulls(std::vector<pbd::Tether::Def>& out) const;
  /// Own springs as in the step to come.
  void record(std::vector<Pull>& out) const;
  /// The others' springs as they pulled in the step of `dt` s from `time` on, by all that is known
  /// now; appended. @param world  as it was then
  void others_at(const pbd::World& world, SessionTime time, double dt,
                 std::vector<pbd::Tether::Def>& out) const;
  /// Extrapolate the anchor of `def` to `age` s after `hand`.
  void carry_on(const HandFilter::Motion& hand, double age, pbd::Tether::Def& def) const;
  const pbd::Tethers& block() const { return tethers_; }
  /// All rows of block(); appended.
  void rows(std::vector<pbd::ConstraintId>& out) const;
  bool holds(pbd::BodyId body) const;
  /// Whether an own spring and its body exist.
  bool holds(GrabId id) const;
  /// How users hold a body, bits.
  enum Grip : std::uint8_t {
    kShared = 1,  ///< an own spring that all peers simulate
    kAlone = 2,   ///< an own spring that only this peer simulates
    kRemote = 4,  ///< another user's spring
  };
  /// Bodies held by all users, own ones as of `self`; appended.
  void held(PeerId self, std::vector<HeldBody>& out) const;
  /// Set these bits for all held bodies; by slot.
  void mark(std::vector<std::uint8_t>& grips) const;
  /// Number of that peer's springs on the body.
  int held_by(PeerId peer, pbd::BodyId body);
  /// Whether an own spring that only this peer simulates holds the body.
  bool holds_alone(pbd::BodyId body) const;
  /// Hand of an own spring in hard mode.
  struct Hand {
    pbd::Vec3 attachment_l;
    pbd::Vec3 anchor_w;  ///< m, world
  };
  /// The hands that drag a body, as they are at `now`; appended.
  void hands(pbd::BodyId body, SessionTime now, std::vector<Hand>& out) const;

 private:
  struct Own {
    std::uint32_t spring = 0;
    std::uint32_t revision = 0;
    GrabDef def;
    pbd::BodyId body = {};
    InputMode mode = InputMode::Soft;
    pbd::ConstraintId tether = {};  ///< none in hard mode
    pbd::Tether::Def limited = {};  ///< limited by itself
    SessionTime moved = 0;          ///< ns, of the last move; 0 = never
    HandFilter hand = {};
    HandTrack told = {};
    bool announced = false;

    const pbd::Vec3& velocity() const { return hand.motion().velocity; }
    SpringUpdate message(SpringEvent event, SessionTime now) const;
  };
  struct Remote {
    PeerId peer = 0;
    SpringUpdate last = {};
    SessionTime began = 0;  ///< ns, stamp of the first message
    SessionTime ended = 0;  ///< ns, when it was released
    SessionTime heard = 0;
    pbd::ConstraintId tether = {};
    HandTrack hand = {};
    pbd::Tether::Def def = {};  ///< of the last message, limited by itself
    /// Fractions left of def's force, stiffness and damping if its user's springs on the body
    /// exceed the limits together.
    SpringStrength share{.force = 1.0, .stiffness = 1.0, .damping = 1.0};
    int together = 1;   ///< springs of its user on the body, when it last pulled
    bool live = false;  ///< false: removed; kept against late messages
  };

  std::vector<Remote>::iterator place_of(PeerId peer, std::uint32_t spring);
  /// All remembered springs of that peer; valid until one is added or removed.
  std::span<Remote> of(PeerId peer);
  bool holds(const Own& own) const {
    return own.mode == InputMode::Hard || tethers_.contains(own.tether);
  }
  /// Whether it has a tether: not after its release, or if its body is gone.
  bool pulls(const Remote& remote) const { return remote.live && tethers_.contains(remote.tether); }
  void let_go(Remote& remote, SessionTime when);
  /// Make a place in remote_ for a spring of that peer, at its own cost or that of the peer with
  /// most.
  /// @return whether there is one
  bool make_room(PeerId from);
  pbd::Tether::Def pull_at(const Remote& remote, SessionTime time) const;
  /// Update the shares of a peer's springs on the body after one was added, changed or removed.
  void share_out(PeerId from, pbd::BodyId body);

  pbd::World& world_;
  const PeerOptions& options_;
  SpringLimits limits_;
  pbd::Tethers& tethers_;
  std::vector<Own> own_;               ///< by spring
  std::vector<Remote> remote_;         ///< by (peer, spring)
  std::vector<SpringUpdate> pending_;  ///< removals to announce
  std::uint32_t next_ = 0;             ///< 0 until the first step
};

}  // namespace tandem::consensus
