// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "integrate.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "free_rotation.h"
#include "joint_algebra.h"
#include "tandem/pbd/math.h"
#include "tandem/pbd/portable.h"

namespace tandem::pbd {
namespace {

/// rad/s: the gyroscopic effect of slower rotation is negligible. So is torque that turns the
/// angular momentum in the body's frame more slowly than kSlowTorque (spheres, cubes, tops that
/// spin about their axis).
constexpr double kSlowSpin = 0.02;
constexpr double kSlowTorque = 2e-5;

/// Whether torque-free rotation may change the body's spin.
bool may_tumble(const SolverBody& body, const BodyProps& props) {
  const Vec3& moments = props.principal.moments;
  return !(moments.x() == moments.y() && moments.y() == moments.z()) &&
         dot(body.w, body.w) > kSlowSpin * kSlowSpin && !props.locks.any();
}

/// rad/s at which the angular momentum turns in the body's frame; 0 if negligible.
/// @pre may_tumble()
[[gnu::noinline]] double tumbling(const SolverBody& body, const BodyProps& props) {
  const Vec3 w_l = rotate(body.q.conjugate(), body.w);
  const Mat3& inertia = props.inertia;
  const double x = w_l.x(), y = w_l.y(), z = w_l.z();
  // In the order of Eigen's product.
  const Vec3 momentum_l((inertia(0, 0) * x + inertia(0, 1) * y) + inertia(0, 2) * z,
                        (inertia(1, 0) * x + inertia(1, 1) * y) + inertia(1, 2) * z,
                        inertia(2, 0) * x + (inertia(2, 1) * y + inertia(2, 2) * z));
  const Vec3 torque_l = w_l.cross(momentum_l);
  const double rate2 = dot(torque_l, torque_l) / dot(momentum_l, momentum_l);
  return rate2 > kSlowTorque * kSlowTorque ? std::sqrt(rate2) : 0.0;
}

/// Torque-free rotation over h.
void spin_freely(SolverBody& body, const BodyProps& props, double h) {
  Vec3 w_l = rotate(body.q.conjugate(), body.w);
  body.q = free_rotation(body.q, props.principal, w_l, h);
  body.w = rotate(body.q, w_l);
  body.w_applied = body.w;
}

/// Turns a body by torque-free rotation, and its push velocities with it.
/// @param rate  rad/s, see tumbling()
[[gnu::noinline]] void tumble(SolverBody& body, const BodyProps& props, double rate, double h) {
  spin_freely(body, props, h);
  const Vec3& moments = props.principal.moments;
  body.stale += staleness(rate * h, moments);
  body.reoriented = body.stale > kStale;
  const Vec3 pushed = h * body.w_push;
  body.w_push.setZero();
  if (!pushed.isZero(0.0)) {
    const Quat turn = exp_map(pushed);
    body.q = turned_by(turn, body.q);
    // Spin follows the pose: kept in the world it would have another energy.
    body.w = body.w_applied = rotate(turn, body.w);
  }
  if (!body.reoriented) return;
  refresh_inertia(body, props);
  body.stale = 0.0;
}

/// Whether the inertia depends on the axis.
bool has_axes(const Mat3& inv_inertia) {
  constexpr double kIsotropic = 1e-20;
  const double mean = inv_inertia.trace() / 3.0;
  const double spread = (inv_inertia - mean * Mat3::Identity()).squaredNorm();
  return spread > kIsotropic * mean * mean;
}

}  // namespace

void inverse_inertia_w(const Quat& q, const BodyProps& props, Mat3& result) {
  const std::array<bool, 3>& locked = props.locks.angular;
  if (!locked[0] && !locked[1] && !locked[2]) {
    tensor_to_world(q, props.inverse_inertia, result);
    return;
  }
  if (locked[0] && locked[1] && locked[2]) {
    result.setZero();
    return;
  }
  Mat3 inertia = tensor_to_world(q, props.inertia);
  for (int axis = 0; axis < 3; ++axis) {
    if (!locked[static_cast<std::size_t>(axis)]) continue;
    inertia.row(axis).setZero();
    inertia.col(axis).setZero();
  }
  result = inverse_where_free(inertia);
}

double staleness(double turn, const Vec3& moments) {
  const double most = moments.maxCoeff();
  const double least = moments.minCoeff();
  return most > least ? turn * most / least : 0.0;
}

void refresh_inertia(SolverBody& body, const BodyProps& props) {
  inverse_inertia_w(body.q, props, body.inv_inertia_w);
}

void zero_locked_axes(const std::array<bool, 3>& locked, Vec3& vector) {
  for (int axis = 0; axis < 3; ++axis) {
    if (locked[static_cast<std::size_t>(axis)]) vector[axis] = 0.0;
  }
}

void enforce_locks(SolverBody& body, const AxisLocks& locks) {
  zero_locked_axes(locks.linear, body.v);
  zero_locked_axes(locks.angular, body.w);
}

void restore_locked(SolverBody& body, const AxisLocks& locks, const Vec3& start) {
  for (int axis = 0; axis < 3; ++axis) {
    if (!locks.linear[static_cast<std::size_t>(axis)]) continue;
    body.x[axis] = start[axis];
    body.dx[axis] = 0.0;
  }
}

void integrate_velocity(SolverBody& body, const BodyProps& props, const Wrench* wrench,
                        const Vec3& gravity, double h) {
  body.dx.setZero();
  body.dtheta.setZero();
  body.v_applied.setZero();
  body.w_applied.setZero();
  body.reoriented = false;
  body.v += h * props.gravity_scale * gravity;
  if (wrench != nullptr) {
    body.v += h * body.inv_mass * wrench->force;
    body.w += h * (body.inv_inertia_w * wrench->torque);
  }
  if (props.linear_damping > 0.0) body.v *= portable::exp(-props.linear_damping * h);
  if (props.angular_damping > 0.0) body.w *= portable::exp(-props.angular_damping * h);
  if (body.projected && may_tumble(body, props) && tumbling(body, props) > 0.0)
    spin_freely(body, props, h);
  if (props.locks.any()) enforce_locks(body, props.locks);
}

void follow_velocity(SolverBody& body, double h) {
  body.x += h * (body.v - body.v_applied);
  body.v_applied = body.v;
  const Vec3 turn = h * (body.w - body.w_applied);
  body.w_applied = body.w;
  if (!turn.isZero(0.0)) body.q = rotated_about(body.q, turn);
}

[[gnu::flatten]] void advance_pose(SolverBody& body, const BodyProps& props, double h) {
  body.x += h * (body.v - body.v_applied + body.v_push);
  body.v_applied = body.v;
  body.v_push.setZero();
  const double rate = !body.projected && may_tumble(body, props) ? tumbling(body, props) : 0.0;
  if (rate > 0.0) return tumble(body, props, rate, h);
  const Vec3 turn = h * body.w_push + h * (body.w - body.w_applied);
  body.w_applied = body.w;
  body.w_push.setZero();
  if (!turn.isZero(0.0)) body.q = rotated_about(body.q, turn);
}

void absorb_corrections(SolverBody& body, const BodyProps& props, double h) {
  const double inverse_h = 1.0 / h;
  const Vec3 dv = inverse_h * body.dx;
  const Vec3 open = body.w - body.w_applied;  // 0 if the prediction has used all of it
  body.v += dv;
  body.v_applied += dv;
  body.w += inverse_h * body.dtheta;
  if (!body.dtheta.isZero(0.0) && !props.locks.any() && has_axes(body.inv_inertia_w)) {
    const Mat3 axes = body.q.toRotationMatrix();
    Mat3 inertia_w = body.inv_inertia_w;
    block::invert(inertia_w);
    const Vec3 momentum = block::times(inertia_w, body.w);
    const Vec3 spin_l = block::times(props.inverse_inertia, axes.transpose() * momentum);
    body.w = block::times(axes, spin_l);
  }
  body.w_applied = body.w - open;
  body.dx.setZero();
  body.dtheta.setZero();
}

}  // namespace tandem::pbd
