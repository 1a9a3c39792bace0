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
  double radius = 8.0;  ///< m: a user is told of bodies up to here
  double slack = 1.0;   ///< m: and that much further of one that he was told of

  /// @throws std::invalid_argument naming field, value and rule
  void validate() const;
};

/// Tells each of the others of what is near its user, of what he holds, and of what touches or is
/// joined to what he holds.
///
/// Each step, before Peer::after_step: update(). A user is where set_position() says; without that
/// where his hand is that last held something. Who has no place is told of everything.
/// @par Thread safety  One object: the thread that steps its world.
class TANDEM_API NearbyInterest final : public Interest {
 public:
  /// World and peer must outlive it; it becomes the peer's interest, until it goes.
  /// @throws std::invalid_argument (NearbyInterestOptions::validate)
  NearbyInterest(const pbd::World& world, Peer& peer, const NearbyInterestOptions& options = {});
  ~NearbyInterest() override;
  NearbyInterest(const NearbyInterest&) = delete;
  NearbyInterest& operator=(const NearbyInterest&) = delete;

  /// Another peer's user is there, m, world; not finite: he has no place.
  void set_position(PeerId user, const pbd::Vec3& position);
  /// That peer is gone.
  void forget(PeerId user);
  /// A step was made: see who holds what, and what touches it.
  void update();

  bool concerns(PeerId to, const SharedId& id, const pbd::Pose& pose) const override;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tandem::consensus
