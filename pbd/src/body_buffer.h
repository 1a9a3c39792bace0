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

/// The world's bodies as the solver sees them, by slot, for one step.
class BodyBuffer {
 public:
  /// Sets the twist of kinematic bodies with a target so that they reach it. Written to the world,
  /// because contact detection needs it.
  static void aim_kinematic(World& world, double dt);
  /// Whether a step only has to advance the time: everything it reads rests as in the last steps,
  /// which did nothing either. A body that comes to rest is solved once more; after that contacts
  /// repeat bit for bit.
  bool rest(const World& world, double dt) const;
  /// Update after a step.
  /// @param still  no body was awake or moved     @param may_rest  and nothing else was done
  void note_rest(World& world, double dt, bool still, bool may_rest);
  /// Makes the next step a full one.
  void end_rest() { rest_.steps = 0; }
  /// Loads movers in each step, other bodies only if they were loaded before and have changed.
  void load(World& world, Workers& workers);
  // Immovable bodies are loaded in the first step in which something names them.
  void load_named(const World& world, const ConstraintEdges& edges);
  void load_named(const World& world, std::span<const PoseTarget> targets);
  /// Bodies that may move, ascending; every slot if there is an island coupling.
  std::span<const std::uint32_t> movers() const { return movers_; }
  /// Marks bodies with joints, and bodies that later rows may move.
  void mark_joined(const ConstraintEdges& edges);
  /// Computes the inertia of bodies that may turn, once awake, jointed and target bodies are known.
  /// @param edges  of all rows but contacts
  /// @return the number of bodies that may turn
  int prepare(const World& world, std::span<const ConstraintEdge> edges,
              std::span<const Group> groups, Workers& workers);
  /// Keeps the inertias of bodies that joints turn within a substep. Contacts are solved with the
  /// inertia of the pose that their rows were made for: with another one for a forearm, sweeps grew
  /// without bound.
  void keep_inertias();
  void keep_inertia(std::uint32_t slot) {
    inertias_[slot] = {bodies_[slot].inv_inertia_w, bodies_[slot].q};
  }
  void restore_inertia(std::uint32_t slot) {
    bodies_[slot].inv_inertia_w = inertias_[slot].inverse;
  }
  /// Renews the inertia of a body that joints have turned. If its pose is so far from that of the
  /// kept inertia that an impulse which removes energy by the kept one may add energy by its own,
  /// its rows must be made again.
  void renew_inertia(std::uint32_t slot, const BodyProps& props);
  std::span<SolverBody> all() { return bodies_; }
  SolverBody& operator[](std::size_t slot) { return bodies_[slot]; }
  std::size_t size() const { return bodies_.size(); }

  /// Whether a kinematic body moves.
  bool any_moving() const {
    return std::any_of(kinematic_.begin(), kinematic_.end(), [&](std::uint32_t i) {
      return !bodies_[i].v.isZero(0.0) || !bodies_[i].w.isZero(0.0);
    });
  }
  void move_kinematic(double h);
  /// Resets them to the start of the step, as each group that they touch must see them move.
  void rewind_kinematic(std::span<const BodyState> states);

  /// Writes the bodies back to the world. A body that became NaN or infinite stays where the step
  /// began, at rest, and is named in the report.
  void store(World& world, double dt, std::span<const Group> groups, Workers& workers,
             StepReport& report);
  /// Calls visit(slot, body) for all bodies that may move, divided among workers.
  void for_movers(Workers& workers, auto&& visit) {
    workers.for_chunks(movers_.size(), kBodyGrain, [&](std::size_t begin, std::size_t end, int) {
      for (std::size_t k = begin; k < end; ++k) visit(movers_[k], bodies_[movers_[k]]);
    });
  }

 private:
  /// Bodies per chunk of a worker.
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
  detail::SparseArray<std::uint8_t> loaded_;  ///< by slot: the body is loaded and kept up to date
  std::span<const std::uint32_t> movers_;
  std::vector<std::uint32_t> every_slot_;  ///< scratch of movers_ if it is every slot
  struct {
    BodyLog::Mark since;  ///< of the world
    int steps = 0;        ///< steps in a row without awake bodies or entries in the log
    double dt = 0.0;      ///< s, of each
  } rest_;
  BodyLog::Mark seen_;                 ///< mark for bodies that do not move
  std::vector<std::uint32_t> marked_;  ///< immovable bodies that carry marks of this step
  struct KeptInertia {
    Mat3 inverse;
    Quat q;  ///< orientation of the body for which it was computed
  };
  detail::SparseArray<KeptInertia> inertias_;  ///< by slot, of bodies with joints
  std::vector<std::uint32_t> kinematic_;
};

}  // namespace tandem::pbd
