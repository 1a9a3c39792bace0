// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <memory>

#include "tandem/consensus/peer.h"
#include "tandem/pbd/export.h"
#include "tandem/pbd/types.h"
#include "tandem/pbd/world.h"

namespace tandem::consensus {

struct TANDEM_API NearbyInterestOptions {
  double radius = 8.0;  ///< m: a user receives the states of bodies within this distance
  double slack = 1.0;   ///< m: hysteresis, added for bodies that the user already receives

  /// @throws std::invalid_argument naming field, value and rule
  void validate() const;
};

/// Sends each peer the bodies near its user, those the user holds, and those that touch or are
/// joined to what the user holds.
///
/// Each step, before Peer::after_step: update(). A user's position is the one set by
/// set_position(), or else the hand that last held something. A user without a position receives
/// everything.
/// @par Thread safety  One object: the thread that steps its world.
class TANDEM_API NearbyInterest final : public Interest {
 public:
  /// World and peer must outlive it. It is the peer's interest for its lifetime.
  /// @throws std::invalid_argument (NearbyInterestOptions::validate)
  NearbyInterest(const pbd::World& world, Peer& peer, const NearbyInterestOptions& options = {});
  ~NearbyInterest() override;
  NearbyInterest(const NearbyInterest&) = delete;
  NearbyInterest& operator=(const NearbyInterest&) = delete;

  /// Position of another peer's user, m, world; not finite = unknown.
  void set_position(PeerId user, const pbd::Vec3& position);
  /// Drop what is stored of a peer that has left.
  void forget(PeerId user);
  /// Call after each step: finds who holds what and what touches it.
  void update();

  bool concerns(PeerId to, const SharedId& id, const pbd::Pose& pose) const override;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tandem::consensus
