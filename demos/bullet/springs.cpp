// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "bullet/springs.h"

namespace tandem::demos {

namespace {

using pbd::Mat3;
using pbd::Vec3;

/// Sweeps over the springs of a body.
constexpr int kSweeps = 8;
/// Weight of the last step's acceleration: an impact does not repeat in the next step.
constexpr double kLearning = 0.3;

Mat3 cross_matrix(const Vec3& v) {
  Mat3 m;
  m << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return m;
}

}  // namespace

void SpringPulls::pull(std::span<const pbd::Tether::Def> springs, const pbd::BodyProps& props,
                       double dt, pbd::BodyState& state) {
  const Mat3 turn = state.pose.orientation.toRotationMatrix();
  const Mat3 inverse_inertia = turn * props.inverse_inertia * turn.transpose();
  // Velocity at the end of the step without springs.
  pbd::Twist end{state.twist.linear + dt * others_.linear,
                 state.twist.angular + dt * others_.angular};
  const auto push = [&](const Vec3& r, const Vec3& impulse) {
    const pbd::Twist change{props.inverse_mass * impulse, inverse_inertia * r.cross(impulse)};
    for (pbd::Twist* twist : {&state.twist, &end}) {
      twist->linear += change.linear;
      twist->angular += change.angular;
    }
  };
  impulses_.assign(springs.size(), Vec3::Zero());
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    for (std::size_t i = 0; i < springs.size(); ++i) {
      const pbd::Tether::Def& spring = springs[i];
      const Vec3 r = turn * spring.anchor_l;
      push(r, -impulses_[i]);
      // f = k (e + dt (u - v)) + c (u - v) with the anchor's velocity u and the point's v = v0 + dt
      // W f, W its mobility: (1 + (k dt + c) dt W) f = k e + (k dt + c) (u - v0).
      const Mat3 arm = cross_matrix(r);
      const Mat3 mobility = props.inverse_mass * Mat3::Identity() - arm * inverse_inertia * arm;
      const Vec3 stretch = spring.anchor_w - (state.pose.position + r);
      const Vec3 closing = spring.anchor_velocity - (end.linear + end.angular.cross(r));
      const double gain = spring.stiffness * dt + spring.damping;
      const Mat3 system = Mat3::Identity() + gain * dt * mobility;
      Vec3 force = system.inverse() * (spring.stiffness * stretch + gain * closing);
      const double strength = force.norm();
      if (strength > spring.max_force) force *= spring.max_force / strength;
      impulses_[i] = dt * force;
      push(r, impulses_[i]);
    }
  }
}

void SpringPulls::learn(const pbd::Twist& before, const pbd::Twist& after, double dt) {
  others_.linear += kLearning * ((after.linear - before.linear) / dt - others_.linear);
  others_.angular += kLearning * ((after.angular - before.angular) / dt - others_.angular);
}

}  // namespace tandem::demos
