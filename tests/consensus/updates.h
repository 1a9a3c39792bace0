// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "consensus/random.h"
#include "tandem/consensus/update.h"

namespace tandem::consensus::testing {

/// A state that no rule refuses, all fields different from their defaults.
inline StateUpdate some_state(Dice& dice) {
  StateUpdate update;
  update.id = {dice.bits() | 1, dice.bits()};
  update.pose.position = dice.vec3(1e3);
  update.pose.orientation = dice.rotation(3.0);
  update.twist.linear = dice.vec3(50.0);
  update.twist.angular = dice.vec3(50.0);
  update.influence = static_cast<float>(dice.uniform(0.0, 1.0));
  update.stamp = static_cast<SessionTime>(dice.bits() >> 8);
  const std::uint64_t bits = dice.bits();
  update.flags = {(bits & 1) != 0, (bits & 2) != 0,  (bits & 4) != 0,
                  (bits & 8) != 0, (bits & 16) != 0, (bits & 32) != 0};
  return update;
}

inline SpringUpdate some_spring(Dice& dice) {
  SpringUpdate update;
  update.spring = static_cast<std::uint32_t>(dice.bits());
  update.revision = static_cast<std::uint32_t>(dice.bits());
  update.event = static_cast<SpringEvent>(1 + dice.below(3));
  update.body = {dice.bits(), dice.bits() | 1};
  update.attachment_l = dice.vec3(1.0);
  update.anchor_w = dice.vec3(1e3);
  update.anchor_velocity = dice.vec3(10.0);
  update.stiffness = dice.uniform(0.0, 1e5);
  update.damping = dice.uniform(0.0, 1e3);
  update.max_force = dice.uniform(0.0, 1e4);
  update.stamp = static_cast<SessionTime>(dice.bits() >> 8);
  return update;
}

inline ActUpdate some_act(Dice& dice) {
  ActUpdate update;
  update.number = static_cast<std::uint32_t>(dice.bits());
  update.body = {dice.bits(), dice.bits() | 1};
  update.name = dice.bits();
  update.impulse = dice.vec3(1e3);
  update.angular_impulse = dice.vec3(1e3);
  if (dice.below(2) == 0) update.pose = pbd::Pose{dice.vec3(1e3), dice.rotation(3.0)};
  if (dice.below(2) == 0) update.twist = pbd::Twist{dice.vec3(50.0), dice.vec3(50.0)};
  update.stamp = static_cast<SessionTime>(dice.bits() >> 8);
  return update;
}

}  // namespace tandem::consensus::testing
