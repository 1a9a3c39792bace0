// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/pbd/solver.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "groups.h"
#include "integrate.h"
#include "islands.h"
#include "stage_clock.h"
#include "tandem/pbd/math.h"
#include "tandem/pbd/workers.h"
#include "targets.h"

namespace tandem::pbd {
namespace {

/// Bodies given to a worker at a time.
constexpr std::size_t kBodyGrain = 256;

bool is_finite(const SolverBody& body) {
  return body.x.allFinite() && body.q.coeffs().allFinite() && body.v.allFinite() &&
         body.w.allFinite();
}

}  // namespace

class Solver::Impl {
 public:
  explicit Impl(const SolverOptions& options) : options_(options), workers_(options.threads) {}
  const SolverOptions& options() const { return options_; }

  const StepReport& step(World& world, double dt) {
    begin_step(world, dt);
    for (std::uint32_t group = 0; group < groups_.all().size(); ++group) {
      begin_group(group);
      for (int i = 0; i < context_.substeps; ++i) {
        begin_substep(i);
        integrate();
        project();
        advance_poses();
        agree_velocities();
        solve_velocities();
        if (options_.form == ConsensusForm::Substep) solve_total(options_.total_iterations);
      }
      if (options_.form == ConsensusForm::Step) solve_total(options_.total_iterations_per_step);
    }
    clean_up();
    end_step();
    return report_;
  }

  const StepReport& refuse() {
    report_ = {};
    return report_;
  }

 private:
  // --- stages -----------------------------------------------------------------------------------

  void begin_step(World& world, double dt) {
    world_ = &world;
    dt_ = dt;
    clock_.start(options_.measure_stages);
    reset_report();
    detect();
    clock_.stop(Stage::Detect);
    load_bodies();
    collect_targets();
    arrange_groups();
    context_ = {.bodies = bodies_,
                .h = dt / options_.substeps,
                .gravity = world.gravity_,
                .workers = &workers_};
    for_blocks([&](ConstraintBlock& block) { block.begin_step(context_); });
    clock_.stop(Stage::Begin);
  }

  void begin_group(std::uint32_t group) {
    group_ = &groups_.all()[group];
    context_.group = group;
    context_.substeps = group_->substeps;
    context_.h = dt_ / group_->substeps;
    if (group > 0) rewind_kinematic();
    if (!targets_.empty()) {
      const int parts = options_.form == ConsensusForm::Substep ? group_->substeps : 1;
      targets_.select_group(group, parts, bodies_);
    }
    report_.substeps = std::max(report_.substeps, group_->substeps);
  }

  void begin_substep(int i) {
    context_.substep = i;
    context_.last = i + 1 == context_.substeps;
    context_.reverse = (i % 2) == 1;
    for_blocks([&](ConstraintBlock& block) { block.begin_substep(context_); });
    clock_.stop(Stage::Begin);
  }

  /// Velocities to the end of the substep; poses only of bodies whose rows project them.
  void integrate() {
    const double h = context_.h;
    for_group([&](SolverBody& body, std::uint32_t i) {
      const Wrench* wrench = world_->wrenches_.empty() ? nullptr : &world_->wrenches_[i];
      integrate_velocity(body, world_->props_[i], wrench, context_.gravity, h);
    });
    for (const std::uint32_t i : kinematic_) {
      bodies_[i].x += h * bodies_[i].v;
      bodies_[i].q = rotated(bodies_[i].q, h * bodies_[i].w);
    }
    clock_.stop(Stage::Integrate);
  }

  void project() {
    for_blocks([&](ConstraintBlock& block) { block.warm_start(context_); });
    for (int i = 0; i < options_.position_iterations; ++i) {
      if (projects_) project_joints();
      for_blocks([&](ConstraintBlock& block) {
        if (is_last(block)) block.project(context_);
      });
    }
    clock_.stop(Stage::Project);
  }

  void advance_poses() {
    const double h = context_.h;
    for_group([&](SolverBody& body, std::uint32_t i) {
      if (world_->props_[i].locks.any()) enforce_locks(body, world_->props_[i].locks);
      advance_pose(body, h);
    });
    clock_.stop(Stage::Integrate);
  }

  /// Before the contact velocity pass, so that contacts can veto it.
  void agree_velocities() {
    if (targets_.empty() || !targets_.selected()) return;
    targets_.advance(context_.h, context_.h * (context_.substep + 1));
    if (options_.form == ConsensusForm::Substep || context_.last) {
      targets_.agree_velocities(bodies_, world_->props_, world_->corrections_, report_.energy);
    }
  }

  void solve_velocities() {
    const bool reverse = context_.reverse;
    for (int i = 0; i < options_.velocity_iterations; ++i) {
      double change = 0.0;
      context_.reverse = (context_.substep + i) % 2 == 0;
      for_blocks([&](ConstraintBlock& block) {
        change = std::max(change, block.solve_velocity(context_));
      });
      ++report_.velocity_iterations;
      if (change <= options_.velocity_tolerance) break;
    }
    context_.reverse = reverse;
    for_blocks([&](ConstraintBlock& block) { block.finish_velocity(context_); });
    if (group_->locked) {
      for_group(
          [&](SolverBody& body, std::uint32_t i) { enforce_locks(body, world_->props_[i].locks); });
    }
    clock_.stop(Stage::Velocity);
  }

  /// The total channel: the same rows once more, for where bodies are and not for how they move.
  void solve_total(int iterations) {
    if (targets_.empty() || !targets_.selected()) return;
    SubstepContext context = context_;
    if (options_.form == ConsensusForm::Step) context.h = dt_;
    targets_.begin_total(bodies_);
    for_blocks([&](ConstraintBlock& block) { block.begin_total(context); });
    targets_.move_bodies(bodies_);
    for (int i = 0; i < iterations; ++i) {
      context.reverse = (context_.substep + i) % 2 == 1;
      for_blocks([&](ConstraintBlock& block) { block.project_total(context); });
    }
    for_blocks([&](ConstraintBlock& block) { block.end_total(context); });
    targets_.end_total(bodies_, world_->props_, world_->corrections_, context_.gravity,
                       report_.energy);
    clock_.stop(Stage::Total);
  }

  void clean_up() {
    SubstepContext context = context_;
    context.h = dt_;
    for (int i = 0; i < options_.clean_up_iterations; ++i) {
      bool any = false;
      context.reverse = i % 2 == 1;
      for_blocks([&](ConstraintBlock& block) { any = block.clean_up(context) || any; });
      if (!any) break;
    }
    if (!targets_.empty()) {
      for (context.group = 0; context.group < groups_.all().size(); ++context.group) {
        for_blocks([&](ConstraintBlock& block) { block.end_total(context); });
      }
      targets_.leak(options_.leak, dt_, bodies_, world_->props_, report_.energy);
    }
    clock_.stop(Stage::CleanUp);
  }

  void end_step() {
    SubstepContext context = context_;
    context.h = dt_;
    context.substeps = options_.substeps;
    for_blocks([&](ConstraintBlock& block) { block.end_step(context); });
    wanted_.assign(bodies_.size(), 0.0);
    if (options_.refine) {
      for_blocks([&](ConstraintBlock& block) { block.want_substeps(context, wanted_); });
    }
    groups_.settle(group_rule(), dt_, islands_, world_->blocks_, wanted_, world_->props_,
                   world_->activity_, bodies_);
    limit_motion();
    store_bodies();
    world_->wrenches_.clear();
    world_->time_ += dt_;
    for (const auto& block : world_->blocks_) {
      if (!block->empty()) report_.blocks.push_back(block->report());
    }
    clock_.stop(Stage::End);
    report_.stage_s = clock_.seconds();
  }

  // --- parts of stages --------------------------------------------------------------------------

  /// Marks the bodies whose poses rows project.
  class ProjectedMarker final : public LinkVisitor {
   public:
    explicit ProjectedMarker(std::span<SolverBody> bodies) : bodies_(bodies) {}
    void link(std::uint32_t a, std::uint32_t b) override {
      if (a != BodyId::kNone) bodies_[a].projected = true;
      if (b != BodyId::kNone) bodies_[b].projected = true;
    }

   private:
    std::span<SolverBody> bodies_;
  };

  /// Non-penetration has the last word in each sweep.
  static bool is_last(const ConstraintBlock& block) {
    return block.order() >= static_cast<int>(SolveOrder::Contact);
  }

  void project_joints() {
    const double h = context_.h;
    for_group([&](SolverBody& body, std::uint32_t i) {
      if (!body.projected) return;
      advance_pose(body, h);
      refresh_inertia(body, world_->props_[i]);
    });
    const bool reverse = context_.reverse;
    for (int i = 0; i < options_.joint_iterations; ++i) {
      double largest = 0.0;
      for_blocks([&](ConstraintBlock& block) {
        if (!is_last(block)) largest = std::max(largest, block.project(context_));
      });
      if (largest <= options_.joint_tolerance) break;
      context_.reverse = !context_.reverse;
    }
    context_.reverse = reverse;
    for_group([&](SolverBody& body, std::uint32_t i) {
      if (body.projected) absorb_corrections(body, world_->props_[i], h);
    });
  }

  template <class Visit>
  void for_blocks(Visit&& visit) {
    for (const auto& block : world_->blocks_) {
      if (!block->empty()) visit(*block);
    }
  }

  /// Bodies of the current group, shared out among the workers.
  template <class Visit>
  void for_group(Visit&& visit) {
    const std::vector<std::uint32_t>& list = group_->bodies;
    workers_.for_chunks(list.size(), kBodyGrain, [&](std::size_t begin, std::size_t end, int) {
      for (std::size_t k = begin; k < end; ++k) visit(bodies_[list[k]], list[k]);
    });
  }

  void reset_report() {
    report_.status = StepStatus::Ok;
    report_.first_bad_body = {};
    report_.substeps = 0;
    report_.bodies = static_cast<int>(world_->body_count());
    report_.velocity_iterations = 0;
    report_.groups = 0;
    report_.stopped = 0;
    report_.awake = 0;
    report_.blocks.clear();
    report_.energy = {};
  }

  void detect() {
    if (world_->contact_source_ == nullptr) return;
    manifolds_.clear();
    world_->contact_source_->collect(*world_, dt_, workers_, manifolds_);
    world_->contacts_->configure(options_.contact);
    world_->contacts_->set_manifolds(manifolds_);
  }

  void load_bodies() {
    const std::size_t count = world_->states_.size();
    bodies_.resize(count);
    kinematic_.clear();
    workers_.for_chunks(count, kBodyGrain, [&](std::size_t begin, std::size_t end, int) {
      for (std::size_t i = begin; i < end; ++i) load_body(i);
    });
    for (std::uint32_t i = 0; i < count; ++i) {
      if (world_->props_[i].type == BodyType::Kinematic) kinematic_.push_back(i);
    }
    for (const World::KinematicTarget& target : world_->kinematic_targets_) {
      SolverBody& body = bodies_[target.index];
      body.v = (target.pose.position - body.x) / dt_;
      body.w = rotation_between(body.q, target.pose.orientation) / dt_;
      world_->states_[target.index].twist = {body.v, body.w};
    }
  }

  void load_body(std::size_t i) {
    const BodyState& state = world_->states_[i];
    const BodyProps& props = world_->props_[i];
    SolverBody& body = bodies_[i];
    body.x = state.pose.position;
    body.q = state.pose.orientation;
    body.v = state.twist.linear;
    body.w = state.twist.angular;
    body.inv_mass = props.inverse_mass;
    body.gravity_scale = body.inv_mass > 0.0 ? props.gravity_scale : 0.0;
    if (body.inv_mass > 0.0) {
      refresh_inertia(body, props);
    } else {
      body.inv_inertia_w.setZero();
    }
    body.dx.setZero();
    body.dtheta.setZero();
    body.v_push.setZero();
    body.w_push.setZero();
    body.group = SolverBody::kNoGroup;
    body.total = false;
    body.projected = false;
  }

  void rewind_kinematic() {
    for (const std::uint32_t i : kinematic_) {
      bodies_[i].x = world_->states_[i].pose.position;
      bodies_[i].q = world_->states_[i].pose.orientation;
    }
  }

  void collect_targets() {
    pose_targets_.clear();
    if (world_->target_source_ != nullptr) {
      world_->target_source_->collect(*world_, dt_, pose_targets_);
      std::erase_if(pose_targets_, [&](const PoseTarget& t) { return !usable(t); });
      world_->corrections_.assign(bodies_.size(), {});
    }
    targets_.begin_step(pose_targets_, bodies_, world_->states_, dt_);
    report_.targets = targets_.size();
  }

  /// Islands, and from them the groups that are solved together.
  void arrange_groups() {
    islands_.build(world_->blocks_, bodies_);
    changed_.clear();
    for (const auto& block : world_->blocks_) block->take_changed(changed_);
    groups_.arrange(group_rule(), islands_, changed_, world_->blocks_, pose_targets_,
                    world_->props_, world_->activity_, bodies_);
    if (!targets_.empty()) targets_.mark_islands(islands_.of(), bodies_);
    report_.groups = static_cast<int>(groups_.all().size());
    report_.awake = 0;
    for (const Group& group : groups_.all()) report_.awake += static_cast<int>(group.bodies.size());
    ProjectedMarker marker(bodies_);
    projects_ = false;
    for_blocks([&](ConstraintBlock& block) {
      if (is_last(block)) return;
      projects_ = true;
      block.links(marker);
    });
  }

  Groups::Rule group_rule() const {
    return {.substeps = options_.substeps,
            .sleep_after = options_.sleep_after,
            .sleep_speed = options_.sleep_speed,
            .sleep_spin = options_.sleep_spin};
  }

  /// Not-a-number never enters a world, whoever made the target.
  bool usable(const PoseTarget& target) const {
    return world_->contains(target.body) && target.pose.position.allFinite() &&
           std::abs(target.pose.orientation.norm() - 1.0) < 1e-3 &&
           target.twist.linear.allFinite() && target.twist.angular.allFinite() &&
           target.rotation_error.allFinite() && std::isfinite(target.share);
  }

  void store_bodies() {
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      if (world_->alive_[i] == 0 || world_->props_[i].type != BodyType::Dynamic) continue;
      const SolverBody& body = bodies_[i];
      BodyState& state = world_->states_[i];
      if (!is_finite(body)) {
        if (report_.status == StepStatus::Ok) {
          report_.status = StepStatus::NonFinite;
          report_.first_bad_body = {static_cast<std::uint32_t>(i), world_->generations_[i]};
        }
        state.twist = {};  // the pose stays where the step began
        continue;
      }
      state.pose = {body.x, body.q};
      state.twist = {body.v, body.w};
    }
    for (const std::uint32_t i : kinematic_) {
      world_->states_[i].pose.position += dt_ * bodies_[i].v;
      world_->states_[i].pose.orientation =
          rotated(world_->states_[i].pose.orientation, dt_ * bodies_[i].w);
    }
    for (const World::KinematicTarget& target : world_->kinematic_targets_) {
      world_->states_[target.index] = {target.pose, {}};
    }
    world_->kinematic_targets_.clear();
    if (world_->contacts_ != nullptr) mark_contacts();
  }

  /// Nothing tunnels: bodies that would get through something stop on their way.
  void limit_motion() {
    if (world_->contact_source_ == nullptr) return;
    after_.resize(bodies_.size());
    for (std::size_t i = 0; i < bodies_.size(); ++i) after_[i] = {bodies_[i].x, bodies_[i].q};
    world_->contact_source_->limit_motion(*world_, after_, workers_, limits_);
    for (const MotionLimit& limit : limits_) {
      SolverBody& body = bodies_[limit.body];
      const Vec3& start = world_->states_[limit.body].pose.position;
      body.x = start + limit.share * (body.x - start);
      body.v -= std::min(0.0, body.v.dot(limit.normal)) * limit.normal;
    }
    report_.stopped = static_cast<int>(limits_.size());
  }

  void mark_contacts() {
    std::fill(world_->in_contact_.begin(), world_->in_contact_.end(), std::uint8_t{0});
    for (const Contact& contact : world_->contacts_->contacts()) {
      if (!contact.loaded()) continue;
      world_->in_contact_[contact.manifold.body_a] = 1;
      world_->in_contact_[contact.manifold.body_b] = 1;
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
  std::vector<SolverBody> bodies_;
  std::vector<std::uint32_t> kinematic_;
  bool projects_ = false;  ///< some row projects poses
  Groups groups_;
  std::vector<std::uint32_t> changed_;  ///< bodies whose rows were changed
  std::vector<double> wanted_;          ///< by body: substeps that rows ask for
  const Group* group_ = nullptr;        ///< the one being solved
  std::vector<Manifold> manifolds_;
  std::vector<Pose> after_;  ///< by slot
  std::vector<MotionLimit> limits_;
  std::vector<PoseTarget> pose_targets_;
};

Solver::Solver(const SolverOptions& options) {
  std::string error;
  if (!options.validate(&error)) throw std::invalid_argument(error);
  impl_ = std::make_unique<Impl>(options);
}
Solver::~Solver() = default;
Solver::Solver(Solver&&) noexcept = default;
Solver& Solver::operator=(Solver&&) noexcept = default;

const SolverOptions& Solver::options() const { return impl_->options(); }

const StepReport& Solver::step(World& world, double dt) noexcept {
  if (!(dt > 0.0) || !std::isfinite(dt)) return impl_->refuse();
  return impl_->step(world, dt);
}

}  // namespace tandem::pbd
