// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <vector>

#include "body_buffer.h"
#include "constraint_edges.h"
#include "group_passes.h"
#include "groups.h"
#include "islands.h"
#include "stage_clock.h"
#include "tandem/pbd/solver.h"
#include "tandem/pbd/sparse_array.h"
#include "tandem/pbd/workers.h"
#include "targets.h"

namespace tandem::pbd {

/// The step. Its order is in solver.cpp, the stages of a substep are in group_pass.cpp, the others
/// in solver_stages.cpp.
class __attribute__((visibility("hidden"))) Solver::Impl {
 public:
  explicit Impl(const SolverOptions& options)
      : options_(options), workers_(options.threads), passes_(options.threads) {}
  const SolverOptions& options() const { return options_; }
  const StepReport& report() const { return report_; }

  const StepReport& step(World& world, double dt);
  /// Reports an invalid step.
  const StepReport& refuse();

 private:
  // Stages.
  void begin_step(World& world, double dt);
  void begin_groups();
  void end_groups();
  void end_step();

  // Parts of stages.
  void reset_report();
  void end_stage(Stage stage);
  void detect();
  void collect_targets();
  /// Finds islands, and from them the groups that are solved together.
  void arrange_groups();
  Groups::Rule group_rule() const;
  void list_parts();
  void note_new_overlaps();
  void note_gaps();
  /// CCD: stops bodies that would tunnel.
  void limit_motion();
  void for_blocks(auto&& visit) {
    for (const auto& block : world_->blocks_) {
      if (!block->empty()) visit(*block);
    }
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
    bool any = false;      ///< some row exists, and some body is awake
    bool project = false;  ///< some row projects poses
  } rows_;
  Groups groups_;
  ConstraintEdges edges_;
  std::vector<std::uint32_t> changed_;  ///< bodies whose rows were changed
  detail::SparseArray<double> wanted_;  ///< by body: substeps that rows want
  std::vector<GroupFacts> group_facts_;
  GroupPasses passes_;
  std::vector<Manifold> manifolds_;
  struct {
    detail::SparseArray<Pose> after;  ///< by slot, of movers
    std::vector<MotionLimit> limits;
  } motion_;  ///< scratch of limit_motion()
  std::vector<PoseTarget> pose_targets_;
};

}  // namespace tandem::pbd
