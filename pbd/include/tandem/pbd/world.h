// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "tandem/pbd/body.h"
#include "tandem/pbd/body_log.h"
#include "tandem/pbd/change_count.h"
#include "tandem/pbd/constraint.h"
#include "tandem/pbd/export.h"
#include "tandem/pbd/kinematic_targets.h"
#include "tandem/pbd/manifold.h"
#include "tandem/pbd/pose_target.h"
#include "tandem/pbd/props_table.h"
#include "tandem/pbd/slots.h"
#include "tandem/pbd/sparse_array.h"

namespace tandem::pbd {

class BodyBuffer;
class ContactBlock;
class IslandCoupling;
class WorldCopy;

namespace detail {

/// A non-owning pointer that is null after it was moved from.
template <class T>
class Borrowed {
 public:
  // NOLINTNEXTLINE(google-explicit-constructor): it stands for the pointer
  Borrowed(T* pointer = nullptr) : pointer_(pointer) {}
  Borrowed(Borrowed&& other) noexcept : pointer_(std::exchange(other.pointer_, nullptr)) {}
  Borrowed& operator=(Borrowed&& other) noexcept {
    pointer_ = std::exchange(other.pointer_, nullptr);
    return *this;
  }
  operator T*() const { return pointer_; }  // NOLINT(google-explicit-constructor): as above
  T* operator->() const { return pointer_; }

 private:
  T* pointer_;
};

}  // namespace detail

struct TANDEM_API WorldDef {
  Vec3 gravity = Vec3(0.0, 0.0, -9.81);  ///< m/s^2
};

/// Bodies, the blocks of constraints between them, and the sources of contacts and targets. It
/// holds everything that a step depends on (Solver keeps scratch only).
///
/// Errors: all mutators throw std::invalid_argument naming field, value and rule, and leave the
/// world as it was. Ids of removed bodies are refused the same way.
/// Returned references and spans point into its arrays: they are valid until a body is added,
/// removed or changes type, a block is added or removed, or restore().
/// @par Thread safety  Distinct worlds: safe. One world: one thread at a time.
class TANDEM_API World {
 public:
  explicit World(const WorldDef& def = {});
  ~World();
  World(World&&) noexcept;  ///< leaves the other one without bodies, blocks and sources
  World& operator=(World&&) noexcept;
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  /// Reserves memory for so many bodies in all, before a large scene is built.
  void reserve(std::size_t bodies);
  BodyId add_body(const BodyDef& def);
  /// Removes the body and every constraint row that names it.
  void remove_body(BodyId id);
  bool contains(BodyId id) const;
  /// The id of the body in slot `index`, or an invalid id if the slot is empty.
  BodyId body_at(std::uint32_t index) const;
  /// Number of slots, used or free; indices are below it.
  std::uint32_t slot_count() const;
  std::size_t body_count() const;

  /// The body with this stable id, or an invalid id if there is none.
  BodyId find(std::uint64_t stable_id) const;
  BodyOrder order() const;

  const BodyState& state(BodyId id) const;
  const Pose& pose(BodyId id) const { return state(id).pose; }
  const Twist& twist(BodyId id) const { return state(id).twist; }
  const BodyProps& props(BodyId id) const;
  void set_pose(BodyId id, const Pose& pose);
  void set_twist(BodyId id, const Twist& twist);
  /// Moves a kinematic body to `pose` within the next step; after that it stands still.
  void set_kinematic_target(BodyId id, const Pose& pose);
  void set_damping(BodyId id, double linear, double angular);  ///< 1/s, >= 0
  void set_gravity_scale(BodyId id, double scale);
  void set_locks(BodyId id, const AxisLocks& locks);
  /// Makes a body of any type dynamic; its velocity stays.
  /// @param inertia  kg m^2, as in BodyDef::inertia
  void set_mass(BodyId id, double mass, const Mat3& inertia);
  /// Changes the mass of a dynamic body; its inertia is scaled with it.
  void set_mass(BodyId id, double mass);
  /// Makes a body Static, which stops it, or Kinematic, which keeps its velocity; set_mass() makes
  /// bodies dynamic. Touching bodies wake.
  void set_type(BodyId id, BodyType type);
  /// A number for the application, an index or an address; Tandem does not read it. Snapshots do
  /// not include it; restore() keeps it for each body that exists before and after.
  std::uint64_t user_data(BodyId id) const;
  void set_user_data(BodyId id, std::uint64_t value);

  /// Adds to the force on a dynamic body during the next step.
  /// @param force  N, world
  void apply_force(BodyId id, const Vec3& force);
  /// @param point_w  m, world, point of application
  void apply_force(BodyId id, const Vec3& force, const Vec3& point_w);
  void apply_torque(BodyId id, const Vec3& torque);  ///< N m, world
  /// Changes a dynamic body's velocity at once. @param impulse  N s, world, at the centre of mass
  void apply_impulse(BodyId id, const Vec3& impulse);
  void apply_impulse(BodyId id, const Vec3& impulse, const Vec3& point_w);
  void apply_angular_impulse(BodyId id, const Vec3& impulse);  ///< N m s, world
  /// By slot: sum of apply_force() and apply_torque() for the next step. Empty if nothing was
  /// applied since the last step.
  std::span<const Wrench> wrenches() const { return wrenches_; }
  /// The target set by set_kinematic_target() for the next step, if any.
  std::optional<Pose> kinematic_target(BodyId id) const {
    return kinematic_targets_.pose_of(checked_index(id, "kinematic_target"));
  }
  /// All targets set by set_kinematic_target() for the next step, at most one per body.
  std::span<const KinematicTarget> kinematic_targets() const { return kinematic_targets_.all(); }

  /// Whether the body is solved; a sleeping one stands still until something disturbs its island.
  /// Every mutator that changes a body wakes it.
  bool awake(BodyId id) const;
  void wake(BodyId id);
  /// By slot, without generation check; immovable bodies count as awake while they move.
  bool awake_at(std::uint32_t index) const { return !activity_[index].asleep; }
  /// By slot, without generation check: what the solver remembers of bodies.
  std::span<const BodyActivity> activities() const { return activity_; }
  /// Sets a body to a former state or one from another world. Neither it nor its neighbours are
  /// woken. If it is set to sleep, the usual rules of the next step may wake it.
  /// @throws std::invalid_argument if a number is not finite or the orientation is not unit
  void resume(BodyId id, const BodyState& state, const BodyActivity& activity);
  /// Changes when WorldCopy::set_state() or resume() has moved a sleeping body: contact sources
  /// that skip sleeping bodies must look at all of them then.
  std::uint64_t sleepers_moved() const { return sleepers_moved_; }
  /// Changes whenever a body may have been added, removed or moved, by a step or by hand: while it
  /// is constant, cached poses are valid.
  std::uint64_t placements() const { return placements_.value(); }
  /// Slots of dynamic and kinematic bodies, ascending. A step looks at these and at the entries of
  /// body_log() only.
  std::span<const std::uint32_t> movers() {
    return body_log_.movers(
        states_.size(), [&](std::uint32_t slot) { return props_[slot].type != BodyType::Static; });
  }
  const BodyLog& body_log() const { return body_log_; }
  /// By slot, without generation check, for loops over all bodies.
  std::span<const BodyState> states() const { return states_; }
  const PropsTable& all_props() const { return props_; }

  /// Adds a block of constraints: `auto& joints = world.add_block<JointBlock>();`. References stay
  /// valid until the block is removed or the world dies (moves keep them).
  template <class Block, class... Args>
  Block& add_block(Args&&... args) {
    auto block = std::make_unique<Block>(std::forward<Args>(args)...);
    Block& reference = *block;
    insert_block(std::move(block));
    return reference;
  }
  /// Removes a block with all its rows and wakes the bodies that they named; the other blocks keep
  /// their order. References to the block become invalid. Not during a step.
  /// @throws std::invalid_argument if it is not one of blocks(), or is the one of contacts(), which
  ///   lives as long as the world
  void remove_block(const ConstraintBlock& block);
  /// In the order of solving.
  std::span<const std::unique_ptr<ConstraintBlock>> blocks() const { return blocks_; }

  /// Contacts from `source` are solved from the next step on; null: none. The source must outlive
  /// its use here.
  void set_contact_source(ContactSource* source);
  ContactSource* contact_source() const { return contact_source_; }
  /// The contacts of the last step; null before the first contact source.
  const ContactBlock* contacts() const { return contacts_; }
  /// Targets from `source` are solved from the next step on; it must outlive its use here.
  void set_target_source(TargetSource* source) { target_source_ = source; }
  TargetSource* target_source() const { return target_source_; }
  /// Connects islands to other worlds from the next step on; null: none. It must outlive its use
  /// here.
  void set_island_coupling(IslandCoupling* coupling) {
    island_coupling_ = coupling;
    body_log_.outdate();
  }

  /// Effect of agreement on a body in the last step; zeros if nothing was shared.
  Correction correction(BodyId id) const;
  /// Whether the body had a contact force in the last step.
  bool in_contact(BodyId id) const;

  const Vec3& gravity() const { return gravity_; }
  void set_gravity(const Vec3& gravity);
  /// s, sum of all steps.
  double time() const { return time_; }

  /// Kinetic energy (J) of all dynamic bodies.
  double kinetic_energy() const;
  /// Kinetic plus gravitational energy (J), zero height at the origin.
  double mechanical_energy() const;

  /// Everything that the next step depends on, as bytes: bodies, blocks with carried multipliers,
  /// caches of the contact source. restore() needs a world built the same way (same blocks in the
  /// same order, same kind of source); otherwise it throws std::invalid_argument and leaves this
  /// world as it was. The input is untrusted: names of missing things and non-finite numbers are
  /// refused.
  std::vector<std::byte> snapshot() const;
  void restore(std::span<const std::byte> bytes);
  /// 64-bit hash over all poses and twists: equal bits, equal hash.
  std::uint64_t hash() const;

 private:
  friend class BodyBuffer;
  friend class Solver;
  friend class WorldCopy;

  void insert_block(std::unique_ptr<ConstraintBlock> block);
  std::uint32_t checked_index(BodyId id, const char* what) const;
  std::uint32_t checked_dynamic(BodyId id, const char* what) const;
  /// Adds to the force on a dynamic body. @throws std::invalid_argument if the sum is not finite
  void add_wrench(std::uint32_t index, const Wrench& wrench, const char* what);
  /// N s and N m s about the centre of mass. @throws std::invalid_argument if the velocity is not
  /// finite
  void add_impulse(std::uint32_t index, const Wrench& impulse, const char* what);
  /// Tells readers of body_log() to look at the body again.
  void note(std::uint32_t index) { body_log_.note(index, states_.size()); }
  void wake_up(std::uint32_t index);
  /// Wakes the bodies that rows join to the body.
  void wake_joined(std::uint32_t index);
  /// Reads the rest of a snapshot after its head. @return false if it cannot be a world's
  bool read(ByteReader& in);

  Vec3 gravity_;
  double time_ = 0.0;
  std::vector<BodyState> states_;
  PropsTable props_;
  Slots slots_;
  std::map<std::uint64_t, std::uint32_t> by_stable_id_;  ///< slots
  /// Data of order(), made on demand; empty if no body has a stable id.
  mutable std::vector<std::uint32_t> ranks_;
  mutable std::vector<std::uint32_t> slots_by_rank_;
  mutable bool order_is_old_ = false;
  std::vector<Correction> corrections_;         ///< empty if no target was ever solved
  std::vector<std::uint8_t> in_contact_;        ///< by slot, from the last step
  std::vector<std::uint32_t> touching_;         ///< slots set in in_contact_, with duplicates
  detail::SparseArray<BodyActivity> activity_;  ///< by slot
  std::uint64_t sleepers_moved_ = 0;
  ChangeCount placements_;
  BodyLog body_log_;
  std::vector<Wrench> wrenches_;         ///< by slot, for the next step; empty if there are none
  KinematicTargets kinematic_targets_;   ///< for the next step
  std::vector<std::uint8_t> displaced_;  ///< by slot, before the next step; empty = none
  struct UserData {
    std::uint32_t generation = 0;  ///< generation of its body
    std::uint64_t value = 0;
  };
  std::vector<UserData> user_data_;    ///< by slot; slots beyond its end have 0
  std::vector<std::uint32_t> joined_;  ///< scratch of wake_joined()
  std::vector<std::unique_ptr<ConstraintBlock>> blocks_;
  detail::Borrowed<ContactBlock> contacts_;  ///< one of blocks_
  detail::Borrowed<ContactSource> contact_source_;
  detail::Borrowed<TargetSource> target_source_;
  detail::Borrowed<IslandCoupling> island_coupling_;
};

}  // namespace tandem::pbd
