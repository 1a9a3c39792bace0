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

/// Ownership of each body in the transactional scheme (Coupling::SingleOwner), as in networked
/// games:
///
/// - A state says whether its sender owns the body (influence 1). Owners simulate; all others copy
/// the owner's state, and their own effect on the body lasts until the next step.
/// - A peer that acts on another's body (grabs it, or touches it with a body that it owns for good)
/// requests it from the owner, again and again while it acts.
/// - The owner grants the request, unless its own user acts on the body and began earlier; at equal
/// times the lower id wins. It stops owning as it grants, and the other begins as the grant
/// arrives: a round trip after the act, and never two owners at once.
/// - A body without an owner for InfluenceOptions::max_age (none yet, or it has left) belongs to
/// the lowest id present. If two peers own a body all the same, as after a network partition, the
/// higher id gives way once they hear of each other.
class Ownership {
 public:
  Ownership(PeerData& data, Connections& connections, const Activity& activity)
      : data_(data), connections_(connections), activity_(activity) {}

  /// Call once each step, with the messages since the last one.
  void update(std::span<const Receiver::OwnershipNews> news);

 private:
  void hear(Tenure& body, PeerId from, const OwnershipUpdate& message);
  void hear_claims(Tenure& body, std::span<const Inbox::Received> newest) const;
  /// @param acting  whether this peer's user acts on the body
  void act(Tenure& body, const SharedId& id, bool acting);
  bool acts(const Tenure& body) const;
  /// Whether it has had no owner for too long.
  bool abandoned(const Tenure& body) const;
  /// Send requests to their `to` alone, grants to everybody.
  void post();

  PeerData& data_;
  Connections& connections_;
  const Activity& activity_;
  std::vector<OwnershipUpdate> outgoing_;
};

}  // namespace tandem::consensus
