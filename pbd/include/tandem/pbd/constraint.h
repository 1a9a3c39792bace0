// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <compare>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "tandem/pbd/body.h"
#include "tandem/pbd/export.h"

namespace tandem::pbd {

class BodySet;
class ByteReader;
class ByteWriter;
class Workers;
class World;

/// A body as the solver sees it. A sweep over contacts reads and writes only the first two cache
/// lines. Lifetime: one step.
struct alignas(64) TANDEM_API SolverBody {
  Vec3 v = Vec3::Zero();              ///< m/s
  Vec3 w = Vec3::Zero();              ///< rad/s, world
  double inv_mass = 0.0;              ///< 1/kg, 0 = immovable
  Mat3 inv_inertia_w = Mat3::Zero();  ///< 1/(kg m^2), world

  Vec3 x = Vec3::Zero();       ///< m
  Quat q = Quat::Identity();   ///< local to world
  Vec3 dx = Vec3::Zero();      ///< m, moved by rows that project poses and not yet part of v
  Vec3 dtheta = Vec3::Zero();  ///< rad, world: the rotation that belongs to dx
  /// The part of v (m/s) and w (rad/s) that has moved the pose in this substep.
  Vec3 v_applied = Vec3::Zero();
  Vec3 w_applied = Vec3::Zero();
  /// Displacement channel: velocities (m/s, rad/s, world) that move the pose in this substep and
  /// are then dropped. They carry no momentum; they move bodies to targets and out of overlaps.
  Vec3 v_push = Vec3::Zero();
  Vec3 w_push = Vec3::Zero();
  double gravity_scale = 0.0;  ///< times the world's gravity; 0 for immovable bodies
  std::uint32_t island = 0;    ///< lowest index of a body in its island
  /// Bodies of one group are solved together, with the same substeps. kNoGroup: immovable or
  /// asleep.
  std::uint32_t group = kNoGroup;
  bool shared = false;  ///< its island has a target in this step, or a joint gap to close
  bool agreed = false;  ///< its island has a target: joint violation there is left to agreement
  bool held = false;  ///< contacts oppose its displacement (by agreement, here or on another rank)
  /// A row of a block before contacts names it: its predicted pose is needed before those project.
  bool projected = false;
  /// A contact or a row of a later block names it.
  bool pushed = false;
  /// Something may turn it in this step. Otherwise (no spin, no row with a lever arm) its inverse
  /// inertia is 0 for the step and its orientation stays.
  bool turns = false;
  bool turns_freely = true;  ///< no rotation axis is locked
  /// Torque-free rotation has turned it in this substep: its inertia differs from the one that rows
  /// were prepared with.
  bool reoriented = false;
  double stale = 0.0;  ///< rad, turn of the spin axis in the body frame since then
  static constexpr std::uint32_t kNoGroup = 0xffffffffu;
  bool is_solved() const { return inv_mass > 0.0 && group != kNoGroup; }
  bool is_pushed() const { return pushed && group != kNoGroup; }  ///< in this step
};

/// Rows are projected block by block, in this order. The last block wins, so non-penetration is
/// last. Values in between are free for your own kinds.
/// Blocks below Contact project *poses*: x and q are predicted, dx and dtheta collect what rows
/// moved. Blocks from Contact on project *velocities*: v and w include all motion of the substep,
/// that of pose rows too; poses follow afterwards.
enum class SolveOrder : int { Compliant = 0, Joint = 100, Contact = 200 };

/// Facts about a group of bodies that are solved together, with the same substeps.
struct GroupFacts {
  int substeps = 1;
  bool one_island = false;
  bool at_once = false;  ///< other groups are solved at the same time, by other workers
};

/// The substep, as a block sees it.
struct TANDEM_API SubstepContext {
  /// By slot. Immovable bodies are filled in only if a block names them in append_edges() or
  /// append_idle(); the others are zeros.
  std::span<SolverBody> bodies = {};
  /// Slots of bodies that may move, ascending; includes the bodies of all groups.
  std::span<const std::uint32_t> movers = {};
  double h = 0.0;                ///< s, length of the substep
  int substep = 0;               ///< index within the step
  int substeps = 1;              ///< substeps of the group
  int iteration = 0;             ///< index within SolverOptions::position_iterations
  bool last = false;             ///< last substep of the step
  double joint_tolerance = 0.0;  ///< see SolverOptions
  bool reverse = false;          ///< sweep rows backwards; alternates between substeps
  Vec3 gravity = Vec3::Zero();   ///< m/s^2
  /// Verbs between begin_substep and finish_velocity concern only rows of this group: rows with a
  /// body that carries its number.
  std::uint32_t group = 0;
  std::span<const std::uint32_t> members = {};  ///< the bodies of the group, ascending
  /// The group's share of a budget for all groups that take as many substeps.
  double share_of_budget = 1.0;
  std::span<const GroupFacts> groups = {};  ///< all groups of the step
  Workers* workers = nullptr;  ///< may share the work of a verb; never null during a step
  /// Index of the worker that solves this group; groups may be solved at once, one per worker. Use
  /// it to select scratch memory.
  int worker = 0;
  /// Use this order, not slots, wherever the outcome depends on an order: of rows, of sums over
  /// bodies.
  BodyOrder order = {};
  bool shared = false;  ///< some body is shared
  /// By body: 1 = agreement placed it before this step. Violation of its rows becomes no velocity,
  /// as with displacement within a step. Empty = none.
  std::span<const std::uint8_t> displaced = {};
};

/// Report of a block after a step.
struct TANDEM_API BlockReport {
  std::string_view name = {};
  int rows = 0;
  int extra_rows = 0;     ///< solved again for convergence, over all substeps
  int refined_rows = 0;   ///< solved in substeps beyond the solver's, over all of them
  int refused_rows = 0;   ///< refined rows that islands want in the next step and do not get
  int open_rows = 0;      ///< left unconverged by the budget, in the worst substep
  double residual = 0.0;  ///< m, largest violation of a rigid row at the end of the step
  double displacement_residual = 0.0;  ///< m, largest part of the violation that agreement left
};

/// Two bodies that a row reads or moves, and what the row says about their rest.
struct ConstraintEdge {
  /// Indices; BodyId::kNone stands for the world.
  std::uint32_t body_a = BodyId::kNone, body_b = BodyId::kNone;
  /// The row supports its bodies. A body may sleep only if immovable bodies support it; one without
  /// support is slow and drifts.
  bool supports = true;
  /// The row moves bodies by itself (a running motor, a moving anchor): they do not sleep, however
  /// slow they are.
  bool actuated = false;
  /// The row has a force of its own (springs, motors): its bodies sleep only if their speed is
  /// constant too.
  bool force_driven = false;
  /// Contacts of its island may be swept again within a substep after they hit jointed bodies.
  bool repeats = true;
};

/// Two bodies by slot, low < high.
struct BodyPair {
  std::uint32_t low = 0, high = 0;

  static BodyPair of(std::uint32_t a, std::uint32_t b) {
    return a < b ? BodyPair{a, b} : BodyPair{b, a};
  }
  friend auto operator<=>(const BodyPair&, const BodyPair&) = default;
};

/// All constraints of one kind in a world; the solver knows them only through this interface. Each
/// of the eleven verbs of a step, `begin_step` to `end_step`, runs over all rows of the block, or
/// over those of a group. Only `project` is mandatory.
///
/// Two channels share one Jacobian (docs/ARCHITECTURE.md). The real channel carries momentum. The
/// displacement channel moves bodies towards their targets and never enters velocity; in it a row
/// keeps exactly its previous violation, so that a vanishing target leaves no trace.
class TANDEM_API ConstraintBlock {
 public:
  virtual ~ConstraintBlock() = default;

  virtual std::string_view name() const = 0;
  virtual int order() const = 0;
  virtual bool empty() const = 0;

  /// Once per step, with poses as before the first substep.
  virtual void begin_step(const SubstepContext&) {}
  /// After begin_step: whether some row has a gap that the displacement channel must close. Such a
  /// row has marked its bodies as shared; bodies jointed to them follow. If it has marked bodies as
  /// held, their islands follow.
  virtual bool has_gaps() const { return false; }
  /// Before integration, with poses and velocities from the end of the last substep.
  virtual void begin_substep(const SubstepContext&) {}
  /// After velocities are integrated: apply carried multipliers to v and w.
  virtual void warm_start(const SubstepContext&) {}
  /// Real channel: one sweep that moves poses until each row holds. Returns the largest anchor move
  /// that a row asked for, m; 0 if all rows held already.
  virtual double project(const SubstepContext&) = 0;
  /// For rows on poses: velocities now include what `project` moved.
  virtual void finish_projection(const SubstepContext&) {}
  /// One sweep over velocities. Returns the largest change of a row's velocity, m/s.
  virtual double solve_velocity(const SubstepContext&) { return 0.0; }
  /// Velocity work done once, after the iterations have converged.
  virtual void finish_velocity(const SubstepContext&) {}
  /// Displacement channel, rows on poses: remember the violation before bodies are displaced.
  virtual void begin_displacement(const SubstepContext&) {}
  /// Rows on poses: move poses until they violate no more than before. Rows on velocities, in
  /// islands with a target: reduce the displacement v_push and w_push so that the rows hold.
  /// Returns as `project` does.
  virtual double project_displacement(const SubstepContext&) { return 0.0; }
  /// Remember the remaining violation, so that the real channel does not turn it into velocity.
  virtual void end_displacement(const SubstepContext&) {}
  /// Once per step; ctx.h is the step's length (s), ctx.substeps the solver's number. Raise the
  /// entries of `wanted` (by body) for bodies whose rows need more substeps: their islands get them
  /// from the next step on. `wanted` is empty if nothing is refined.
  virtual void end_step(const SubstepContext&, std::span<double> /*wanted*/) {}

  /// Whether verbs between begin_substep and finish_velocity may be called for several groups at
  /// once, one per worker. If true, they must write nothing that rows of another group read or
  /// write; in particular no immovable body. Groups with rows of a block that returns false are
  /// solved one after the other.
  virtual bool groups_at_once() const { return false; }

  /// Append an edge for each active row, naming every body that it reads or moves.
  virtual void append_edges(std::vector<ConstraintEdge>& /*edges*/) const {}
  /// Append edges of inactive rows whose bodies the block's functions still read.
  virtual void append_idle(std::vector<ConstraintEdge>& /*edges*/) const {}
  /// Append the bodies that rows join to this body. Called for each body that is set or removed.
  /// This default looks at all rows, which makes clearing a heap quadratic: override it for large
  /// blocks.
  virtual void append_joined(std::uint32_t body, std::vector<std::uint32_t>& joined) const;
  /// Append the pairs of bodies that must not have contacts, in any order. Called before collision
  /// detection.
  virtual void append_apart(std::vector<BodyPair>& /*pairs*/) const {}
  /// Append the bodies whose rows were added, changed or removed since the last call: they are
  /// woken.
  virtual void take_changed(std::vector<std::uint32_t>& /*bodies*/) {}
  /// A body is about to be removed: drop the rows that name it.
  virtual void remove_body(BodyId) {}
  virtual BlockReport report() const = 0;
  virtual void save(ByteWriter& out) const = 0;
  /// The input is untrusted: fail `in` if it is not from save().
  virtual void load(ByteReader& in) = 0;
  /// After load(): whether all named bodies are in the world and all parameters are valid.
  virtual bool fits(const World&) const { return true; }

  /// An empty block of the same kind, for WorldCopy; null if the kind cannot be copied.
  virtual std::unique_ptr<ConstraintBlock> make_empty() const { return nullptr; }
  /// Become a deep copy of a block of the same kind: rows, ids, carried state, options. Immutable
  /// data may be shared. Memory is reused: allocates only if the source has grown.
  /// @return false, leaving this block as it was, if the source is of another kind
  virtual bool assign(const ConstraintBlock& /*source*/) { return false; }
};

}  // namespace tandem::pbd
