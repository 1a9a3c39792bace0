// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <span>
#include <vector>

#include "input/activity.h"
#include "members/connections.h"
#include "peer_data.h"
#include "receive/receiver.h"

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
/// - What nobody has said to own for InfluenceOptions::max_age (nobody yet, or its owner has gone)
///   belongs to the lowest id that is present. Two who own a body all the same, as after a parted
///   network, hear of each other and the higher id gives way.
class Ownership {
 public:
  Ownership(PeerData& data, Connections& connections, const Activity& activity)
      : data_(data), connections_(connections), activity_(activity) {}

  /// Once each step, with what has been said since the last one.
  void update(std::span<const Receiver::OwnershipNews> news);

 private:
  void hear(Tenure& body, PeerId from, const OwnershipUpdate& message);
  void hear_claims(Tenure& body, std::span<const Inbox::Received> newest) const;
  /// @param acting  this peer's user does
  void act(Tenure& body, const SharedId& id, bool acting);
  bool acts(const Tenure& body) const;
  /// Whether nobody has owned it for too long.
  bool abandoned(const Tenure& body) const;
  /// Requests to their `to` alone, grants to everybody.
  void post();

  PeerData& data_;
  Connections& connections_;
  const Activity& activity_;
  std::vector<OwnershipUpdate> outgoing_;
};

}  // namespace tandem::consensus
