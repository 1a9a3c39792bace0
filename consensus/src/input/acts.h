// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "members/shared_bodies.h"
#include "receive/inbox.h"
#include "replay/world_history.h"
#include "tandem/consensus/peer.h"
#include "tandem/consensus/update.h"
#include "tandem/pbd/token_bucket.h"

namespace tandem::consensus {

/// The message to the other peers, without number and stamp.
inline ActUpdate as_update(const ActDef& def) {
  return {.body = def.body,
          .name = def.name,
          .impulse = def.impulse,
          .angular_impulse = def.angular_impulse,
          .pose = def.pose,
          .twist = def.twist};
}

/// Instantaneous acts of applications on shared bodies, by Peer::act(): own acts to announce, the
/// others' acts as applied here, and which peers have which act. docs/method.md Sec. 5.
class Acts {
 public:
  /// Acts that are accepted from one peer; it does any further ones alone.
  static constexpr double kAtOnce = 512.0;
  static constexpr double kPerSecond = 256.0;
  /// Cost of an act that sets a pose, in acts.
  static constexpr double kPlacing = 4.0;
  /// Acts of all peers that are remembered. docs/protocol.md has the bounds.
  static constexpr std::size_t kMaxOfAll = 8192;
  /// Receipts that are remembered.
  static constexpr std::size_t kMaxReceipts = 65536;

  Acts(pbd::World& world, WorldHistory& history, const PeerOptions& options)
      : world_(world), history_(history), options_(options), budget_(kPerSecond, kAtOnce) {}

  /// Do an own act. @param owned  only this peer owns the body
  /// @return false if there were too many for the others to accept
  bool act(const ActDef& def, SharedBody& shared, PeerId self, bool owned, SessionTime now);
  /// Do another peer's act on a local body without an owner. `newest` has its states.
  /// @param established  this peer no longer takes over the others' states
  /// @return false if it is too old, too new or beyond the limits
  bool receive(PeerId from, const ActUpdate& update, SharedBody& shared,
               std::span<const Inbox::Received> newest, bool established, pbd::TokenBucket& budget,
               SessionTime now);
  /// `from` has done an act on a local body.
  void receive(PeerId from, const ActReceipt& receipt, pbd::BodyId body);
  /// A step begins at `now`: date the acts before the first step, and forget old ones.
  void prepare(SessionTime now);
  void forget_body(pbd::BodyId body);

  /// Own acts and receipts that were not announced yet; appended.
  void announce(std::vector<ActUpdate>& acts, std::vector<ActReceipt>& receipts);

  /// The states of `newest` that include all acts on the body known here.
  std::span<const Inbox::Received> knowing(pbd::BodyId body, const Inbox& inbox,
                                           std::span<const Inbox::Received> newest);
  /// Whether that peer has acted on the body within the last second.
  bool acted(PeerId peer, pbd::BodyId body) const;
  /// Set `own` and `other` for bodies acted on since the last call; by slot.
  void mark(std::uint8_t own, std::uint8_t other, std::vector<std::uint8_t>& acting);

 private:
  struct Act {
    std::uint64_t serial = 0;  ///< increasing
    PeerId actor = 0;
    std::uint32_t number = 0;
    std::uint64_t name = 0;
    pbd::BodyId body = {};
    bool sets_pose = false;
    bool sets_twist = false;
    pbd::Twist change = {};  ///< of the twist, here
    SessionTime done = 0;    ///< ns
    SessionTime taken = 0;   ///< ns
  };
  /// That peer's states with later stamps include the act.
  struct Receipt {
    std::uint64_t act = 0;  ///< serial
    PeerId peer = 0;
    SessionTime stamp = 0;  ///< ns
  };
  struct Mark {
    std::uint32_t slot = 0;
    bool own = false;
  };

  /// Set pose and twist and add the impulses, within the limits. @return the change of twist
  pbd::Twist apply(const ActUpdate& act, SharedBody& shared);
  /// `after`, limited to the speed that hands may give, or to that of `before`.
  pbd::Twist within_limits(const pbd::Twist& before, const pbd::Twist& after) const;
  /// Apply another peer's act of `done` that is not superseded.
  pbd::Twist take(const ActUpdate& update, SharedBody& shared, SessionTime done,
                  std::span<const Inbox::Received> newest, PeerId from);
  /// Subtract from `late` what the body has already followed.
  /// @param sent  a state of the actor that includes the act
  /// @param before  state of the body without the act
  void follow(pbd::BodyId body, const Inbox::Received& sent, const pbd::BodyState& before,
              WorldHistory::Late& late) const;
  /// The part of an act's `change` that the body has gained since then, other acts excluded.
  double part_gained(pbd::BodyId body, const pbd::Twist& now, const pbd::Twist& change,
                     SessionTime done) const;
  /// The part of an act's `change`, 0 to 1, by which its actor's state, which includes it, is ahead
  /// of the local one.
  double part_missing(pbd::BodyId body, const Inbox::Received& sent,
                      const pbd::Twist& change) const;
  /// Whether a later act has set the body's pose or twist.
  bool is_superseded(pbd::BodyId body, bool sets_pose, SessionTime done, PeerId actor) const;
  Act* find(pbd::BodyId body, PeerId actor, std::uint32_t number, std::uint64_t name);
  bool lacks(const Act& act, const Inbox::Received& received, SessionTime until) const;
  void remember(Act act);
  void note_receipt(const Act& act, PeerId peer, SessionTime stamp);
  SessionTime last_frame(SessionTime now) const;

  pbd::World& world_;
  WorldHistory& history_;
  const PeerOptions& options_;
  pbd::TokenBucket budget_;           ///< of own acts
  std::vector<Act> acts_;             ///< by serial
  std::vector<Receipt> receipts_;     ///< by (act, peer)
  std::vector<std::uint16_t> count_;  ///< of acts_, by slot
  std::vector<ActUpdate> pending_;
  std::vector<ActReceipt> done_;  ///< to be announced
  std::vector<Mark> marks_;
  std::vector<Inbox::Received> heard_;  ///< scratch of knowing()
  std::uint64_t next_serial_ = 1;
  std::uint32_t next_number_ = 0;  ///< 0 until the first step
};

}  // namespace tandem::consensus
