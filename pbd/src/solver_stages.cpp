// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// The stages of a step, in their order, and below them the parts that they are made of.
#include <algorithm>
#include <cmath>

#include "contact_row.h"
#include "contact_rows.h"
#include "integrate.h"
#include "solver_impl.h"
#include "tandem/pbd/contact.h"
#include "tandem/pbd/math.h"

namespace tandem::pbd {
namespace {

/// Whether contacts have changed the speed of something on joints by much.
bool joints_are_hit(std::span<const std::uint32_t> group, std::span<const SolverBody> bodies) {
  constexpr double kBlow = 0.3;  // m/s
  return std::any_of(group.begin(), group.end(), [&](std::uint32_t i) {
    const SolverBody& body = bodies[i];
    return body.projected && (body.v - body.v_applied).squaredNorm() > kBlow * kBlow;
  });
}

// Not-a-number never enters a world, whoever made the target or the manifold.

bool usable(const PoseTarget& target, const World& world) {
  return world.contains(target.body) && target.pose.position.allFinite() &&
         std::abs(target.pose.orientation.norm() - 1.0) < 1e-3 && target.twist.linear.allFinite() &&
         target.twist.angular.allFinite() && target.rotation_error.allFinite() &&
         std::isfinite(target.share);
}

bool usable(const Manifold& m, const World& world) {
  const auto lives = [&](std::uint32_t body) { return world.body_at(body).valid(); };
  const bool sound = m.count > 0 && m.count <= Manifold::kMaxPoints && m.body_a != m.body_b &&
                     lives(m.body_a) && lives(m.body_b);
  if (!sound) return false;
  double sum = m.normal.sum() + m.radius_a + m.radius_b + m.friction + m.restitution;
  for (int i = 0; i < m.count; ++i)
    sum += m.points[i].anchor_a_l.sum() + m.points[i].anchor_b_l.sum();
  return std::isfinite(sum) && std::abs(m.normal.squaredNorm() - 1.0) < 1e-3 && m.friction >= 0.0;
}

}  // namespace

void Solver::Impl::begin_step(World& world, double dt) {
  world_ = &world;
  dt_ = dt;
  clock_.start(options_.measure_stages, options_.observer);
  reset_report();
  BodyBuffer::aim_kinematic(world, dt);
  detect();
  if (world.contact_source_ != nullptr) end_stage(Stage::Detect);
  bodies_.load(world, workers_);
  collect_targets();
  arrange_groups();
  report_.turning = bodies_.prepare(world, edges_.without_contacts(), groups_.all(), workers_);
  if (rows_.project) bodies_.keep_inertias();
  list_parts();
  context_ = {.bodies = bodies_.all(),
              .movers = bodies_.movers(),
              .h = dt / options_.substeps,
              .substeps = options_.substeps,
              .joint_tolerance = options_.joint_tolerance,
              .gravity = world.gravity_,
              .workers = &workers_,
              .order = world.order(),
              .shared = !targets_.empty(),
              .displaced = world.displaced_};
  for_blocks([&](ConstraintBlock& block) { block.begin_step(context_); });
  note_gaps();
  context_.displaced = {};
  world.displaced_.clear();
  end_stage(Stage::Begin);
}

void Solver::Impl::begin_group(std::uint32_t group) {
  group_ = &groups_.all()[group];
  context_.group = group;
  context_.members = group_->bodies;
  context_.share_of_budget = group_->share;
  context_.substeps = group_->substeps;
  context_.h = dt_ / group_->substeps;
  if (group > 0) bodies_.rewind_kinematic(*world_);
  if (context_.shared) targets_.select_group(*group_, bodies_.all());
  report_.substeps = std::max(report_.substeps, group_->substeps);
}

void Solver::Impl::begin_substep(int i) {
  context_.substep = i;
  context_.last = i + 1 == context_.substeps;
  context_.reverse = (i % 2) == 1;
  if (rows_.project) {
    for_group([&](SolverBody&, std::uint32_t slot) {
      bodies_.renew_inertia(slot, world_->props_[slot]);
    });
  }
  for_blocks([&](ConstraintBlock& block) { block.begin_substep(context_); });
  clock_.stop(Stage::Begin);
}

void Solver::Impl::integrate() {
  const double h = context_.h;
  for_group([&](SolverBody& body, std::uint32_t i) {
    const Wrench* wrench = world_->wrenches_.empty() ? nullptr : &world_->wrenches_[i];
    integrate_velocity(body, world_->props_[i], wrench, context_.gravity, h);
  });
  bodies_.move_kinematic(h);
  end_stage(Stage::Integrate);
}

void Solver::Impl::project() {
  if (!rows_.any) return;
  for_blocks([&](ConstraintBlock& block) { block.warm_start(context_); });
  const Turns turns = joint_turns();
  for (int i = 0; i < turns.most; ++i) {
    context_.iteration = i;
    if (rows_.project) project_joints();
    if (turns.most > 1)
      for_blocks([&](ConstraintBlock& block) { block.finish_projection(context_); });
    for_blocks([&](ConstraintBlock& block) {
      if (is_last(block)) block.project(context_);
    });
    if (i + 1 < turns.most && i + 1 >= turns.least &&
        !joints_are_hit(group_->bodies, bodies_.all()))
      break;
  }
  end_stage(Stage::Project);
}

void Solver::Impl::advance_poses() {
  const double h = context_.h;
  const bool locked = group_->locked;
  for_group([&](SolverBody& body, std::uint32_t i) {
    const BodyProps& props = world_->props_[i];
    if (locked) enforce_locks(body, props.locks);
    advance_pose(body, props, h);
    if (rows_.project && body.reoriented) bodies_.keep_inertia(i);
    if (locked) restore_locked(body, props.locks, world_->states_[i].pose.position);
  });
  clock_.stop(Stage::Integrate);
}

void Solver::Impl::agree_velocities() {
  if (targets_.empty()) return;
  targets_.agree_velocities(bodies_.all(), world_->props_, world_->corrections_, context_.h,
                            report_.energy);
}

void Solver::Impl::solve_velocities() {
  if (!rows_.any && targets_.empty()) return;
  const bool reverse = context_.reverse;
  for (int i = 0; i < options_.velocity_iterations; ++i) {
    double change = 0.0;
    context_.reverse = (context_.substep + i) % 2 == 0;
    for_blocks(
        [&](ConstraintBlock& block) { change = std::max(change, block.solve_velocity(context_)); });
    ++report_.velocity_iterations;
    if (change <= options_.velocity_tolerance) break;
  }
  context_.reverse = reverse;
  for_blocks([&](ConstraintBlock& block) { block.finish_velocity(context_); });
  if (group_->locked) {
    for_group(
        [&](SolverBody& body, std::uint32_t i) { enforce_locks(body, world_->props_[i].locks); });
  }
  end_stage(Stage::Velocity);
}

void Solver::Impl::agree() {
  if (!context_.shared || !targets_.selected()) return;
  targets_.begin(bodies_.all());
  for_blocks([&](ConstraintBlock& block) { block.begin_displacement(context_); });
  targets_.pull(bodies_.all(), world_->props_, context_.h * (context_.substep + 1));
  until_joints_hold([&](ConstraintBlock& block) { return block.project_displacement(context_); });
  targets_.to_velocities(bodies_.all(), context_.h);
  for_blocks([&](ConstraintBlock& block) {
    if (is_last(block)) block.project_displacement(context_);
  });
  targets_.to_poses(bodies_.all(), context_.h);
  restore_locked_bodies(*group_);
  for_blocks([&](ConstraintBlock& block) { block.end_displacement(context_); });
  targets_.end(bodies_.all(), world_->props_, world_->corrections_, context_.gravity,
               report_.energy);
  end_stage(Stage::Agree);
}

void Solver::Impl::end_step() {
  SubstepContext context = context_;
  context.h = dt_;
  context.substeps = options_.substeps;
  wanted_.resize(bodies_.size());
  for (const std::uint32_t i : bodies_.movers()) wanted_[i] = 0.0;
  const std::span<double> wanted = report_.parts.refinement ? wanted_ : std::span<double>{};
  for_blocks([&](ConstraintBlock& block) { block.end_step(context, wanted); });
  // What rows did in this step decides who rests; a world that sleeps does not ask.
  if (options_.sleep_after > 0.0 && !groups_.all().empty()) edges_.list(*world_);
  groups_.settle(group_rule(), dt_, islands_, edges_.all(), wanted_, world_->states_,
                 world_->props_, world_->activity_, bodies_.all());
  limit_motion();
  bodies_.store(*world_, dt_, groups_.all(), report_);
  world_->wrenches_.clear();
  const bool still = groups_.all().empty() && !bodies_.any_moving();
  bodies_.note_rest(*world_, dt_, still,
                    options_.sleep_after > 0.0 && report_.status == StepStatus::Ok);
  world_->body_log_.end_step();
  world_->time_ += dt_;
  for (const auto& block : world_->blocks_) {
    if (!block->empty()) report_.blocks.push_back(block->report());
  }
  end_stage(Stage::End);
  report_.stage_s = clock_.seconds();
}

// --- parts of stages ----------------------------------------------------------------------------

void Solver::Impl::project_joints() {
  const double h = context_.h;
  for_group([&](SolverBody& body, std::uint32_t i) {
    if (!body.projected) return;
    follow_velocity(body, h);
    refresh_inertia(body, world_->props_[i]);
  });
  until_joints_hold([&](ConstraintBlock& block) { return block.project(context_); });
  for_group([&](SolverBody& body, std::uint32_t i) {
    if (!body.projected) return;
    absorb_corrections(body, world_->props_[i], h);
    if (body.pushed) bodies_.restore_inertia(i);
  });
}

Solver::Impl::Turns Solver::Impl::joint_turns() const {
  constexpr int kMaxTurns = 8;
  constexpr double kPart = 6.0;  // see ContactOptions::extra_rows
  const int asked = options_.position_iterations;
  if (!group_->joined || !options_.refine) return {asked, asked};
  const double budget = group_->share * options_.contact.extra_rows / (kPart * context_.substeps);
  const double bodies = static_cast<double>(group_->bodies.size());
  const int most = std::min(kMaxTurns, 1 + static_cast<int>(budget / bodies));
  return {asked, std::max(asked, most)};
}

void Solver::Impl::restore_locked_bodies(const Group& group) {
  if (!group.locked) return;
  for (const std::uint32_t i : group.bodies) {
    restore_locked(bodies_[i], world_->props_[i].locks, world_->states_[i].pose.position);
  }
}

void Solver::Impl::reset_report() {
  report_.status = StepStatus::Ok;
  report_.first_bad_body = {};
  report_.substeps = 0;
  report_.bodies = static_cast<int>(world_->body_count());
  report_.velocity_iterations = 0;
  report_.groups = 0;
  report_.stopped = 0;
  report_.awake = 0;
  report_.turning = 0;
  report_.threads = options_.threads;
  report_.ran = {};
  report_.parts = {};
  report_.blocks.clear();
  report_.energy = {};
}

void Solver::Impl::end_stage(Stage stage) {
  clock_.stop(stage);
  report_.ran[static_cast<std::size_t>(stage)] = true;
}

void Solver::Impl::list_parts() {
  const bool awake = !groups_.all().empty();
  const ContactBlock* contacts = world_->contacts_;
  const bool touching = awake && contacts != nullptr && !contacts->empty();
  report_.parts = {.contacts = touching,
                   .friction = touching && contacts->any_friction(),
                   .restitution = touching && contacts->any_restitution(),
                   .joints = rows_.project,
                   .rotation = report_.turning > 0,
                   .sleep = awake && options_.sleep_after > 0.0,
                   .refinement = rows_.any && options_.refine,
                   .targets = !targets_.empty()};
}

void Solver::Impl::detect() {
  if (world_->contacts_ == nullptr) return;
  manifolds_.clear();  // without a source, what it said last is over
  if (world_->contact_source_ != nullptr) {
    world_->contact_source_->collect(*world_, dt_, workers_, manifolds_);
    std::erase_if(manifolds_, [&](const Manifold& m) { return !usable(m, *world_); });
  }
  world_->contacts_->configure(options_.contact);
  world_->contacts_->set_manifolds(manifolds_);
}

void Solver::Impl::collect_targets() {
  pose_targets_.clear();
  if (world_->target_source_ != nullptr) {
    world_->target_source_->collect(*world_, dt_, options_, pose_targets_);
    std::erase_if(pose_targets_, [&](const PoseTarget& t) { return !usable(t, *world_); });
    world_->corrections_.assign(bodies_.size(), {});
  } else {
    world_->corrections_.clear();
  }
  bodies_.load_named(*world_, pose_targets_);
  targets_.begin_step(pose_targets_, bodies_.all(), world_->states_, dt_);
  report_.targets = targets_.size();
}

/// What joints hold together and has a gap is displaced as an island with a target is. Contacts
/// have no say in it: what a blow has left on the wrong side of something could never come back.
void Solver::Impl::note_gaps() {
  bool gaps = false;
  for_blocks([&](const ConstraintBlock& block) { gaps = gaps || block.has_gaps(); });
  if (!gaps) return;
  targets_.mark_gaps(edges_.without_contacts(), bodies_.movers(), bodies_.all());
  context_.shared = true;
}

void Solver::Impl::arrange_groups() {
  edges_.list(*world_);
  bodies_.load_named(*world_, edges_);
  islands_.build(edges_.all(), bodies_.movers(), bodies_.all());
  bodies_.mark_joined(edges_);
  changed_.clear();
  for (const auto& block : world_->blocks_) block->take_changed(changed_);
  note_new_overlaps();
  groups_.arrange(group_rule(), islands_, bodies_.movers(), changed_, edges_.all(), pose_targets_,
                  world_->props_, world_->activity_, bodies_.all());
  if (!targets_.empty()) targets_.mark_islands(islands_.of(), bodies_.movers(), bodies_.all());
  report_.groups = static_cast<int>(groups_.all().size());
  report_.awake = 0;
  for (const Group& group : groups_.all()) report_.awake += static_cast<int>(group.bodies.size());
  rows_.project = false;
  rows_.any = false;
  if (groups_.all().empty()) return;
  for_blocks([&](ConstraintBlock& block) {
    rows_.any = true;
    rows_.project = rows_.project || !is_last(block);
  });
}

/// A collider or a filter may have changed between bodies that sleep.
void Solver::Impl::note_new_overlaps() {
  if (world_->contacts_ == nullptr) return;
  for (const Contact& contact : world_->contacts_->contacts()) {
    const Manifold& m = contact.manifold;
    if (contact.overlap >= 0.0) continue;  // it is not new
    for (int i = 0; i < m.count; ++i) {
      if (gap_of(m, bodies_[m.body_a], bodies_[m.body_b], i) >= 0.0) continue;
      changed_.push_back(m.body_a);
      changed_.push_back(m.body_b);
      break;
    }
  }
}

Groups::Rule Solver::Impl::group_rule() const {
  return {.substeps = options_.substeps,
          .sleep_after = options_.sleep_after,
          .sleep_speed = options_.sleep_speed,
          .sleep_spin = options_.sleep_spin,
          .coupling = world_->island_coupling_};
}

void Solver::Impl::limit_motion() {
  if (world_->contact_source_ == nullptr || groups_.all().empty()) return;
  motion_.after.resize(bodies_.size());
  for (const std::uint32_t i : bodies_.movers()) motion_.after[i] = {bodies_[i].x, bodies_[i].q};
  world_->contact_source_->limit_motion(*world_, motion_.after, workers_, motion_.limits);
  for (const MotionLimit& limit : motion_.limits) {
    if (limit.body >= bodies_.size()) continue;
    SolverBody& body = bodies_[limit.body];
    const Vec3& start = world_->states_[limit.body].pose.position;
    body.x = limit.pose.position;
    // Its spin goes along: left where it was, it would be another energy.
    body.w = rotate(limit.pose.orientation * body.q.conjugate(), body.w);
    body.q = limit.pose.orientation;
    restore_locked(body, world_->props_[limit.body].locks, start);
    // The rest of the step is not: what it falls there would else be speed without a way.
    body.v -=
        (1.0 - limit.share) * dt_ * world_->props_[limit.body].gravity_scale * world_->gravity_;
    body.v -= std::min(0.0, (body.v - limit.obstacle_moves / dt_).dot(limit.normal)) * limit.normal;
    enforce_locks(body, world_->props_[limit.body].locks);
  }
  report_.stopped = static_cast<int>(motion_.limits.size());
}

}  // namespace tandem::pbd
