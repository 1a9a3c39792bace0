// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// The stages of a substep in order, followed by their parts.
#include "group_pass.h"

#include <cmath>

#include "integrate.h"

namespace tandem::pbd {
namespace {

/// Whether contacts have changed the speed of a jointed body by much.
bool joints_are_hit(std::span<const std::uint32_t> group, std::span<const SolverBody> bodies) {
  constexpr double kBlow = 0.3;  // m/s
  return std::any_of(group.begin(), group.end(), [&](std::uint32_t i) {
    const SolverBody& body = bodies[i];
    return body.projected && (body.v - body.v_applied).squaredNorm() > kBlow * kBlow;
  });
}

}  // namespace

void GroupPass::begin_step(const PassStep& step, int worker, Workers& workers, bool at_once,
                           StageClock& clock) {
  step_ = step;
  context_ = step.context;
  context_.worker = worker;
  context_.workers = &workers;
  at_once_ = at_once;
  clock_ = &clock;
  outcome_ = {};
}

void GroupPass::begin(const Group& group, std::uint32_t number, ConsensusEnergy& energy) {
  group_ = &group;
  energy_ = &energy;
  context_.group = number;
  context_.members = group.bodies;
  context_.share_of_budget = group.share;
  context_.substeps = group.substeps;
  context_.h = step_.dt / group.substeps;
  if (group.driven) step_.bodies->rewind_kinematic(step_.states);
  if (context_.shared) targets_.select(*step_.targets, group, context_.bodies);
  outcome_.substeps = std::max(outcome_.substeps, group.substeps);
}

void GroupPass::begin_substep(int i) {
  context_.substep = i;
  context_.last = i + 1 == context_.substeps;
  context_.reverse = (i % 2) == 1;
  if (step_.any_joints) {
    for_bodies([&](SolverBody&, std::uint32_t slot) {
      step_.bodies->renew_inertia(slot, (*step_.props)[slot]);
    });
  }
  for_blocks([&](ConstraintBlock& block) { block.begin_substep(context_); });
  clock_->stop(Stage::Begin);
}

void GroupPass::integrate() {
  const double h = context_.h;
  for_bodies([&](SolverBody& body, std::uint32_t i) {
    const Wrench* wrench = step_.wrenches.empty() ? nullptr : &step_.wrenches[i];
    integrate_velocity(body, (*step_.props)[i], wrench, context_.gravity, h);
  });
  if (group_->driven) step_.bodies->move_kinematic(h);
  end_stage(Stage::Integrate);
}

void GroupPass::project() {
  if (!step_.any_rows) return;
  for_blocks([&](ConstraintBlock& block) { block.warm_start(context_); });
  const Turns turns = joint_turns();
  for (int i = 0; i < turns.most; ++i) {
    context_.iteration = i;
    if (step_.any_joints) project_joints();
    if (turns.most > 1)
      for_blocks([&](ConstraintBlock& block) { block.finish_projection(context_); });
    for_blocks([&](ConstraintBlock& block) {
      if (is_last(block)) block.project(context_);
    });
    if (i + 1 < turns.most && i + 1 >= turns.least &&
        !joints_are_hit(group_->bodies, context_.bodies))
      break;
  }
  end_stage(Stage::Project);
}

void GroupPass::advance_poses() {
  const double h = context_.h;
  const bool locked = group_->locked;
  for_bodies([&](SolverBody& body, std::uint32_t i) {
    const BodyProps& props = (*step_.props)[i];
    if (locked) enforce_locks(body, props.locks);
    advance_pose(body, props, h);
    if (step_.any_joints && body.reoriented) step_.bodies->keep_inertia(i);
    if (locked) restore_locked(body, props.locks, step_.states[i].pose.position);
  });
  clock_->stop(Stage::Integrate);
}

void GroupPass::agree_velocities() {
  if (step_.targets->empty()) return;
  targets_.agree_velocities(context_.bodies, *step_.props, step_.corrections, context_.h, *energy_);
}

void GroupPass::solve_velocities() {
  if (!step_.any_rows && step_.targets->empty()) return;
  const bool reverse = context_.reverse;
  for (int i = 0; i < step_.options->velocity_iterations; ++i) {
    double change = 0.0;
    context_.reverse = (context_.substep + i) % 2 == 0;
    for_blocks(
        [&](ConstraintBlock& block) { change = std::max(change, block.solve_velocity(context_)); });
    ++outcome_.velocity_iterations;
    if (change <= step_.options->velocity_tolerance) break;
  }
  context_.reverse = reverse;
  for_blocks([&](ConstraintBlock& block) { block.finish_velocity(context_); });
  if (group_->locked) {
    for_bodies(
        [&](SolverBody& body, std::uint32_t i) { enforce_locks(body, (*step_.props)[i].locks); });
  }
  end_stage(Stage::Velocity);
}

void GroupPass::agree() {
  if (!context_.shared || !targets_.any()) return;
  const std::span<SolverBody> bodies = context_.bodies;
  targets_.begin(bodies);
  for_blocks([&](ConstraintBlock& block) { block.begin_displacement(context_); });
  targets_.pull(bodies, *step_.props, context_.h * (context_.substep + 1));
  until_joints_hold([&](ConstraintBlock& block) { return block.project_displacement(context_); });
  targets_.to_velocities(bodies, context_.h);
  for_blocks([&](ConstraintBlock& block) {
    if (is_last(block)) block.project_displacement(context_);
  });
  targets_.to_poses(bodies, context_.h);
  restore_locked_bodies();
  for_blocks([&](ConstraintBlock& block) { block.end_displacement(context_); });
  targets_.end(bodies, *step_.props, step_.corrections, context_.gravity, *energy_);
  end_stage(Stage::Agree);
}

// --- parts of stages ----------------------------------------------------------------------------

void GroupPass::end_stage(Stage stage) {
  clock_->stop(stage);
  outcome_.ran[static_cast<std::size_t>(stage)] = true;
}

void GroupPass::project_joints() {
  const double h = context_.h;
  for_bodies([&](SolverBody& body, std::uint32_t i) {
    if (!body.projected) return;
    follow_velocity(body, h);
    refresh_inertia(body, (*step_.props)[i]);
  });
  until_joints_hold([&](ConstraintBlock& block) { return block.project(context_); });
  for_bodies([&](SolverBody& body, std::uint32_t i) {
    if (!body.projected) return;
    absorb_corrections(body, (*step_.props)[i], h);
    if (body.pushed) step_.bodies->restore_inertia(i);
  });
}

GroupPass::Turns GroupPass::joint_turns() const {
  constexpr int kMaxTurns = 8;
  constexpr double kPart = 6.0;  // see ContactOptions::extra_rows
  const SolverOptions& options = *step_.options;
  const int asked = options.position_iterations;
  if (!group_->joined || !options.refine) return {asked, asked};
  const double budget = group_->share * options.contact.extra_rows / (kPart * context_.substeps);
  const double bodies = static_cast<double>(group_->bodies.size());
  const int most = std::min(kMaxTurns, 1 + static_cast<int>(budget / bodies));
  return {asked, std::max(asked, most)};
}

void GroupPass::restore_locked_bodies() {
  if (!group_->locked) return;
  for (const std::uint32_t i : group_->bodies) {
    restore_locked(context_.bodies[i], (*step_.props)[i].locks, step_.states[i].pose.position);
  }
}

}  // namespace tandem::pbd
