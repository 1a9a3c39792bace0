// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <span>

#include "body_buffer.h"
#include "constraint_edges.h"
#include "groups.h"
#include "stage_clock.h"
#include "tandem/pbd/solver.h"
#include "targets.h"

namespace tandem::pbd {

/// Data common to all groups of a step.
struct PassStep {
  const SolverOptions* options = nullptr;
  BodyBuffer* bodies = nullptr;
  Targets* targets = nullptr;
  std::span<const std::unique_ptr<ConstraintBlock>> blocks = {};
  // Views of the world, by slot:
  const PropsTable* props = nullptr;
  std::span<const BodyState> states = {};  ///< at the start of the step
  std::span<const Wrench> wrenches = {};   ///< empty if none acts
  std::span<Correction> corrections = {};  ///< empty if there are no targets
  double dt = 0.0;                         ///< s
  bool any_rows = false;                   ///< some row exists, and some body is awake
  bool any_joints = false;                 ///< some rows project poses
  SubstepContext context;
};

/// Takes one group after another through all substeps of a step.
class GroupPass {
 public:
  struct Outcome {
    std::array<bool, kStageCount> ran{};
    int velocity_iterations = 0;
    int substeps = 0;  ///< largest number
  };

  /// @param worker   index of the pass's worker     @param workers  share its stages
  /// @param at_once  whether other groups are solved at the same time
  void begin_step(const PassStep& step, int worker, Workers& workers, bool at_once,
                  StageClock& clock);
  /// Reserves for groups of so many bodies; which groups come is not known in advance.
  void reserve(std::size_t bodies) {
    if (step_.context.shared) targets_.reserve(bodies);
  }
  /// @param energy  what agreement did to the group's energy is added here
  void begin(const Group& group, std::uint32_t number, ConsensusEnergy& energy);
  int substeps() const { return context_.substeps; }
  void begin_substep(int i);
  /// Integrates velocities to the end of the substep, and poses of bodies whose rows project them.
  void integrate();
  void project();
  void advance_poses();
  /// Before the contact velocity pass, so that contacts can veto it.
  void agree_velocities();
  void solve_velocities();
  /// Displacements without velocity: targets pull, joints follow, contacts hold.
  void agree();

  /// Over all groups since begin_step().
  const Outcome& outcome() const { return outcome_; }

 private:
  /// Bodies per chunk of a worker.
  static constexpr std::size_t kBodyGrain = 256;

  void end_stage(Stage stage);
  void project_joints();
  /// Range of alternations of joints and contacts in a substep. If contacts hit jointed bodies, one
  /// alternation leaves most of the impact to later substeps: a doll that falls on its feet from
  /// 1.2 m opens its joints by 9 cm with one and gains 142 of 1512 J in a step, with 8 by 1 cm and
  /// 4 J (tests/scene/ragdoll_test.cpp).
  struct Turns {
    int least = 1, most = 1;
  };
  Turns joint_turns() const;
  /// Sweeps blocks before contacts, back and forth, until no row asks for more. A set of joints is
  /// solved as one and reports when it converges. What rows swept one after the other leave acts as
  /// an acceleration in each substep: two hands hold 1 kg 0.8 % too low if sweeps stop at the
  /// tolerance itself.
  /// @param project  of a block: the largest move that a row asked for, m
  void until_joints_hold(auto&& project) {
    if (!step_.any_joints) return;
    constexpr double kSwept = 0.02;  // of the tolerance
    const bool reverse = context_.reverse;
    for (int i = 0; i < step_.options->joint_iterations; ++i) {
      double largest = 0.0;
      for_blocks([&](ConstraintBlock& block) {
        if (!is_last(block)) largest = std::max(largest, project(block));
      });
      if (largest <= kSwept * step_.options->joint_tolerance) break;
      context_.reverse = !context_.reverse;
    }
    context_.reverse = reverse;
  }
  void restore_locked_bodies();
  void for_blocks(auto&& visit) {
    for (const auto& block : step_.blocks) {
      if (!block->empty() && (!at_once_ || block->groups_at_once())) visit(*block);
    }
  }
  /// Visits the bodies of the group, divided among the workers.
  void for_bodies(auto&& visit) {
    const std::span<const std::uint32_t> list = group_->bodies;
    const std::span<SolverBody> bodies = context_.bodies;
    context_.workers->for_chunks(list.size(), kBodyGrain,
                                 [&](std::size_t begin, std::size_t end, int) {
                                   for (std::size_t k = begin; k < end; ++k)
                                     visit(bodies[list[k]], list[k]);
                                 });
  }

  PassStep step_;
  SubstepContext context_;
  const Group* group_ = nullptr;
  GroupTargets targets_;
  ConsensusEnergy* energy_ = nullptr;
  StageClock* clock_ = nullptr;
  bool at_once_ = false;
  Outcome outcome_;
};

}  // namespace tandem::pbd
