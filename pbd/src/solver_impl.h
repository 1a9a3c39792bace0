// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <vector>

#include "body_buffer.h"
#include "constraint_edges.h"
#include "groups.h"
#include "islands.h"
#include "stage_clock.h"
#include "tandem/pbd/solver.h"
#include "tandem/pbd/sparse_array.h"
#include "tandem/pbd/workers.h"
#include "targets.h"

namespace tandem::pbd {

/// The step: what it does in which order is in solver.cpp, the stages are in solver_stages.cpp.
class __attribute__((visibility("hidden"))) Solver::Impl {
 public:
  explicit Impl(const SolverOptions& options) : options_(options), workers_(options.threads) {}
  const SolverOptions& options() const { return options_; }
  const StepReport& report() const { return report_; }

  const StepReport& step(World& world, double dt);
  /// For a step that is none.
  const StepReport& refuse();

 private:
  /// Bodies given to a worker at a time.
  static constexpr std::size_t kBodyGrain = 256;

  // Stages.
  void begin_step(World& world, double dt);
  void begin_group(std::uint32_t group);
  void begin_substep(int i);
  /// Velocities to the end of the substep; poses only of bodies whose rows project them.
  void integrate();
  void project();
  void advance_poses();
  /// Before the contact velocity pass, so that contacts can veto it.
  void agree_velocities();
  void solve_velocities();
  /// Displacements, not velocities: targets pull, joints follow, contacts hold.
  void agree();
  void end_step();

  // Parts of stages.
  void reset_report();
  void end_stage(Stage stage);
  void detect();
  void collect_targets();
  /// Islands, and from them the groups that are solved together.
  void arrange_groups();
  Groups::Rule group_rule() const;
  void list_parts();
  void project_joints();
  /// How often joints and contacts take turns in a substep. Where contacts hit what joints hold,
  /// one turn leaves most of the blow to the substeps to come: a doll that falls on its feet
  /// from 1.2 m opens its joints by 9 cm in single turns and gains 142 of 1512 J in a step, in 8 by
  /// 1 cm and 4 J (tests/scene/ragdoll_test.cpp).
  struct Turns {
    int least = 1, most = 1;
  };
  Turns joint_turns() const;
  /// Sweep blocks before contacts, there and back, until no row asks for more. A set of joints is
  /// solved as one and says when it holds; what rows that are swept in turns leave comes back in
  /// each substep, as an acceleration: two hands hold 1 kg 0.8 % too low where sweeps stop at the
  /// tolerance itself.
  /// @param project  of a block: the largest move that a row asked for, m
  void until_joints_hold(auto&& project) {
    if (!rows_.project) return;
    constexpr double kSwept = 0.02;  // of the tolerance
    const bool reverse = context_.reverse;
    for (int i = 0; i < options_.joint_iterations; ++i) {
      double largest = 0.0;
      for_blocks([&](ConstraintBlock& block) {
        if (!is_last(block)) largest = std::max(largest, project(block));
      });
      if (largest <= kSwept * options_.joint_tolerance) break;
      context_.reverse = !context_.reverse;
    }
    context_.reverse = reverse;
  }
  void note_new_overlaps();
  void note_gaps();
  void restore_locked_bodies(const Group& group);
  /// Nothing tunnels: bodies that would get through something stop on their way.
  void limit_motion();
  void for_blocks(auto&& visit) {
    for (const auto& block : world_->blocks_) {
      if (!block->empty()) visit(*block);
    }
  }

  /// Bodies of the current group, shared out among the workers.
  void for_group(auto&& visit) {
    const std::span<const std::uint32_t> list = group_->bodies;
    workers_.for_chunks(list.size(), kBodyGrain, [&](std::size_t begin, std::size_t end, int) {
      for (std::size_t k = begin; k < end; ++k) visit(bodies_[list[k]], list[k]);
    });
  }

  SolverOptions options_;
  Workers workers_;
  World* world_ = nullptr;  ///< during a step only
  double dt_ = 0.0;
  SubstepContext context_;
  StepReport report_;
  StageClock clock_;
  Targets targets_;
  Islands islands_;
  BodyBuffer bodies_;
  struct {
    bool any = false;      ///< there is one, and a body that is awake
    bool project = false;  ///< some project poses
  } rows_;
  Groups groups_;
  ConstraintEdges edges_;
  std::vector<std::uint32_t> changed_;  ///< bodies whose rows were changed
  detail::SparseArray<double> wanted_;  ///< by body: substeps that rows ask for
  const Group* group_ = nullptr;        ///< the one being solved
  std::vector<Manifold> manifolds_;
  struct {
    detail::SparseArray<Pose> after;  ///< by slot, of movers
    std::vector<MotionLimit> limits;
  } motion_;  ///< what stops bodies on their way
  std::vector<PoseTarget> pose_targets_;
};

}  // namespace tandem::pbd
