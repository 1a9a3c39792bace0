// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "constraint_edges.h"
#include "groups.h"
#include "tandem/pbd/constraint.h"
#include "tandem/pbd/pose_target.h"
#include "tandem/pbd/report.h"
#include "tandem/pbd/sparse_array.h"
#include "tandem/pbd/workers.h"
#include "tandem/pbd/world.h"

namespace tandem::pbd {

/// The world's bodies as the pass sees them, by slot, for one step.
class BodyBuffer {
 public:
  /// Kinematic bodies with a target get the velocity that takes them there, in the world: whoever
  /// looks for contacts has to see it.
  static void aim_kinematic(World& world, double dt);
  /// Whether a step has nothing to do but to count time: all that it would look at rests as in
  /// the last ones, which found nothing either. What rests is found once more as it was and then
  /// repeats itself, the contacts of both bits for bits.
  bool rest(const World& world, double dt) const;
  /// After a step.
  /// @param still  nobody was awake or moved     @param may_rest  nor anything else was done
  void note_rest(World& world, double dt, bool still, bool may_rest);
  /// The next step is a whole one.
  void end_rest() { rest_.steps = 0; }
  /// Movers anew in each step; of the rest what was here and has changed.
  void load(World& world, Workers& workers);
  // What does not move is here from the first step on in which something names it.
  void load_named(const World& world, const ConstraintEdges& edges);
  void load_named(const World& world, std::span<const PoseTarget> targets);
  /// Bodies that may move, ascending; all of them where islands go on in other worlds.
  std::span<const std::uint32_t> movers() const { return movers_; }
  /// Which bodies have joints, and which ones rows that are solved later may move.
  void mark_joined(const ConstraintEdges& edges);
  /// Once it is known who is awake, joined and targeted: inertia of those that may turn.
  /// @param edges  of all rows but contacts
  /// @return how many those are
  int prepare(const World& world, std::span<const ConstraintEdge> edges,
              std::span<const Group> groups, Workers& workers);
  /// Inertia turns with what joints turn, within a substep. Contacts are solved with that of the
  /// pose that their rows were made for: where they moved a forearm by another one, sweeps grew
  /// without bound.
  void keep_inertias();
  void keep_inertia(std::uint32_t slot) {
    inertias_[slot] = {bodies_[slot].inv_inertia_w, bodies_[slot].q};
  }
  void restore_inertia(std::uint32_t slot) {
    bodies_[slot].inv_inertia_w = inertias_[slot].inverse;
  }
  /// Of a body that joints have turned: where it stands so far from the pose of its kept inertia
  /// that an impulse which takes energy by that one may add energy by its own, its rows are to be
  /// made anew.
  void renew_inertia(std::uint32_t slot, const BodyProps& props);
  std::span<SolverBody> all() { return bodies_; }
  SolverBody& operator[](std::size_t slot) { return bodies_[slot]; }
  std::size_t size() const { return bodies_.size(); }

  /// Whether a kinematic body is on its way.
  bool any_moving() const {
    return std::any_of(kinematic_.begin(), kinematic_.end(), [&](std::uint32_t i) {
      return !bodies_[i].v.isZero(0.0) || !bodies_[i].w.isZero(0.0);
    });
  }
  void move_kinematic(double h);
  /// Back to where the step began: each group that they touch sees them move.
  void rewind_kinematic(std::span<const BodyState> states);

  /// Back into the world. A body that became NaN or infinite stays where the step began, at
  /// rest, and is named in the report.
  void store(World& world, double dt, std::span<const Group> groups, Workers& workers,
             StepReport& report);
  /// Call visit(slot, body) for all that may move, shared out among workers.
  void for_movers(Workers& workers, auto&& visit) {
    workers.for_chunks(movers_.size(), kBodyGrain, [&](std::size_t begin, std::size_t end, int) {
      for (std::size_t k = begin; k < end; ++k) visit(movers_[k], bodies_[movers_[k]]);
    });
  }

 private:
  /// Bodies given to a worker at a time.
  static constexpr std::size_t kBodyGrain = 256;

  void mark_turned(const World& world, std::span<const ConstraintEdge> edges);
  void load_one(const World& world, std::uint32_t i);
  void load_once(const World& world, std::uint32_t i) {
    if (i < bodies_.size() && loaded_[i] == 0) load_one(world, i);
  }
  static void refuse(World& world, std::uint32_t i, StepReport& report);
  void store_kinematic(World& world, double dt, StepReport& report);
  static void mark_contacts(World& world);

  detail::SparseArray<SolverBody> bodies_;
  detail::SparseArray<std::uint8_t> loaded_;  ///< by slot: the body is here, and kept up to date
  std::span<const std::uint32_t> movers_;
  std::vector<std::uint32_t> every_slot_;  ///< where those are all
  struct {
    BodyLog::Mark since;  ///< of the world
    int steps = 0;        ///< in which nobody was awake and nothing was noted
    double dt = 0.0;      ///< s, of each
  } rest_;
  BodyLog::Mark seen_;                 ///< of what does not move
  std::vector<std::uint32_t> marked_;  ///< bodies that cannot move and bear marks of this step
  struct KeptInertia {
    Mat3 inverse;
    Quat q;  ///< the body's, for which it is
  };
  detail::SparseArray<KeptInertia> inertias_;  ///< by slot; where joints are
  std::vector<std::uint32_t> kinematic_;
};

}  // namespace tandem::pbd
