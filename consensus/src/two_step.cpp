// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "two_step.h"

#include "tandem/consensus/influence.h"
#include "tandem/consensus/policy.h"
#include "tandem/pbd/math.h"

namespace tandem::consensus {

pbd::Correction average_state(pbd::World& world, const pbd::PoseTarget& target, double dt) {
  const SleepLimits limits;
  const pbd::BodyState own = world.state(target.body);
  const double share = share_per_step(target.share, dt);
  pbd::Correction correction;
  const pbd::Vec3 apart = target.pose.position - own.pose.position;
  if (apart.norm() > limits.distance) correction.translation = share * apart;
  if (target.rotation_error.norm() > limits.angle) {
    correction.rotation = share * target.rotation_error;
  }
  const pbd::Vec3 dv = target.twist.linear - own.twist.linear;
  if (dv.norm() > limits.speed) correction.twist.linear = share * dv;
  const pbd::Vec3 dw = target.twist.angular - own.twist.angular;
  if (dw.norm() > limits.angular_speed) correction.twist.angular = share * dw;
  world.set_pose(target.body, {own.pose.position + correction.translation,
                               pbd::rotated(own.pose.orientation, correction.rotation)});
  world.set_twist(target.body, {own.twist.linear + correction.twist.linear,
                                own.twist.angular + correction.twist.angular});
  return correction;
}

}  // namespace tandem::consensus
