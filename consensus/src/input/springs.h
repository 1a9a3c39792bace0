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

/// All users' springs on one peer's world: its own, which it announces, and the others', which it
/// carries on from their last message. Each is a tether of the world.
class Springs {
 public:
  /// One peer can keep no more than this alive here; further ones are refused. Ten fingers that
  /// each hold a pose by three points, twice; a page of the demos takes eight. 64 that are
  /// 100 ms late cost a step of 64 bodies 0.6 ms, 256 2.1 (member_budget_test, [.measure]).
  static constexpr std::size_t kMaxPerPeer = 64;
  /// And all of them; who has most gives one up for who has fewer.
  static constexpr std::size_t kMaxOfAll = 1024;

  Springs(pbd::World& world, const PeerOptions& options);
  /// Nothing pulls any more, and the world has the blocks again that it had before: snapshots from
  /// then fit it, and it may get another peer.
  ~Springs();
  Springs(const Springs&) = delete;
  Springs& operator=(const Springs&) = delete;

  GrabId grab(const GrabDef& def, pbd::BodyId body);
  void move(GrabId id, const pbd::Vec3& anchor_w, SessionTime now);
  void release(GrabId id, SessionTime now);

  enum class Verdict : std::uint8_t {
    Taken,
    Limited,  ///< taken, with less strength or speed than it asks for
    Refused,
  };
  /// Apply another peer's message. `body` is the local instance of update.body; where there is none
  /// the spring is remembered, and pulls from the first anchor on that comes once there is one.
  Verdict receive(PeerId from, const SpringUpdate& update, pbd::BodyId body, SessionTime now);
  /// What another peer last said of a spring; null where nothing is known of it.
  const SpringUpdate* last_of(PeerId from, std::uint32_t spring);
  /// Let go what a peer holds, for good.
  void drop_peer(PeerId from, SessionTime now);
  /// Let go all springs on a body.
  void forget_body(pbd::BodyId body, SessionTime now);
  /// Let go what has not been heard of for too long, or was before the clock was set back, and set
  /// all anchors for a step from `now` on.
  /// @param dt  s, of that step
  void prepare(SessionTime now, double dt);

  /// Own springs as they are at `now`, and events not announced yet (which are then taken as such).
  void announce(SessionTime now, std::vector<SpringUpdate>& states,
                std::vector<SpringUpdate>& events);

  /// All that pull, own and remote, as they do in the step to come; appended.
  void pulls(std::vector<pbd::Tether::Def>& out) const;
  /// Own ones as they do in the step to come.
  void record(std::vector<Pull>& out) const;
  /// The others' as they pulled in the step of `dt` s from `time` on, by all that is known of them
  /// now; appended. @param world  as it was then
  void others_at(const pbd::World& world, SessionTime time, double dt,
                 std::vector<pbd::Tether::Def>& out) const;
  /// Put the anchor of `def` where a hand is taken to be `age` s after `hand` was told.
  void carry_on(const HandFilter::Motion& hand, double age, pbd::Tether::Def& def) const;
  const pbd::Tethers& block() const { return tethers_; }
  /// All rows of block(); appended.
  void rows(std::vector<pbd::ConstraintId>& out) const;
  bool holds(pbd::BodyId body) const;
  /// Whether that own spring is there, and its body.
  bool holds(GrabId id) const;
  /// How users hold a body, as bits.
  enum Grip : std::uint8_t {
    kShared = 1,  ///< by an own spring that all peers simulate
    kAlone = 2,   ///< by another own one
    kRemote = 4,  ///< by another user's
  };
  /// What all users hold, own ones as of `self`; appended.
  void held(PeerId self, std::vector<HeldBody>& out) const;
  /// Set those bits of all bodies that somebody holds; by slot.
  void mark(std::vector<std::uint8_t>& grips) const;
  /// How many springs of that peer's user hold the body.
  int held_by(PeerId peer, pbd::BodyId body);
  /// Whether an own spring that no other peer simulates holds the body.
  bool holds_alone(pbd::BodyId body) const;
  /// An own spring's hand in hard mode.
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
    pbd::Tether::Def limited = {};  ///< its strength by itself
    SessionTime moved = 0;          ///< ns, of the anchor; 0 = never
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
    SessionTime ended = 0;  ///< ns, once it is let go: since then it does not pull
    SessionTime heard = 0;
    pbd::ConstraintId tether = {};
    HandTrack hand = {};
    pbd::Tether::Def def = {};  ///< of the last message, as it was limited
    /// What is left of def's force, stiffness and damping, where its user has more springs on the
    /// body than the limits bear together.
    SpringStrength share{.force = 1.0, .stiffness = 1.0, .damping = 1.0};
    int together = 1;   ///< of its user on the body, while it pulled last
    bool live = false;  ///< false: removed, kept a while so that late messages do not revive it
  };

  std::vector<Remote>::iterator place_of(PeerId peer, std::uint32_t spring);
  /// All that is known of that peer's; valid until one comes or goes.
  std::span<Remote> of(PeerId peer);
  bool holds(const Own& own) const {
    return own.mode == InputMode::Hard || tethers_.contains(own.tether);
  }
  /// Whether it has a row: none where it was let go, or its body is gone.
  bool pulls(const Remote& remote) const { return remote.live && tethers_.contains(remote.tether); }
  void let_go(Remote& remote, SessionTime when);
  /// Make a place in remote_ for one more of that peer's, of its own or of who has most.
  /// @return whether there is one
  bool make_room(PeerId from);
  pbd::Tether::Def pull_at(const Remote& remote, SessionTime time) const;
  /// After one of that peer's springs on the body has come, changed or gone.
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
