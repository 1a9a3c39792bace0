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

/// A body as the pass sees it. The first two cache lines are all that a sweep over contacts reads
/// and writes. Lifetime: one step.
struct alignas(64) TANDEM_API SolverBody {
  Vec3 v = Vec3::Zero();              ///< m/s
  Vec3 w = Vec3::Zero();              ///< rad/s, world
  double inv_mass = 0.0;              ///< 1/kg, 0 = immovable
  Mat3 inv_inertia_w = Mat3::Zero();  ///< 1/(kg m^2), world

  Vec3 x = Vec3::Zero();       ///< m
  Quat q = Quat::Identity();   ///< local to world
  Vec3 dx = Vec3::Zero();      ///< m, what rows that project poses moved and v does not know yet
  Vec3 dtheta = Vec3::Zero();  ///< rad, world, likewise
  /// The part of v (m/s) and w (rad/s) that has moved the pose in this substep already.
  Vec3 v_applied = Vec3::Zero();
  Vec3 w_applied = Vec3::Zero();
  /// Displacement channel: velocities (m/s, rad/s, world) that move the pose in this substep and
  /// are then forgotten. They carry no momentum: bodies go to their targets and out of overlaps by
  /// them.
  Vec3 v_push = Vec3::Zero();
  Vec3 w_push = Vec3::Zero();
  double gravity_scale = 0.0;  ///< of the world's gravity; 0 where it cannot move
  std::uint32_t island = 0;    ///< lowest index of a body of its island
  /// Bodies of one group are solved together, with the same substeps. kNoGroup: immovable, asleep.
  std::uint32_t group = kNoGroup;
  bool shared = false;  ///< its island has a target in this step, or its joints a gap to close
  bool agreed = false;  ///< its island has a target: what joints violate there is agreement's
  bool held = false;    ///< contacts hold what displaces it: agreement, here or on another rank
  /// Some row of a block before contacts names it: its predicted pose is made before they project.
  bool projected = false;
  /// Some row of another block moves it afterwards.
  bool pushed = false;
  /// Something may turn it in this step. Where nothing can (no spin, no row with a lever arm), its
  /// inverse inertia is 0 for the step and its orientation is left alone.
  bool turns = false;
  bool turns_freely = true;  ///< no axis of its rotation is locked
  /// Its spin has changed by itself in this substep: the inertia is no longer that which rows were
  /// made with.
  bool reoriented = false;
  double stale = 0.0;  ///< rad by which the spin has turned within the body since then
  static constexpr std::uint32_t kNoGroup = 0xffffffffu;
  bool is_solved() const { return inv_mass > 0.0 && group != kNoGroup; }
  bool is_pushed() const { return pushed && group != kNoGroup; }  ///< in this step
};

/// Rows are projected block by block, in this order: the last writer wins, so non-penetration comes
/// last. Values in between are free for kinds of your own.
/// Blocks below Contact project *poses*: x and q are the predicted ones, dx and dtheta collect what
/// rows moved. Blocks from Contact on project *velocities*: v and w stand for all of the substep's
/// motion, what the others moved included; poses follow afterwards.
enum class SolveOrder : int { Compliant = 0, Joint = 100, Contact = 200 };

/// What is known of a group of bodies that are solved together, with the same substeps.
struct GroupFacts {
  int substeps = 1;
  bool one_island = false;
  bool at_once = false;  ///< other groups are solved at the same time
};

/// What a block is told about the substep.
struct TANDEM_API SubstepContext {
  /// By slot. Of bodies that cannot move only those are here that a block names in append_edges()
  /// or append_idle(): the rest are zeros.
  std::span<SolverBody> bodies = {};
  /// Those that may move, ascending: the bodies of all groups are among them.
  std::span<const std::uint32_t> movers = {};
  double h = 0.0;                ///< s, length of the substep
  int substep = 0;               ///< index within the step
  int substeps = 1;              ///< of the group
  int iteration = 0;             ///< of SolverOptions::position_iterations
  bool last = false;             ///< the last one of the step
  double joint_tolerance = 0.0;  ///< see SolverOptions
  bool reverse = false;          ///< sweep the rows backwards (alternates between substeps)
  Vec3 gravity = Vec3::Zero();   ///< m/s^2
  /// Verbs between begin_substep and finish_velocity concern only rows of this group: those one of
  /// whose bodies carries its number.
  std::uint32_t group = 0;
  std::span<const std::uint32_t> members = {};  ///< the bodies of the group, ascending
  /// Of the bodies that take as many substeps those of the group: what a budget for all of them has
  /// for it.
  double share_of_budget = 1.0;
  std::span<const GroupFacts> groups = {};  ///< all of the step
  Workers* workers = nullptr;  ///< may share the work of a verb; never null within a step
  /// Groups may be solved at once, one by each worker: the worker that has this one. Its scratch is
  /// nobody else's.
  int worker = 0;
  /// What is not taken by slot where the outcome depends on it: the order of rows, sums over
  /// bodies.
  BodyOrder order = {};
  bool shared = false;  ///< some body is
  /// By body: put where it is by agreement, before this step. What rows violate there is left to
  /// them as what agreement leaves within a step is: it becomes no velocity. Empty = none.
  std::span<const std::uint8_t> displaced = {};
};

/// What a block tells about itself after a step.
struct TANDEM_API BlockReport {
  std::string_view name = {};
  int rows = 0;
  int extra_rows = 0;     ///< solved again where it was needed, over all substeps
  int refined_rows = 0;   ///< solved in substeps beyond the solver's, over all of them
  int refused_rows = 0;   ///< of those, what islands wanted for the next step and do not get
  int open_rows = 0;      ///< left unsolved by that, in the substep with most of them
  double residual = 0.0;  ///< m, largest violation of a rigid row at the end of the step
  double displacement_residual = 0.0;  ///< m, largest part of it that agreement left behind
};

/// Two bodies that a row reads or moves, and what the row's last step says of their rest.
struct ConstraintEdge {
  /// Indices; BodyId::kNone stands for the world.
  std::uint32_t body_a = BodyId::kNone, body_b = BodyId::kNone;
  /// The row holds something: only what something immovable supports may rest, the rest is slow and
  /// drifts.
  bool supports = true;
  /// The row moves bodies by itself (a motor that runs, an anchor that moves): they do not rest,
  /// however slow they are.
  bool actuated = false;
  /// The row acts with a force of its own (springs, motors): its bodies rest where their speed does
  /// not change either.
  bool force_driven = false;
  /// Its island may be swept again within a substep where contacts have hit what joints hold.
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

/// All constraints of one kind in a world: the only thing that the solver knows of them. Each of
/// the eleven verbs of a step, `begin_step` to `end_step`, runs over all rows of the block, or over
/// those of a group. Only `project` must be given.
///
/// Two channels share one Jacobian (docs/ARCHITECTURE.md): the real one carries momentum; the
/// displacement channel moves bodies on towards their targets and never enters velocity. There a
/// row keeps the violation that it had, no more and no less, so that a vanishing target leaves no
/// trace.
class TANDEM_API ConstraintBlock {
 public:
  virtual ~ConstraintBlock() = default;

  virtual std::string_view name() const = 0;
  virtual int order() const = 0;
  virtual bool empty() const = 0;

  /// Once per step, poses as they are before the first substep.
  virtual void begin_step(const SubstepContext&) {}
  /// After begin_step: whether some row has a gap that the displacement channel is to close. The
  /// row has marked its bodies as shared then; what joints hold to them follows. Of bodies that it
  /// has marked as held their islands follow.
  virtual bool has_gaps() const { return false; }
  /// Before integration: poses and velocities are those of the end of the last substep.
  virtual void begin_substep(const SubstepContext&) {}
  /// After velocities have been integrated: apply carried multipliers to v and w.
  virtual void warm_start(const SubstepContext&) {}
  /// Real channel: move poses until the rows hold, once over all rows. Returns the largest move of
  /// an anchor that a row asked for, m: 0 where all rows held already.
  virtual double project(const SubstepContext&) = 0;
  /// Of rows on poses: velocities have learnt what `project` has moved.
  virtual void finish_projection(const SubstepContext&) {}
  /// One sweep over velocities. Returns the largest change of a row's velocity, m/s.
  virtual double solve_velocity(const SubstepContext&) { return 0.0; }
  /// Velocity work that is done once, after the iterations have converged.
  virtual void finish_velocity(const SubstepContext&) {}
  /// Displacement channel of rows on poses: remember the violation before bodies are displaced.
  virtual void begin_displacement(const SubstepContext&) {}
  /// Of rows on poses: move poses until they violate no more than before. Returns as `project`
  /// does. Of rows on velocities, in islands with a target: what bodies are displaced by, v_push
  /// and w_push, gives way so that the rows hold.
  virtual double project_displacement(const SubstepContext&) { return 0.0; }
  /// Remember what was left over, so that the real channel does not turn it into velocity.
  virtual void end_displacement(const SubstepContext&) {}
  /// Once per step; ctx.h is its length (s), ctx.substeps the solver's. Raise the entries of
  /// `wanted` (by body) for bodies whose rows need more substeps than that: their islands get them
  /// from the next step on. Empty where nothing is refined.
  virtual void end_step(const SubstepContext&, std::span<double> /*wanted*/) {}

  /// Whether verbs between begin_substep and finish_velocity may be called for several groups at
  /// once, by a worker each. They write nothing then that another group's rows read or write, no
  /// body that cannot move in particular. Groups with a row of another block are solved one after
  /// the other.
  virtual bool groups_at_once() const { return false; }

  /// Append an edge for each row that is active, which names every body that it reads or moves.
  virtual void append_edges(std::vector<ConstraintEdge>& /*edges*/) const {}
  /// Likewise for rows that are not active, where verbs of the block read their bodies all the
  /// same.
  virtual void append_idle(std::vector<ConstraintEdge>& /*edges*/) const {}
  /// Append the bodies at the other ends of those edges that name this one, where it is a body.
  /// Asked for each body that is set or removed: what looks at all rows for that, as this does,
  /// makes clearing a heap take as long as its square.
  virtual void append_joined(std::uint32_t body, std::vector<std::uint32_t>& joined) const;
  /// Append the pairs of bodies between which there are to be no contacts, in any order. Asked
  /// before contacts are looked for.
  virtual void append_apart(std::vector<BodyPair>& /*pairs*/) const {}
  /// Append the bodies whose rows were added, changed or removed since the last call: they wake.
  virtual void take_changed(std::vector<std::uint32_t>& /*bodies*/) {}
  /// A body is about to leave the world: drop the rows that name it.
  virtual void remove_body(BodyId) {}
  virtual BlockReport report() const = 0;
  virtual void save(ByteWriter& out) const = 0;
  /// The input is untrusted: fail `in` where they are none of save().
  virtual void load(ByteReader& in) = 0;
  /// After load(): whether all that rows name is in the world, and their parameters keep the rules.
  virtual bool fits(const World&) const { return true; }

  /// A block of the same kind without rows, for WorldCopy; null where the kind cannot be copied.
  virtual std::unique_ptr<ConstraintBlock> make_empty() const { return nullptr; }
  /// Become a deep copy of a block of the same kind: rows, ids, carried state, options. What never
  /// changes may be shared. Memory is used again: allocates only where the source has grown.
  /// @return false, and this block is as it was, where the source is of another kind
  virtual bool assign(const ConstraintBlock& /*source*/) { return false; }
};

}  // namespace tandem::pbd
