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

/// A pointer to what others own, or something else of the holder does: null in what was moved from.
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
  operator T*() const { return pointer_; }  // NOLINT(google-explicit-constructor): likewise
  T* operator->() const { return pointer_; }

 private:
  T* pointer_;
};

}  // namespace detail

struct TANDEM_API WorldDef {
  Vec3 gravity = Vec3(0.0, 0.0, -9.81);  ///< m/s^2
};

/// Bodies, the blocks of constraints between them, and where contacts and targets come from.
/// Everything that a step depends on is in here (Solver keeps scratch only).
///
/// Errors: all mutators throw std::invalid_argument naming field, value and rule, and leave the
/// world as it was. Ids of removed bodies are refused the same way.
/// References and spans that it returns are into its arrays: they are good until a body is added or
/// removed or gets another type, a block comes or goes, or restore().
/// @par Thread safety  Distinct worlds: safe. One world: one thread at a time.
class TANDEM_API World {
 public:
  explicit World(const WorldDef& def = {});
  ~World();
  World(World&&) noexcept;  ///< the other one has no bodies, blocks and sources then
  World& operator=(World&&) noexcept;
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  /// Make room for so many bodies in all, before a large scene is built.
  void reserve(std::size_t bodies);
  BodyId add_body(const BodyDef& def);
  /// Removes the body and every constraint row that names it.
  void remove_body(BodyId id);
  bool contains(BodyId id) const;
  /// The id of the body in slot `index`, or an invalid id where the slot is empty.
  BodyId body_at(std::uint32_t index) const;
  /// Slots in use or free; indices are below this.
  std::uint32_t slot_count() const;
  std::size_t body_count() const;

  /// The body with this stable id, or an invalid id where there is none.
  BodyId find(std::uint64_t stable_id) const;
  BodyOrder order() const;

  const BodyState& state(BodyId id) const;
  const Pose& pose(BodyId id) const { return state(id).pose; }
  const Twist& twist(BodyId id) const { return state(id).twist; }
  const BodyProps& props(BodyId id) const;
  void set_pose(BodyId id, const Pose& pose);
  void set_twist(BodyId id, const Twist& twist);
  /// Move a kinematic body so that it is at `pose` after the next step; it stands still after that.
  void set_kinematic_target(BodyId id, const Pose& pose);
  void set_damping(BodyId id, double linear, double angular);  ///< 1/s, >= 0
  void set_gravity_scale(BodyId id, double scale);
  void set_locks(BodyId id, const AxisLocks& locks);
  /// Of a living body: it is dynamic from then on, whatever it was; its velocity stays.
  /// @param inertia  kg m^2, as BodyDef::inertia
  void set_mass(BodyId id, double mass, const Mat3& inertia);
  /// Of a dynamic body: it gets denser or lighter, and its inertia with it.
  void set_mass(BodyId id, double mass);
  /// Make it Static, which stops it, or Kinematic, which goes on as it went; set_mass() makes
  /// bodies dynamic. What touches it wakes.
  void set_type(BodyId id, BodyType type);
  /// The application's own number, an index or an address: nothing here reads it. No snapshot has
  /// it; restore() leaves that of each body that is the same one before and after.
  std::uint64_t user_data(BodyId id) const;
  void set_user_data(BodyId id, std::uint64_t value);

  /// Add to what acts on a dynamic body during the next step.
  /// @param force  N, world
  void apply_force(BodyId id, const Vec3& force);
  /// @param point_w  m, world, where it acts
  void apply_force(BodyId id, const Vec3& force, const Vec3& point_w);
  void apply_torque(BodyId id, const Vec3& torque);  ///< N m, world
  /// Change a dynamic body's velocity at once. @param impulse  N s, world, at the centre of mass
  void apply_impulse(BodyId id, const Vec3& impulse);
  void apply_impulse(BodyId id, const Vec3& impulse, const Vec3& point_w);
  void apply_angular_impulse(BodyId id, const Vec3& impulse);  ///< N m s, world
  /// By slot: the sum of what apply_force() and apply_torque() collected for the next step. Empty
  /// where nothing was applied since the last one.
  std::span<const Wrench> wrenches() const { return wrenches_; }
  /// None where set_kinematic_target() has given it none for the next step.
  std::optional<Pose> kinematic_target(BodyId id) const {
    return kinematic_targets_.pose_of(checked_index(id, "kinematic_target"));
  }
  /// What set_kinematic_target() collected for the next step, at most one for each body.
  std::span<const KinematicTarget> kinematic_targets() const { return kinematic_targets_.all(); }

  /// Whether the body is solved; a sleeping one stands still until something disturbs its island.
  /// Every mutator that changes a body wakes it.
  bool awake(BodyId id) const;
  void wake(BodyId id);
  /// By slot, without the generation check; immovable bodies count as awake where they move.
  bool awake_at(std::uint32_t index) const { return !activity_[index].asleep; }
  /// By slot, likewise: what the solver remembers of bodies.
  std::span<const BodyActivity> activities() const { return activity_; }
  /// Make a body what it was in another world, or before: nothing is woken, neither it nor what it
  /// touches. One that is told to sleep is woken by the next step as ever.
  /// @throws std::invalid_argument where a number is not finite or the orientation is not unit
  void resume(BodyId id, const BodyState& state, const BodyActivity& activity);
  /// Another number than before where WorldCopy::set_state() or resume() has moved a body and let
  /// it sleep: a contact source that passes over sleeping bodies looks at all of them then.
  std::uint64_t sleepers_moved() const { return sleepers_moved_; }
  /// Another number than before where a body may have come, gone or been put elsewhere, by a step
  /// or by hand: who remembers where bodies are need not look at them all to see that they are.
  std::uint64_t placements() const { return placements_.value(); }
  /// Slots of dynamic and kinematic bodies, ascending: all that a step looks at but for what
  /// body_log() names.
  std::span<const std::uint32_t> movers() {
    return body_log_.movers(
        states_.size(), [&](std::uint32_t slot) { return props_[slot].type != BodyType::Static; });
  }
  const BodyLog& body_log() const { return body_log_; }
  /// By slot, without the generation check, for loops over all bodies.
  std::span<const BodyState> states() const { return states_; }
  const PropsTable& all_props() const { return props_; }

  /// Add a block of constraints: `auto& joints = world.add_block<JointBlock>();`. References stay
  /// valid until the block is removed or the world dies (moves keep them).
  template <class Block, class... Args>
  Block& add_block(Args&&... args) {
    auto block = std::make_unique<Block>(std::forward<Args>(args)...);
    Block& reference = *block;
    insert_block(std::move(block));
    return reference;
  }
  /// Removes a block with all its rows and wakes the bodies that they named; the others keep their
  /// order. The reference is dead after that. Not during a step.
  /// @throws std::invalid_argument where it is none of blocks(), or is the one of contacts(), which
  ///   stays as long as the world
  void remove_block(const ConstraintBlock& block);
  /// In the order in which they are solved.
  std::span<const std::unique_ptr<ConstraintBlock>> blocks() const { return blocks_; }

  /// Contacts from `source` are solved from the next step on; none where it is null. The caller
  /// keeps it alive.
  void set_contact_source(ContactSource* source);
  ContactSource* contact_source() const { return contact_source_; }
  /// The contacts of the last step; null before the first contact source.
  const ContactBlock* contacts() const { return contacts_; }
  /// Targets from `source` are solved from the next step on. The caller keeps it alive.
  void set_target_source(TargetSource* source) { target_source_ = source; }
  TargetSource* target_source() const { return target_source_; }
  /// Islands may go on in other worlds from the next step on; null: none does. The caller keeps it
  /// alive.
  void set_island_coupling(IslandCoupling* coupling) {
    island_coupling_ = coupling;
    body_log_.outdate();
  }

  /// What agreement did to a body in the last step; zeros where nothing was shared.
  Correction correction(BodyId id) const;
  /// Whether the body felt a contact in the last step.
  bool in_contact(BodyId id) const;

  const Vec3& gravity() const { return gravity_; }
  void set_gravity(const Vec3& gravity);
  /// s, sum of all steps.
  double time() const { return time_; }

  /// Kinetic energy (J) of all dynamic bodies.
  double kinetic_energy() const;
  /// Kinetic plus gravitational energy (J), zero height at the origin.
  double mechanical_energy() const;

  /// Everything that the next step depends on, as bytes: bodies, blocks with their carried
  /// multipliers, the contact source's caches. restore() wants a world built the same way (same
  /// blocks in the same order, same kind of source) and throws std::invalid_argument otherwise,
  /// leaving this world as it was. The bytes may be anybody's: what would name things that are not
  /// there, or is not a number, is refused.
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
  /// Of a dynamic body. @throws std::invalid_argument where the sum is not finite
  void add_wrench(std::uint32_t index, const Wrench& wrench, const char* what);
  /// N s and N m s about the centre of mass, likewise.
  void add_impulse(std::uint32_t index, const Wrench& impulse, const char* what);
  /// Who has not seen the body for a while looks at it again.
  void note(std::uint32_t index) { body_log_.note(index, states_.size()); }
  void wake_up(std::uint32_t index);
  /// Wakes what rows hold to the body.
  void wake_joined(std::uint32_t index);
  /// What snapshot() wrote after its head. @return false where it cannot be a world's
  bool read(ByteReader& in);

  Vec3 gravity_;
  double time_ = 0.0;
  std::vector<BodyState> states_;
  PropsTable props_;
  Slots slots_;
  std::map<std::uint64_t, std::uint32_t> by_stable_id_;  ///< slots
  /// What order() shows, made when it is asked for; empty where no body has a stable id.
  mutable std::vector<std::uint32_t> ranks_;
  mutable std::vector<std::uint32_t> slots_by_rank_;
  mutable bool order_is_old_ = false;
  std::vector<Correction> corrections_;   ///< empty where no target was ever solved
  std::vector<std::uint8_t> in_contact_;  ///< by slot, from the last step
  std::vector<std::uint32_t> touching_;   ///< where in_contact_ is set; some may be there twice
  detail::SparseArray<BodyActivity> activity_;  ///< by slot
  std::uint64_t sleepers_moved_ = 0;
  ChangeCount placements_;
  BodyLog body_log_;
  std::vector<Wrench> wrenches_;         ///< by slot, for the next step; empty where none acts
  KinematicTargets kinematic_targets_;   ///< for the next step
  std::vector<std::uint8_t> displaced_;  ///< by slot, before the next step; empty = none
  struct UserData {
    std::uint32_t generation = 0;  ///< of the body that it belongs to
    std::uint64_t value = 0;
  };
  std::vector<UserData> user_data_;    ///< by slot; those behind its end are 0
  std::vector<std::uint32_t> joined_;  ///< scratch of wake_joined()
  std::vector<std::unique_ptr<ConstraintBlock>> blocks_;
  detail::Borrowed<ContactBlock> contacts_;  ///< one of blocks_
  detail::Borrowed<ContactSource> contact_source_;
  detail::Borrowed<TargetSource> target_source_;
  detail::Borrowed<IslandCoupling> island_coupling_;
};

}  // namespace tandem::pbd
