// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "group_passes.h"

#include <algorithm>

namespace tandem::pbd {

GroupPasses::GroupPasses(int workers)
    : passes_(static_cast<std::size_t>(workers)), clocks_(static_cast<std::size_t>(workers)) {}

void GroupPasses::begin_step(const PassStep& step, std::span<const Group> groups, Workers& workers,
                             StageClock& clock) {
  groups_ = groups;
  energies_.assign(groups.size(), {});
  tasks_.clear();
  in_turn_.clear();
  for (std::uint32_t g = 0; g < groups.size(); ++g) {
    (step.context.groups[g].at_once ? tasks_ : in_turn_).push_back(g);
  }
  const auto work = [&](std::uint32_t g) {
    return groups[g].bodies.size() * static_cast<std::size_t>(groups[g].substeps);
  };
  std::sort(tasks_.begin(), tasks_.end(), [&](std::uint32_t l, std::uint32_t r) {
    return work(l) != work(r) ? work(l) > work(r) : l < r;
  });
  shared_.begin_step(step, 0, workers, false, clock);
  if (tasks_.empty()) return;
  const std::size_t largest = groups[tasks_.front()].bodies.size();
  for (std::size_t w = 0; w < passes_.size(); ++w) {
    clocks_[w].start(step.options->measure_stages, nullptr);
    passes_[w].begin_step(step, static_cast<int>(w), nobody_, true, clocks_[w]);
    passes_[w].reserve(largest);
  }
}

void GroupPasses::end_step(StepReport& report) const {
  const auto note = [&](const GroupPass::Outcome& outcome) {
    report.substeps = std::max(report.substeps, outcome.substeps);
    report.velocity_iterations += outcome.velocity_iterations;
    for (std::size_t i = 0; i < kStageCount; ++i) report.ran[i] = report.ran[i] || outcome.ran[i];
  };
  if (!in_turn_.empty()) note(shared_.outcome());
  for (std::size_t w = 0; !tasks_.empty() && w < passes_.size(); ++w) note(passes_[w].outcome());
  for (const ConsensusEnergy& energy : energies_) {
    report.energy.velocity_agreement += energy.velocity_agreement;
    report.energy.potential += energy.potential;
    report.energy.displacement += energy.displacement;
  }
}

}  // namespace tandem::pbd
