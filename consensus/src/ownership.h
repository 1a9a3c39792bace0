// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "tandem/consensus/inbox.h"
#include "tandem/consensus/update.h"

namespace tandem::consensus {

/// Who owns each body in the transactional scheme (Coupling::SingleOwner), as networked games do
/// it:
///
/// - A state says whether its sender owns the body (influence 1). Owners simulate; all others put
///   the body where its owner has it, and what they do to it lasts until the next step.
/// - Who acts on a body that is another's (takes hold of it, or touches it with a body that is
///   theirs for good) asks its owner for it, and asks again for as long as they act.
/// - The owner grants it, unless its own user acts on the body and began later than the one who
///   asks; of the same moment the lower id has it. It stops being the owner as it grants, the other
///   begins as the grant arrives: a round trip after the act, and never two at once.
/// - What nobody has said to own for `patience` seconds (nobody yet, or its owner has gone) belongs
///   to the lowest id that is present. Two who own a body all the same, as after a parted network,
///   hear of each other and the higher id gives way.
///
/// One object for all bodies of a peer, by their index.
class Ownership {
 public:
  /// @param patience  s
  Ownership(PeerId self, double patience);

  /// A body gets the index and those from there on move up by one.
  void insert(std::size_t index);
  /// A body loses it and those after it move down by one.
  void remove(std::size_t index);

  /// 0 = nobody, as far as is known here.
  PeerId owner(std::size_t index) const { return bodies_[index].owner; }
  bool mine(std::size_t index) const { return owner(index) == self_; }

  /// Another peer's message about a body.
  void hear(std::size_t index, PeerId from, const OwnershipUpdate& message, SessionTime now);
  /// Once each step, with the newest states of all peers. @param acting  this peer's user does
  void update(std::size_t index, const SharedId& id, std::span<const Inbox::Received> newest,
              bool acting, SessionTime now);
  /// Whether nobody has owned it for too long; then claim() it where this peer is the one to do so.
  bool abandoned(std::size_t index, SessionTime now) const;
  void claim(std::size_t index, SessionTime now);

  /// To be sent, requests to their `to` alone, grants to everybody; then cleared by the caller.
  std::vector<OwnershipUpdate>& outgoing() { return outgoing_; }

 private:
  struct Body {
    PeerId owner = 0;
    SessionTime since = 0;  ///< ns, stamp of the last grant: earlier claims are old news
    SessionTime heard = 0;  ///< ns, when somebody was last heard to own it; 0 = never asked
    SessionTime began = 0;  ///< ns, when the own user began to act; 0 = has not asked for it
    SessionTime acted = 0;  ///< ns, when the own user last did
    SessionTime asked = 0;  ///< ns
  };
  bool acts(const Body& body, SessionTime now) const;
  void hear_claims(Body& body, std::span<const Inbox::Received> newest, SessionTime now) const;

  PeerId self_;
  SessionTime patience_;
  std::vector<Body> bodies_;
  std::vector<OwnershipUpdate> outgoing_;
};

}  // namespace tandem::consensus
