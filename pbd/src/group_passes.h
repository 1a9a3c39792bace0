// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "group_pass.h"
#include "tandem/pbd/report.h"
#include "tandem/pbd/workers.h"

namespace tandem::pbd {

/// Solves the groups of a step: small ones at once, one per worker, then the others one after the
/// other, each by all workers.
class GroupPasses {
 public:
  /// @param workers  number of workers
  explicit GroupPasses(int workers);

  /// @pre groups have their facts in the step's context
  void begin_step(const PassStep& step, std::span<const Group> groups, Workers& workers,
                  StageClock& clock);
  /// Calls solve(pass) for each group, after the pass has begun it.
  void run(Workers& workers, StageClock& clock, auto&& solve) {
    workers.for_tasks(static_cast<std::uint32_t>(tasks_.size()), [&](std::uint32_t k, int worker) {
      solve(at(passes_[static_cast<std::size_t>(worker)], tasks_[k]));
    });
    if (!tasks_.empty()) clock.share_out(clocks_);
    for (const std::uint32_t group : in_turn_) solve(at(shared_, group));
  }
  void end_step(StepReport& report) const;

 private:
  GroupPass& at(GroupPass& pass, std::uint32_t group) {
    pass.begin(groups_[group], group, energies_[group]);
    return pass;
  }

  std::span<const Group> groups_;
  std::vector<std::uint32_t> tasks_;       ///< groups that are solved at once, largest first
  std::vector<std::uint32_t> in_turn_;     ///< groups solved one after the other
  std::vector<ConsensusEnergy> energies_;  ///< by group
  Workers nobody_;                         ///< a team of one, for the stages of a task
  GroupPass shared_;                       ///< for groups solved one after the other
  std::vector<GroupPass> passes_;          ///< by worker, for tasks
  std::vector<StageClock> clocks_;         ///< by worker, for tasks
};

}  // namespace tandem::pbd
