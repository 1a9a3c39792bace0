// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "virtual_coupling.h"

#include <numbers>

#include "tandem/pbd/math.h"
#include "two_step.h"

namespace tandem::consensus {
namespace {

/// e'' = -(w^2 e + 2 z w e') with all three at the end of the step.
/// @param gap  m or rad     @param closing  its rate     @return acceleration, no longer than most
pbd::Vec3 pull_of(const pbd::Vec3& gap, const pbd::Vec3& closing, double dt, double most,
                  const VirtualCouplingOptions& options) {
  const double w = 2.0 * std::numbers::pi * options.frequency;
  const double stiffness = w * w;                          // 1/s^2
  const double damping = 2.0 * options.damping_ratio * w;  // 1/s
  const pbd::Vec3 pull = (stiffness * (gap + dt * closing) + damping * closing) /
                         (1.0 + dt * damping + dt * dt * stiffness);
  const double strength = pull.norm();
  return strength > most ? pbd::Vec3(most / strength * pull) : pull;
}

}  // namespace

void pull_towards(pbd::World& world, const pbd::PoseTarget& target, double dt,
                  const VirtualCouplingOptions& options) {
  const pbd::BodyProps& props = world.props(target.body);
  if (props.type != pbd::BodyType::Dynamic || left_asleep(world, target)) return;
  const pbd::BodyState own = world.state(target.body);
  const pbd::Vec3 linear =
      pull_of(target.pose.position - own.pose.position, target.twist.linear - own.twist.linear, dt,
              options.max_acceleration, options);
  const pbd::Vec3 angular = pull_of(
      pbd::rotation_between(own.pose.orientation, target.pose.orientation),
      target.twist.angular - own.twist.angular, dt, options.max_angular_acceleration, options);
  const pbd::Mat3 turn = own.pose.orientation.toRotationMatrix();
  world.apply_force(target.body, props.mass * linear);
  world.apply_torque(target.body, turn * (props.inertia_l * (turn.transpose() * angular)));
}

}  // namespace tandem::consensus
