// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "body_buffer.h"

#include <algorithm>
#include <atomic>
#include <numeric>
#include <utility>

#include "integrate.h"
#include "tandem/pbd/contact.h"
#include "tandem/pbd/math.h"

namespace tandem::pbd {
namespace {

bool is_finite(const SolverBody& body) {
  return body.x.allFinite() && body.q.coeffs().allFinite() && body.v.allFinite() &&
         body.w.allFinite();
}

void load_body(const BodyState& state, const BodyProps& props, SolverBody& body) {
  body.x = state.pose.position;
  body.q = state.pose.orientation;
  body.v = state.twist.linear;
  body.w = state.twist.angular;
  body.inv_mass = props.inverse_mass;
  // All motion of an immovable body counts as applied; for the others each substep sets this.
  body.v_applied = body.inv_mass > 0.0 ? Vec3(Vec3::Zero()) : body.v;
  body.w_applied = body.inv_mass > 0.0 ? Vec3(Vec3::Zero()) : body.w;
  body.gravity_scale = body.inv_mass > 0.0 ? props.gravity_scale : 0.0;
  body.inv_inertia_w.setZero();
  body.dx.setZero();
  body.dtheta.setZero();
  body.v_push.setZero();
  body.w_push.setZero();
  body.group = SolverBody::kNoGroup;
  body.shared = false;
  body.agreed = false;
  body.held = false;
  body.projected = false;
  body.pushed = false;
  body.turns = false;
  body.reoriented = false;
  body.stale = 0.0;
  const auto& locked = props.locks.angular;
  body.turns_freely = !locked[0] && !locked[1] && !locked[2];
}

}  // namespace

void BodyBuffer::aim_kinematic(World& world, double dt) {
  for (const KinematicTarget& target : world.kinematic_targets()) {
    const Pose& pose = world.states_[target.index].pose;
    world.states_[target.index].twist = {
        (target.pose.position - pose.position) / dt,
        rotation_between(pose.orientation, target.pose.orientation) / dt};
  }
}

bool BodyBuffer::rest(const World& world, double dt) const {
  constexpr int kRepeats = 2;
  if (rest_.steps < kRepeats || dt != rest_.dt || !world.body_log_.is_quiet(rest_.since))
    return false;
  if (world.target_source_ != nullptr || world.island_coupling_ != nullptr) return false;
  if (world.contact_source_ != nullptr && !world.contact_source_->repeats()) return false;
  // Rows of other kinds may change without notice to the world.
  return std::all_of(world.blocks_.begin(), world.blocks_.end(), [&](const auto& block) {
    return block.get() == world.contacts_ || block->empty();
  });
}

void BodyBuffer::note_rest(World& world, double dt, bool still, bool may_rest) {
  const bool quiet =
      still && may_rest && world.body_log_.is_quiet(rest_.since) && world.target_source_ == nullptr;
  rest_.steps = quiet ? rest_.steps + 1 : 0;
  rest_.dt = dt;
  // Tells everyone who has seen the world at rest, other solvers too, that this has ended.
  if (!still) world.body_log_.stir();
  world.body_log_.read(rest_.since, [](std::uint32_t) {});
}

void BodyBuffer::load(World& world, Workers& workers) {
  const std::size_t count = world.states_.size();
  movers_ = world.movers();
  if (world.island_coupling_ != nullptr) {
    every_slot_.resize(count);
    std::iota(every_slot_.begin(), every_slot_.end(), 0u);
    movers_ = every_slot_;
  }
  bodies_.resize(count);
  kinematic_.clear();
  loaded_.resize(count);
  const auto renew = [&](std::uint32_t i) {
    if (i < count && loaded_[i] != 0) load_one(world, i);
  };
  std::for_each(marked_.begin(), marked_.end(), renew);
  marked_.clear();
  if (!world.body_log_.read(seen_, renew)) {
    for (std::uint32_t i = 0; i < count; ++i) renew(i);
  }
  for_movers(workers, [&](std::uint32_t i, SolverBody&) { load_one(world, i); });
  for (const std::uint32_t i : movers_) {
    if (world.props_[i].type == BodyType::Kinematic) kinematic_.push_back(i);
  }
}

void BodyBuffer::load_one(const World& world, std::uint32_t i) {
  load_body(world.states_[i], world.props_[i], bodies_[i]);
  bodies_[i].island = i;
  loaded_[i] = 1;
}

void BodyBuffer::load_named(const World& world, const ConstraintEdges& edges) {
  for (const std::span<const ConstraintEdge> list : {edges.all(), edges.idle()}) {
    for (const ConstraintEdge& edge : list) {
      load_once(world, edge.body_a);
      load_once(world, edge.body_b);
    }
  }
}

void BodyBuffer::load_named(const World& world, std::span<const PoseTarget> targets) {
  for (const PoseTarget& target : targets) load_once(world, target.body.index);
}

void BodyBuffer::mark_joined(const ConstraintEdges& edges) {
  if (edges.projecting().empty()) return;
  const auto for_bodies = [&](std::span<const ConstraintEdge> list, auto&& mark) {
    for (const ConstraintEdge& edge : list) {
      if (edge.body_a != BodyId::kNone) mark(bodies_[edge.body_a]);
      if (edge.body_b != BodyId::kNone) mark(bodies_[edge.body_b]);
    }
  };
  for_bodies(edges.projecting(), [&](SolverBody& body) {
    if (body.inv_mass == 0.0 && !body.projected) {
      marked_.push_back(static_cast<std::uint32_t>(&body - bodies_.data()));
    }
    body.projected = true;
  });
  for_bodies(edges.all().subspan(edges.projecting().size()),
             [](SolverBody& body) { body.pushed = body.inv_mass > 0.0; });
}

int BodyBuffer::prepare(const World& world, std::span<const ConstraintEdge> edges,
                        std::span<const Group> groups, Workers& workers) {
  bool all_turn = true;
  for (const Group& group : groups) {
    for (const std::uint32_t i : group.bodies) {
      SolverBody& body = bodies_[i];
      body.turns = body.projected || body.shared || !body.w.isZero(0.0) ||
                   (!world.wrenches_.empty() && !world.wrenches_[i].torque.isZero(0.0));
      all_turn = all_turn && body.turns;
    }
  }
  if (!all_turn) mark_turned(world, edges);
  for_movers(workers, [&](std::uint32_t i, SolverBody& body) {
    const bool solved = body.group != SolverBody::kNoGroup && body.turns;
    if (solved) refresh_inertia(body, world.props_[i]);
  });
  int count = 0;
  for (const Group& group : groups) {
    for (const std::uint32_t i : group.bodies) count += bodies_[i].turns ? 1 : 0;
  }
  return count;
}

void BodyBuffer::keep_inertias() {
  inertias_.resize(bodies_.size());
  for (const std::uint32_t i : movers_) keep_inertia(i);
}

void BodyBuffer::renew_inertia(std::uint32_t slot, const BodyProps& props) {
  SolverBody& body = bodies_[slot];
  if (!body.projected || !body.pushed) return;
  const double turn = 2.0 * (inertias_[slot].q.conjugate() * body.q).vec().norm();
  body.reoriented = staleness(turn, props.principal.moments) > kStale;
  if (!body.reoriented) return;
  refresh_inertia(body, props);
  keep_inertia(slot);
}

/// Rows exert torques, except frictionless contacts whose force passes through the centre.
void BodyBuffer::mark_turned(const World& world, std::span<const ConstraintEdge> edges) {
  for (const ConstraintEdge& edge : edges) {
    if (edge.body_a != BodyId::kNone) bodies_[edge.body_a].turns = true;
    if (edge.body_b != BodyId::kNone) bodies_[edge.body_b].turns = true;
  }
  if (world.contacts_ == nullptr) return;
  const std::span<const ContactBrief> briefs = world.contacts_->briefs();
  for (std::size_t k = 0; k < briefs.size(); ++k) {
    bool arm_a = briefs[k].rubs;
    bool arm_b = briefs[k].rubs;
    const Manifold& m = world.contacts_->contacts()[k].manifold;
    for (int i = 0; !(arm_a && arm_b) && i < m.count; ++i) {
      arm_a = arm_a || !m.points[i].anchor_a_l.isZero(0.0);
      arm_b = arm_b || !m.points[i].anchor_b_l.isZero(0.0);
    }
    if (arm_a) bodies_[briefs[k].a].turns = true;
    if (arm_b) bodies_[briefs[k].b].turns = true;
  }
}

void BodyBuffer::move_kinematic(double h) {
  for (const std::uint32_t i : kinematic_) {
    SolverBody& body = bodies_[i];
    // Bodies at rest may be in any group; their bits stay.
    if (body.v.isZero(0.0) && body.w.isZero(0.0)) continue;
    body.x += h * body.v;
    body.q = rotated(body.q, h * body.w);
  }
}

void BodyBuffer::rewind_kinematic(std::span<const BodyState> states) {
  for (const std::uint32_t i : kinematic_) {
    bodies_[i].x = states[i].pose.position;
    bodies_[i].q = states[i].pose.orientation;
  }
}

void BodyBuffer::store(World& world, double dt, std::span<const Group> groups, Workers& workers,
                       StepReport& report) {
  std::atomic<bool> any_bad{false};
  for_movers(workers, [&](std::uint32_t i, const SolverBody& body) {
    if (body.group == SolverBody::kNoGroup) return;
    if (is_finite(body)) {
      world.states_[i] = {{body.x, body.q}, {body.v, body.w}};
    } else {
      any_bad.store(true, std::memory_order_relaxed);
    }
  });
  if (any_bad.load()) {
    for (const Group& group : groups) {
      for (const std::uint32_t i : group.bodies) {
        if (!is_finite(bodies_[i])) refuse(world, i, report);
      }
    }
  }
  store_kinematic(world, dt, report);
  world.placements_.note();
  if (world.contacts_ != nullptr) mark_contacts(world);
  // Immovable bodies may have become non-finite too.
  if (report.status != StepStatus::Ok) seen_ = {};
}

/// The pose stays where the step began.
void BodyBuffer::refuse(World& world, std::uint32_t i, StepReport& report) {
  world.states_[i].twist = {};
  if (report.status != StepStatus::Ok && i >= report.first_bad_body.index) return;
  report.status = StepStatus::NonFinite;
  report.first_bad_body = {i, world.slots_.generation(i)};
}

void BodyBuffer::store_kinematic(World& world, double dt, StepReport& report) {
  for (const std::uint32_t i : kinematic_) {
    SolverBody body = bodies_[i];
    Pose& pose = world.states_[i].pose;
    body.x = pose.position + dt * body.v;
    body.q = rotated(pose.orientation, dt * body.w);
    if (is_finite(body)) {
      pose = {body.x, body.q};
    } else {
      refuse(world, i, report);
    }
  }
  for (const KinematicTarget& target : world.kinematic_targets()) {
    world.states_[target.index] = {target.pose, {}};
  }
  world.kinematic_targets_.clear();
}

void BodyBuffer::mark_contacts(World& world) {
  for (const std::uint32_t i : world.touching_) world.in_contact_[i] = 0;
  world.touching_.clear();
  for (const ContactBrief& contact : world.contacts_->briefs()) {
    if (!contact.loaded) continue;
    for (const std::uint32_t i : {contact.a, contact.b}) {
      if (std::exchange(world.in_contact_[i], std::uint8_t{1}) == 0) world.touching_.push_back(i);
    }
  }
}

}  // namespace tandem::pbd
