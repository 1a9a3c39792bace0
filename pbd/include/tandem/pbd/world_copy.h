// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <memory>

#include "tandem/pbd/export.h"
#include "tandem/pbd/world.h"

namespace tandem::pbd {

/// A deep copy of a world and its contact source, for rollback, planning and look-ahead. Stepped
/// with equal options it moves as the original does, bit for bit, and neither affects the other.
/// Reuse the object: assign() allocates only if the source has grown since.
///
/// Copied: bodies with slots, generations and activity, pending forces and kinematic targets, all
/// blocks in order with ids and carried multipliers, the contact source with its caches. Shared:
/// immutable data such as meshes and hulls.
/// Not copied: the target source (null in the copy; set another one if the copy must follow
/// targets) and external observers such as ContactEvents.
///
/// Unlike World::snapshot() it makes and checks no bytes, and it includes colliders and blocks,
/// which restoring a snapshot expects to find.
/// @par Thread safety  Distinct objects: safe. assign() and restore() use both worlds.
class TANDEM_API WorldCopy {
 public:
  WorldCopy();  ///< empty
  ~WorldCopy();
  WorldCopy(WorldCopy&& other) noexcept;  ///< leaves the other one empty
  WorldCopy& operator=(WorldCopy&& other) noexcept;
  WorldCopy(const WorldCopy&) = delete;
  WorldCopy& operator=(const WorldCopy&) = delete;

  /// Becomes a copy of `source`; not during one of its steps. References to blocks of world() stay
  /// valid if the source has the same kinds of blocks in the same order as the last one.
  /// @return false if a block or the contact source cannot be copied (see their make_empty()); the
  ///   copy is then empty
  bool assign(const World& source);
  /// Nothing was copied yet, or the last assign() failed: world() has no bodies and no blocks.
  bool empty() const { return !filled_; }

  /// The copied world, owned by this object, with the copied contact source.
  World& world() { return world_; }
  const World& world() const { return world_; }

  /// Rolls back `target`, the copied world or one that was built the same way, to the state of
  /// world(). Bodies, rows and colliders added since are removed; removed ones return under their
  /// ids. References to the target's blocks stay valid; its target source and contact source
  /// objects stay. Ids given out since may be given out again.
  /// @throws std::invalid_argument if the copy is empty, or the target has not the same kinds of
  ///   blocks in the same order and the same kind of contact source; it is then unchanged
  void restore(World& target) const;

  /// Sets the state of the body in a slot of world(). Unlike World::set_pose() it wakes no
  /// neighbours. A body that is set to sleep is woken by the next step if its twist is not zero or
  /// its island is awake.
  /// @param slot   slot of a body, below world().slot_count()
  /// @param state  finite, with a unit orientation; slot and state are checked by assertions only
  /// @param awake  whether a dynamic body is solved; no effect on others
  void set_state(std::uint32_t slot, const BodyState& state, bool awake);

  /// Like set_state() with an awake body that agreement has placed: joint violation there becomes
  /// no velocity in the next step, as with a PoseTarget (docs/method.md Sec. 3).
  void displace(std::uint32_t slot, const BodyState& state);

  /// Clears forces, torques and kinematic targets that were set for the next step.
  void clear_inputs();

 private:
  /// Whether blocks and contact source of `other` have the same kinds as those of world_, one by
  /// one.
  bool same_kinds(const World& other) const;
  /// Copies bodies and World's own data; blocks and sources stay.
  static void copy_bodies(const World& from, World& to);
  bool fill(const World& source);
  void clear();

  World world_;
  std::unique_ptr<ContactSource> contact_source_;  ///< contact source of world_
  bool filled_ = false;
};

}  // namespace tandem::pbd
