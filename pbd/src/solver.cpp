// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/pbd/solver.h"

#include <chrono>
#include <cmath>
#include <stdexcept>

#include "stage_clock.h"
#include "tandem/pbd/math.h"
#include "tandem/pbd/workers.h"
#include "targets.h"

namespace tandem::pbd {
namespace {

/// Below this, gyroscopic torque is beneath rounding (spheres, cubes, slow bodies): rad^2.
constexpr double kGyroscopicTolerance = 1e-14;

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
    for (int i = 0; i < options_.substeps; ++i) {
      begin_substep(i);
      integrate();
      project();
      derive_velocities();
      agree_velocities();
      solve_velocities();
      if (options_.form == ConsensusForm::Substep) solve_total(options_.total_iterations);
    }
    if (options_.form == ConsensusForm::Step) solve_total(options_.total_iterations_per_step);
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
    latch_targets();
    context_ = {.bodies = bodies_, .h = dt / options_.substeps, .gravity = world.gravity_};
    for_blocks([&](ConstraintBlock& block) { block.begin_step(context_); });
    clock_.stop(Stage::Begin);
  }

  void begin_substep(int i) {
    context_.substep = i;
    context_.reverse = (i % 2) == 1;
    for_blocks([&](ConstraintBlock& block) { block.begin_substep(context_); });
    clock_.stop(Stage::Begin);
  }

  void integrate() {
    const double h = context_.h;
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      SolverBody& body = bodies_[i];
      const BodyProps& props = world_->props_[i];
      body.dx.setZero();
      body.dtheta.setZero();
      if (props.type == BodyType::Static) continue;
      if (props.type == BodyType::Dynamic) {
        body.v += h * props.gravity_scale * context_.gravity;
        integrate_rotation(body, props, h);
      } else {
        body.q = rotated(body.q, h * body.w);
      }
      body.x += h * body.v;
    }
    clock_.stop(Stage::Integrate);
  }

  void project() {
    for_blocks([&](ConstraintBlock& block) { block.warm_start(context_); });
    for (int i = 0; i < options_.position_iterations; ++i) {
      project_joints();
      for_blocks([&](ConstraintBlock& block) {
        if (is_last(block)) block.project(context_);
      });
    }
    clock_.stop(Stage::Project);
  }

  void derive_velocities() {
    const double inverse_h = 1.0 / context_.h;
    for (SolverBody& body : bodies_) {
      if (body.inv_mass == 0.0) continue;
      body.v += inverse_h * body.dx;
      body.w += inverse_h * body.dtheta;
    }
  }

  /// Before the contact velocity pass, so that contacts can veto it.
  void agree_velocities() {
    if (targets_.empty()) return;
    targets_.advance(context_.h, context_.h * (context_.substep + 1));
    if (options_.form == ConsensusForm::Substep || context_.substep + 1 == options_.substeps) {
      targets_.agree_velocities(bodies_, world_->props_, world_->corrections_, report_.energy);
    }
  }

  void solve_velocities() {
    for (int i = 0; i < options_.velocity_iterations; ++i) {
      double change = 0.0;
      context_.reverse = (context_.substep + i) % 2 == 1;
      for_blocks([&](ConstraintBlock& block) {
        change = std::max(change, block.solve_velocity(context_));
      });
      ++report_.velocity_iterations;
      if (change <= options_.velocity_tolerance) break;
    }
    for_blocks([&](ConstraintBlock& block) { block.finish_velocity(context_); });
    clock_.stop(Stage::Velocity);
  }

  /// The total channel: the same rows once more, for where bodies are and not for how they move.
  void solve_total(int iterations) {
    if (targets_.empty()) return;
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
      context.reverse = i % 2 == 1;
      for_blocks([&](ConstraintBlock& block) { block.clean_up(context); });
    }
    if (!targets_.empty()) {
      for_blocks([&](ConstraintBlock& block) { block.end_total(context); });
      targets_.leak(options_.leak, dt_, bodies_, world_->props_, report_.energy);
    }
    clock_.stop(Stage::CleanUp);
  }

  void end_step() {
    SubstepContext context = context_;
    context.h = dt_;
    for_blocks([&](ConstraintBlock& block) { block.end_step(context); });
    store_bodies();
    world_->time_ += dt_;
    for (const auto& block : world_->blocks_) {
      if (!block->empty()) report_.blocks.push_back(block->report());
    }
    clock_.stop(Stage::End);
    report_.stage_s = clock_.seconds();
  }

  // --- parts of stages --------------------------------------------------------------------------

  /// Non-penetration has the last word in each sweep.
  static bool is_last(const ConstraintBlock& block) {
    return block.order() >= static_cast<int>(SolveOrder::Contact);
  }

  void project_joints() {
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
  }

  template <class Visit>
  void for_blocks(Visit&& visit) {
    for (const auto& block : world_->blocks_) {
      if (!block->empty()) visit(*block);
    }
  }

  void reset_report() {
    report_.status = StepStatus::Ok;
    report_.first_bad_body = {};
    report_.substeps = options_.substeps;
    report_.bodies = static_cast<int>(world_->body_count());
    report_.velocity_iterations = 0;
    report_.blocks.clear();
    report_.energy = {};
  }

  void detect() {
    if (world_->contact_source_ == nullptr) return;
    manifolds_.clear();
    world_->contact_source_->collect(*world_, dt_, workers_, manifolds_);
    const double h = dt_ / options_.substeps;
    world_->contacts_->configure(options_.contact, world_->gravity_.norm());
    world_->contacts_->set_manifolds(manifolds_, world_->last_h_ > 0.0 ? h / world_->last_h_ : 1.0);
    world_->last_h_ = h;
  }

  void load_bodies() {
    const std::size_t count = world_->states_.size();
    bodies_.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
      const BodyState& state = world_->states_[i];
      SolverBody& body = bodies_[i];
      body.x = state.pose.position;
      body.q = state.pose.orientation;
      body.v = state.twist.linear;
      body.w = state.twist.angular;
      body.inv_mass = world_->props_[i].inverse_mass;
      body.inv_inertia_w = tensor_to_world(body.q, world_->props_[i].inverse_inertia_l);
      body.total = false;
      body.group = body.inv_mass > 0.0 ? 0 : SolverBody::kNoGroup;
    }
  }

  void latch_targets() {
    pose_targets_.clear();
    if (world_->target_source_ != nullptr) {
      world_->target_source_->collect(*world_, dt_, pose_targets_);
      std::erase_if(pose_targets_, [&](const PoseTarget& t) { return !usable(t); });
      world_->corrections_.assign(bodies_.size(), {});
    }
    const int parts = options_.form == ConsensusForm::Substep ? options_.substeps : 1;
    targets_.begin_step(pose_targets_, bodies_, world_->states_, dt_, parts);
    if (!targets_.empty()) targets_.mark_islands(world_->blocks_, bodies_);
    report_.targets = targets_.size();
  }

  /// Not-a-number never enters a world, whoever made the target.
  bool usable(const PoseTarget& target) const {
    return world_->contains(target.body) && target.pose.position.allFinite() &&
           std::abs(target.pose.orientation.norm() - 1.0) < 1e-3 &&
           target.twist.linear.allFinite() && target.twist.angular.allFinite() &&
           target.rotation_error.allFinite() && std::isfinite(target.share);
  }

  static void integrate_rotation(SolverBody& body, const BodyProps& props, double h) {
    Vec3 w_l = body.q.conjugate() * body.w;
    const Vec3 momentum_l = props.inertia_l * w_l;
    const Vec3 torque_l = w_l.cross(momentum_l);
    if (torque_l.squaredNorm() * h * h > kGyroscopicTolerance * momentum_l.squaredNorm()) {
      const Vec3 next_l = torque_free_step(props.inertia_l, w_l, h);
      const Vec3 middle_w = body.q * Vec3(0.5 * (w_l + next_l));
      body.q = rotated(body.q, h * middle_w);
      body.w = body.q * next_l;
    } else {
      body.q = rotated(body.q, h * body.w);
    }
    body.inv_inertia_w = tensor_to_world(body.q, props.inverse_inertia_l);
  }

  void store_bodies() {
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      if (world_->alive_[i] == 0 || world_->props_[i].type == BodyType::Static) continue;
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
    if (world_->contacts_ != nullptr) mark_contacts();
  }

  void mark_contacts() {
    std::fill(world_->in_contact_.begin(), world_->in_contact_.end(), std::uint8_t{0});
    for (const ContactRow& row : world_->contacts_->rows()) {
      for (int i = 0; i < row.manifold.count; ++i) {
        if (row.lambda[i] <= 0.0) continue;
        world_->in_contact_[row.manifold.body_a] = 1;
        world_->in_contact_[row.manifold.body_b] = 1;
        break;
      }
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
  std::vector<SolverBody> bodies_;
  std::vector<Manifold> manifolds_;
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
