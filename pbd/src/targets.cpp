// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "targets.h"

#include <algorithm>
#include <cmath>

#include "integrate.h"
#include "joint_rows.h"
#include "tandem/pbd/math.h"
#include "tandem/pbd/portable.h"

namespace tandem::pbd {
namespace {

double kinetic_energy(const Quat& q, const BodyProps& props, const Vec3& v, const Vec3& w) {
  const Vec3 w_l = q.conjugate() * w;
  return 0.5 * (props.mass * v.squaredNorm() + w_l.dot(props.inertia * w_l));
}

/// The share that `times` applications of a share amount to.
double share_of_times(double share, double times) {
  return -portable::expm1(times * portable::log1p(-share));
}

/// Whether the body has the same inertia about every axis.
bool is_round(const BodyProps& props) {
  const Mat3& i = props.inertia;
  return i(0, 0) == i(1, 1) && i(1, 1) == i(2, 2) && i(0, 1) == 0.0 && i(0, 2) == 0.0 &&
         i(1, 2) == 0.0;
}

}  // namespace

void Targets::begin_step(std::span<const PoseTarget> targets, std::span<SolverBody> bodies,
                         std::span<const BodyState> states, double dt) {
  rows_.clear();
  closes_gaps_ = false;
  for (const PoseTarget& target : targets) {
    const SolverBody& body = bodies[target.body.index];
    if (body.inv_mass == 0.0 || !(target.share > 0.0)) continue;
    Row& row = rows_.emplace_back();
    row.body = target.body.index;
    row.motion = target.motion;
    // [Influence] A share is defined for 1/60 s of session time, whatever the step.
    row.step_share = share_of_times(std::min(target.share, 1.0), 60.0 * dt);
    row.pose = target.pose;
    row.twist = target.twist;
    const BodyState& state = states[row.body];
    row.e_x = target.pose.position - state.pose.position;
    row.e_q = target.use_rotation_error
                  ? target.rotation_error
                  : rotation_between(state.pose.orientation, target.pose.orientation);
    row.e_v = target.twist.linear - state.twist.linear;
    row.e_w = target.twist.angular - state.twist.angular;
  }
}

void Targets::mark_islands(std::span<const std::uint32_t> island_of,
                           std::span<const std::uint32_t> movers, std::span<SolverBody> bodies) {
  row_of_.assign(bodies.size(), BodyId::kNone);
  marked_.assign(bodies.size(), 0);
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    row_of_[rows_[k].body] = static_cast<std::uint32_t>(k);
    marked_[island_of[rows_[k].body]] = 1;
  }
  for (const std::uint32_t i : movers) {
    const bool in = bodies[i].is_solved() && marked_[island_of[i]] != 0;
    bodies[i].shared = bodies[i].agreed = bodies[i].held = in;
  }
}

void Targets::mark_gaps(std::span<const ConstraintEdge> joints,
                        std::span<const std::uint32_t> movers, std::span<SolverBody> bodies) {
  closes_gaps_ = true;
  sets_.build(joints, movers, bodies);
  const std::span<const std::uint32_t> set_of = sets_.of();
  excess_.resize(bodies.size());
  if (rows_.empty()) row_of_.assign(bodies.size(), BodyId::kNone);
  marked_.assign(bodies.size(), 0);
  for (const std::uint32_t i : movers) {
    if (bodies[i].held && !bodies[i].agreed) marked_[bodies[i].island] = 1;
  }
  for (const std::uint32_t i : movers) {
    SolverBody& body = bodies[i];
    body.held = body.is_solved() && (body.agreed || marked_[body.island] != 0);
  }
  marked_.assign(bodies.size(), 0);
  for (const std::uint32_t i : movers) {
    if (bodies[i].shared && !bodies[i].held) marked_[set_of[i]] = 1;
  }
  for (const std::uint32_t i : movers) {
    SolverBody& body = bodies[i];
    body.shared = body.is_solved() && (body.held || marked_[set_of[i]] != 0);
  }
}

void GroupTargets::select(Targets& all, const Group& group, std::span<const SolverBody> bodies) {
  all_ = &all;
  rows_.clear();
  saved_.clear();
  for (const std::uint32_t i : group.bodies) {
    if (bodies[i].shared) saved_.emplace_back().body = i;
    if (all.row_of_[i] != BodyId::kNone) rows_.push_back(all.row_of_[i]);
  }
  std::sort(rows_.begin(), rows_.end());
  for (const std::uint32_t k : rows_) {
    all.rows_[k].share = share_of_times(all.rows_[k].step_share, 1.0 / group.substeps);
  }
}

void GroupTargets::agree_velocities(std::span<SolverBody> bodies, const PropsTable& props,
                                    std::span<Correction> corrections, double h,
                                    ConsensusEnergy& energy) {
  for (const std::uint32_t k : rows_) {
    Targets::Row& row = all_->rows_[k];
    SolverBody& body = bodies[row.body];
    row.e_x += h * row.e_v;
    row.e_q += h * row.e_w;
    if (row.motion == TargetMotion::Inertial) {
      row.e_v = row.twist.linear - body.v;
      row.e_w = row.twist.angular - body.w;
    }
    const double before = kinetic_energy(body.q, props[row.body], body.v, body.w);
    Vec3 dv = row.share * row.e_v;
    Vec3 dw = row.share * row.e_w;
    zero_locked_axes(props[row.body].locks.linear, dv);
    zero_locked_axes(props[row.body].locks.angular, dw);
    body.v += dv;
    body.w += dw;
    row.e_v -= dv;
    row.e_w -= dw;
    corrections[row.body].twist.linear += dv;
    corrections[row.body].twist.angular += dw;
    energy.velocity_agreement += kinetic_energy(body.q, props[row.body], body.v, body.w) - before;
  }
}

void GroupTargets::begin(std::span<const SolverBody> bodies) {
  for (Saved& saved : saved_) {
    const SolverBody& body = bodies[saved.body];
    saved.x = body.x;
    saved.q = body.q;
    saved.v = body.v;
    saved.w = body.w;
  }
}

void GroupTargets::pull(std::span<SolverBody> bodies, const PropsTable& props, double elapsed) {
  for (const std::uint32_t k : rows_) {
    Targets::Row& row = all_->rows_[k];
    SolverBody& body = bodies[row.body];
    if (row.motion == TargetMotion::Inertial) {
      row.e_x = row.pose.position + elapsed * row.twist.linear - body.x;
      row.e_q =
          rotation_between(body.q, rotated(row.pose.orientation, elapsed * row.twist.angular));
    }
    body.dx = row.share * row.e_x;
    body.dtheta = row.share * row.e_q;
    zero_locked_axes(props[row.body].locks.linear, body.dx);
    zero_locked_axes(props[row.body].locks.angular, body.dtheta);
    body.x += body.dx;
    body.q = rotated(body.q, body.dtheta);
  }
}

void GroupTargets::to_velocities(std::span<SolverBody> bodies, double h) {
  for (const Saved& saved : saved_) {
    SolverBody& body = bodies[saved.body];
    if (!body.dx.isZero(0.0)) body.v_push = body.dx / h;
    if (body.dtheta.isZero(0.0)) continue;
    // A single turn is its row's rotation vector; those of joints add up to another one.
    const Vec3 turn = body.projected ? rotation_between(saved.q, body.q) : body.dtheta;
    body.w_push = turn / h;
  }
  limit_closing(bodies);
}

void GroupTargets::limit_closing(std::span<SolverBody> bodies) {
  if (!all_->closes_gaps_) return;
  const auto excess_of = [&](const Saved& saved) -> double& {
    return all_->excess_[all_->sets_.of()[saved.body]];
  };
  for (const Saved& saved : saved_) excess_of(saved) = 1.0;
  for (const Saved& saved : saved_) {
    const SolverBody& body = bodies[saved.body];
    if (body.agreed) continue;
    double& excess = excess_of(saved);
    excess =
        std::max({excess, body.v_push.norm() / kClosingSpeed, body.w_push.norm() / kClosingSpin});
  }
  for (const Saved& saved : saved_) {
    SolverBody& body = bodies[saved.body];
    if (body.agreed) continue;
    body.v_push /= excess_of(saved);
    body.w_push /= excess_of(saved);
  }
}

void GroupTargets::to_poses(std::span<SolverBody> bodies, double h) {
  for (Saved& saved : saved_) {
    SolverBody& body = bodies[saved.body];
    body.x = saved.x + h * body.v_push;
    saved.turn = h * body.w_push;
    body.q = body.w_push.isZero(0.0) ? saved.q : rotated(saved.q, saved.turn);
    body.v_push.setZero();
    body.w_push.setZero();
  }
}

void GroupTargets::end(std::span<const SolverBody> bodies, const PropsTable& props,
                       std::span<Correction> corrections, const Vec3& gravity,
                       ConsensusEnergy& energy) {
  for (const Saved& saved : saved_) {
    const SolverBody& body = bodies[saved.body];
    if (!body.agreed) continue;  // no agreement on this body
    const Vec3 moved = body.x - saved.x;
    corrections[saved.body].translation += moved;
    corrections[saved.body].rotation += saved.turn;
    const BodyProps& known = props[saved.body];
    energy.potential -= known.mass * known.gravity_scale * gravity.dot(moved);
    // Kinetic energy by velocities. A spinning body that was only turned has another energy at the
    // same velocity, which counts as potential energy.
    const bool as_fast = body.v == saved.v && body.w == saved.w;
    if (!as_fast || !(body.w.isZero(0.0) || is_round(known))) {
      const double velocities_only = kinetic_energy(saved.q, known, body.v, body.w);
      energy.displacement += velocities_only - kinetic_energy(saved.q, known, saved.v, saved.w);
      energy.potential += kinetic_energy(body.q, known, body.v, body.w) - velocities_only;
    }
    const std::uint32_t k = all_->row_of_[saved.body];
    if (k == BodyId::kNone) continue;
    Targets::Row& row = all_->rows_[k];
    row.e_x -= moved;
    row.e_q -= saved.turn;
  }
}

}  // namespace tandem::pbd
