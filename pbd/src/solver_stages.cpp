// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// The stages of a step in order, followed by their parts.
#include <algorithm>
#include <cmath>

#include "contact_row.h"
#include "integrate.h"
#include "solver_impl.h"
#include "tandem/pbd/contact.h"
#include "tandem/pbd/math.h"

namespace tandem::pbd {
namespace {

/// Manifolds per chunk of a worker.
constexpr std::size_t kManifoldGrain = 256;

// NaN from a target or manifold never enters a world.

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
              .groups = group_facts_,
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

void Solver::Impl::begin_groups() {
  const PassStep step{.options = &options_,
                      .bodies = &bodies_,
                      .targets = &targets_,
                      .blocks = world_->blocks_,
                      .props = &world_->props_,
                      .states = world_->states_,
                      .wrenches = world_->wrenches_,
                      .corrections = world_->corrections_,
                      .dt = dt_,
                      .any_rows = rows_.any,
                      .any_joints = rows_.project,
                      .context = context_};
  passes_.begin_step(step, groups_.all(), workers_, clock_);
}

void Solver::Impl::end_groups() {
  passes_.end_step(report_);
  if (groups_.all().empty() || !bodies_.any_moving()) return;
  // Whatever groups have seen of them, they are now at the end of the step.
  bodies_.rewind_kinematic(world_->states_);
  const int substeps = groups_.all().back().substeps;
  for (int i = 0; i < substeps; ++i) bodies_.move_kinematic(dt_ / substeps);
}

void Solver::Impl::end_step() {
  SubstepContext context = context_;
  context.h = dt_;
  context.substeps = options_.substeps;
  wanted_.resize(bodies_.size());
  for (const std::uint32_t i : bodies_.movers()) wanted_[i] = 0.0;
  const std::span<double> wanted = report_.parts.refinement ? wanted_ : std::span<double>{};
  for_blocks([&](ConstraintBlock& block) { block.end_step(context, wanted); });
  // The edges of this step decide which bodies rest; a sleeping world does not need them.
  if (options_.sleep_after > 0.0 && !groups_.all().empty()) edges_.list(*world_);
  groups_.settle(group_rule(), dt_, workers_, islands_, edges_.all(), wanted_, world_->states_,
                 world_->props_, world_->activity_, bodies_.all());
  limit_motion();
  bodies_.store(*world_, dt_, groups_.all(), workers_, report_);
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
  manifolds_.clear();  // without a source, its last manifolds are void
  if (world_->contact_source_ != nullptr) {
    world_->contact_source_->collect(*world_, dt_, workers_, manifolds_);
    const auto any_unusable = [&](std::size_t begin, std::size_t end) {
      return !std::all_of(manifolds_.begin() + static_cast<std::ptrdiff_t>(begin),
                          manifolds_.begin() + static_cast<std::ptrdiff_t>(end),
                          [&](const Manifold& m) { return usable(m, *world_); });
    };
    if (workers_.any_chunk(manifolds_.size(), kManifoldGrain, any_unusable)) {
      std::erase_if(manifolds_, [&](const Manifold& m) { return !usable(m, *world_); });
    }
  }
  world_->contacts_->configure(options_.contact);
  world_->contacts_->set_manifolds(manifolds_, workers_);
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

/// A set of joints with a gap is displaced like an island with a target. Contacts do not act on it:
/// a limb that an impact has left on the wrong side of something could never return.
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
  groups_.note_apart(edges_, bodies_.any_moving(), bodies_.all());
  report_.awake = 0;
  for (const Group& group : groups_.all()) report_.awake += static_cast<int>(group.bodies.size());
  // An observer is told of stages one after the other; islands shared with other worlds need a
  // common order.
  const bool at_once = workers_.count() > 1 && options_.observer == nullptr &&
                       world_->island_coupling_ == nullptr && edges_.names_all();
  // A group is a task of one worker if enough others remain for the rest.
  const auto most = static_cast<std::size_t>(report_.awake / workers_.count());
  group_facts_.clear();
  for (const Group& group : groups_.all()) {
    group_facts_.push_back(
        {.substeps = group.substeps,
         .one_island = group.islands == 1,
         .at_once = at_once && !group.driven && !group.alone && group.bodies.size() <= most});
  }
  if (!targets_.empty()) targets_.mark_islands(islands_.of(), bodies_.movers(), bodies_.all());
  report_.groups = static_cast<int>(groups_.all().size());
  rows_.project = false;
  rows_.any = false;
  if (groups_.all().empty()) return;
  for_blocks([&](ConstraintBlock& block) {
    rows_.any = true;
    rows_.project = rows_.project || !is_last(block);
  });
}

/// A collider or filter of sleeping bodies may have changed.
void Solver::Impl::note_new_overlaps() {
  if (world_->contacts_ == nullptr) return;
  const std::span<const ContactBrief> briefs = world_->contacts_->briefs();
  for (std::size_t k = 0; k < briefs.size(); ++k) {
    if (!briefs[k].is_new) continue;
    const Manifold& m = world_->contacts_->contacts()[k].manifold;
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
  bodies_.for_movers(workers_, [&](std::uint32_t i, const SolverBody& body) {
    motion_.after[i] = {body.x, body.q};
  });
  world_->contact_source_->limit_motion(*world_, motion_.after, workers_, motion_.limits);
  for (const MotionLimit& limit : motion_.limits) {
    if (limit.body >= bodies_.size()) continue;
    SolverBody& body = bodies_[limit.body];
    const Vec3& start = world_->states_[limit.body].pose.position;
    body.x = limit.pose.position;
    // Spin follows the pose: kept in the world it would have another energy.
    body.w = rotate(limit.pose.orientation * body.q.conjugate(), body.w);
    body.q = limit.pose.orientation;
    restore_locked(body, world_->props_[limit.body].locks, start);
    // The rest of the step is skipped: gravity over it would add speed without motion.
    body.v -=
        (1.0 - limit.share) * dt_ * world_->props_[limit.body].gravity_scale * world_->gravity_;
    body.v -= std::min(0.0, (body.v - limit.obstacle_moves / dt_).dot(limit.normal)) * limit.normal;
    enforce_locks(body, world_->props_[limit.body].locks);
  }
  report_.stopped = static_cast<int>(motion_.limits.size());
}

}  // namespace tandem::pbd
