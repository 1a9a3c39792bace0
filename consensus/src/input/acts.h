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

/// As it goes to the others, without number and stamp.
inline ActUpdate as_update(const ActDef& def) {
  return {.body = def.body,
          .name = def.name,
          .impulse = def.impulse,
          .angular_impulse = def.angular_impulse,
          .pose = def.pose,
          .twist = def.twist};
}

/// Acts: what applications do to shared bodies at once, by Peer::act(). Own ones to announce, the
/// others' as they were taken here, and who has which. docs/method.md Sec. 5.
class Acts {
 public:
  /// One peer may do no more; what is more is done by itself alone.
  static constexpr double kAtOnce = 512.0;
  static constexpr double kPerSecond = 256.0;
  /// Of these, an act that puts a body somewhere counts so many.
  static constexpr double kPlacing = 4.0;
  /// Of all peers that are remembered. docs/protocol.md has the bounds.
  static constexpr std::size_t kMaxOfAll = 8192;
  /// And what is remembered of who has them.
  static constexpr std::size_t kMaxReceipts = 65536;

  Acts(pbd::World& world, WorldHistory& history, const PeerOptions& options)
      : world_(world), history_(history), options_(options), budget_(kPerSecond, kAtOnce) {}

  /// Do an own one. @param owned  the body is this peer's alone
  /// @return false where there are too many for the others to take
  bool act(const ActDef& def, SharedBody& shared, PeerId self, bool owned, SessionTime now);
  /// Do another peer's, a body that is here and that nobody owns. `newest` has its states.
  /// @param established  this peer does not take over what others have any more
  /// @return false where it is too old, too new or of too many
  bool receive(PeerId from, const ActUpdate& update, SharedBody& shared,
               std::span<const Inbox::Received> newest, bool established, pbd::TokenBucket& budget,
               SessionTime now);
  /// `from` has done an act to a body that is here.
  void receive(PeerId from, const ActReceipt& receipt, pbd::BodyId body);
  /// A step begins at `now`: date what was done before the first one, forget what is old.
  void prepare(SessionTime now);
  void forget_body(pbd::BodyId body);

  /// Own acts and receipts not announced yet; appended.
  void announce(std::vector<ActUpdate>& acts, std::vector<ActReceipt>& receipts);

  /// Those of `newest` that are no older than what is known to have been done to the body.
  std::span<const Inbox::Received> knowing(pbd::BodyId body, const Inbox& inbox,
                                           std::span<const Inbox::Received> newest);
  /// Whether that peer has acted on the body lately.
  bool acted(PeerId peer, pbd::BodyId body) const;
  /// Set `own` and `other` of bodies that were acted on since the last call; by slot.
  void mark(std::uint8_t own, std::uint8_t other, std::vector<std::uint8_t>& acting);

 private:
  struct Act {
    std::uint64_t serial = 0;  ///< grows
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
  /// States of that peer that are stamped later have the act.
  struct Receipt {
    std::uint64_t act = 0;  ///< serial
    PeerId peer = 0;
    SessionTime stamp = 0;  ///< ns
  };
  struct Mark {
    std::uint32_t slot = 0;
    bool own = false;
  };

  /// Set pose and twist and add the impulses, within the limits. @return the change of the twist
  pbd::Twist apply(const ActUpdate& act, SharedBody& shared);
  /// `after`, no faster than hands make anything, or than it was.
  pbd::Twist within_limits(const pbd::Twist& before, const pbd::Twist& after) const;
  /// Carry out another peer's act of `done` that is not superseded.
  pbd::Twist take(const ActUpdate& update, SharedBody& shared, SessionTime done,
                  std::span<const Inbox::Received> newest, PeerId from);
  /// Take out of `late` what the body has followed already.
  /// @param sent    a state of the actor that has it
  /// @param before  of the body, without it
  void follow(pbd::BodyId body, const Inbox::Received& sent, const pbd::BodyState& before,
              WorldHistory::Late& late) const;
  /// The part of an act's `change` that the body has gained since it was done, other acts left out.
  double part_gained(pbd::BodyId body, const pbd::Twist& now, const pbd::Twist& change,
                     SessionTime done) const;
  /// The part of an act's `change` that a state of its actor, which has it, is ahead of here: 0 to
  /// 1.
  double part_missing(pbd::BodyId body, const Inbox::Received& sent,
                      const pbd::Twist& change) const;
  /// Whether the body's pose or twist was set by somebody after that.
  bool is_superseded(pbd::BodyId body, bool sets_pose, SessionTime done, PeerId actor) const;
  Act* find(pbd::BodyId body, PeerId actor, std::uint32_t number, std::uint64_t name);
  bool lacks(const Act& act, const Inbox::Received& received, SessionTime until) const;
  void remember(Act act);
  void note_receipt(const Act& act, PeerId peer, SessionTime stamp);
  SessionTime last_frame(SessionTime now) const;

  pbd::World& world_;
  WorldHistory& history_;
  const PeerOptions& options_;
  pbd::TokenBucket budget_;           ///< of own ones
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
