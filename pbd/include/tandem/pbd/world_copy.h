// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <memory>

#include "tandem/pbd/export.h"
#include "tandem/pbd/world.h"

namespace tandem::pbd {

/// A deep copy of a world and of its contact source, for rollback, planning and look-ahead: stepped
/// with equal options it moves as the original does, bit for bit, and neither knows of the other.
/// Keep the object and assign() to it again and again: that allocates only where the source has
/// grown since.
///
/// Copied: bodies with their slots, generations and activity, forces and kinematic targets not
/// consumed yet, all blocks in their order with their ids and carried multipliers, the contact
/// source with its caches. Shared: what never changes, such as meshes and hulls.
/// Not copied: the target source (the copy's is null, set one of its own where it is to follow
/// targets), and whoever reads the world from outside, such as ContactEvents.
///
/// Unlike World::snapshot() it makes no bytes and checks none, and it carries what snapshots want
/// to find: colliders and blocks are part of it.
/// @par Thread safety  Distinct objects: safe. assign() and restore() use both worlds.
class TANDEM_API WorldCopy {
 public:
  WorldCopy();  ///< empty
  ~WorldCopy();
  WorldCopy(WorldCopy&& other) noexcept;  ///< leaves the other one empty
  WorldCopy& operator=(WorldCopy&& other) noexcept;
  WorldCopy(const WorldCopy&) = delete;
  WorldCopy& operator=(const WorldCopy&) = delete;

  /// Become a copy of `source`, not during one of its steps. References to blocks of world() stay
  /// valid where the source has the same kinds of blocks in the same order as the last one.
  /// @return false where a block or the contact source cannot be copied (see their make_empty());
  ///   the copy is then empty
  bool assign(const World& source);
  /// Nothing was copied yet, or the last assign() failed: world() then has no bodies and no blocks.
  bool empty() const { return !filled_; }

  /// The copied world, owned by this object; its contact source is the copied one.
  World& world() { return world_; }
  const World& world() const { return world_; }

  /// Roll back: make `target`, the world that was copied or one that was built the same way, what
  /// world() is now. Bodies, rows and colliders that were added since are gone, those that were
  /// removed are back under their ids; references to the target's blocks stay valid, and it keeps
  /// its target source and the object that is its contact source. Ids that were given out since
  /// may be given out once more.
  /// @throws std::invalid_argument where the copy is empty, or the target has not the same kinds of
  ///   blocks in the same order and the same kind of contact source; it is then as it was
  void restore(World& target) const;

  /// Set the state of the body in a slot of world(). Nothing else happens: unlike World::set_pose()
  /// it wakes no neighbours. A body that is told to sleep is woken by the next step as ever, where
  /// its twist is not zero or its island is awake.
  /// @param slot   below world().slot_count(), of a body
  /// @param state  finite, with a unit orientation; slot and state are checked by assertions only
  /// @param awake  whether a dynamic body is solved; of no effect on others
  void set_state(std::uint32_t slot, const BodyState& state, bool awake);

  /// The same of a body that others agree is there, awake: what joints violate there becomes no
  /// velocity in the next step, as with a PoseTarget (docs/method.md Sec. 3).
  void displace(std::uint32_t slot, const BodyState& state);

  /// Forget what was asked of world() for its next step: forces, torques, kinematic targets.
  void clear_inputs();

 private:
  /// Whether the blocks and the contact source of `other` are of the same kinds as those of world_,
  /// one by one.
  bool same_kinds(const World& other) const;
  /// Bodies and all that World keeps itself; blocks and sources stay.
  static void copy_bodies(const World& from, World& to);
  bool fill(const World& source);
  void clear();

  World world_;
  std::unique_ptr<ContactSource> contact_source_;  ///< that of world_
  bool filled_ = false;
};

}  // namespace tandem::pbd
