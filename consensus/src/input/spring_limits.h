// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>

#include "tandem/consensus/robust.h"
#include "tandem/pbd/tether.h"
#include "tandem/pbd/world.h"

namespace tandem::consensus {

/// How strong some springs are together, or what is left of it.
struct SpringStrength {
  double force = 0.0;
  double stiffness = 0.0;
  double damping = 0.0;

  void add(const pbd::Tether::Def& def) {
    force += def.max_force;
    stiffness += def.stiffness;
    damping += def.damping;
  }
};

/// What RobustOptions leave of users' springs.
class SpringLimits {
 public:
  SpringLimits(const pbd::World& world, const RobustOptions& most) : world_(world), most_(most) {}

  /// Cut a spring by itself. @return whether anything was
  bool limit(pbd::Tether::Def& def) const {
    const double mass = mass_of(def.body);
    const pbd::Tether::Def asked = def;
    const double speed = def.anchor_velocity.norm();
    if (speed > most_.max_hand_speed) def.anchor_velocity *= most_.max_hand_speed / speed;
    def.stiffness = std::min(def.stiffness, most_.max_stiffness * mass);
    def.damping = std::min(def.damping, most_.max_damping * mass);
    def.max_force = std::min(def.max_force, most_.max_pull * mass);
    // A force that is never reached is no limit worth telling of.
    return speed > most_.max_hand_speed || def.stiffness < asked.stiffness ||
           def.damping < asked.damping;
  }
  bool too_far(const pbd::Tether::Def& def) const {
    const pbd::Pose& pose = world_.pose(def.body);
    const pbd::Vec3 held = pose.position + pose.orientation * def.anchor_l;
    return !((def.anchor_w - held).squaredNorm() <= most_.max_reach * most_.max_reach);
  }
  /// What is left of each where one user has all of these on one body, as they are limited each by
  /// itself.
  SpringStrength share_of(pbd::BodyId body, const SpringStrength& sum) const {
    const double mass = mass_of(body);
    const auto part = [mass](double limit, double asked) {
      return asked > limit * mass ? limit * mass / asked : 1.0;
    };
    return {.force = part(most_.max_pull, sum.force),
            .stiffness = part(most_.max_stiffness, sum.stiffness),
            .damping = part(most_.max_damping, sum.damping)};
  }
  static void apply(const SpringStrength& share, pbd::Tether::Def& def) {
    def.max_force *= share.force;
    def.stiffness = std::max(def.stiffness * share.stiffness, pbd::Tether::kMinStiffness);
    def.damping *= share.damping;
  }

 private:
  /// What is light is as a rule part of something that is not.
  double mass_of(pbd::BodyId body) const { return std::max(world_.props(body).mass, 1.0); }

  const pbd::World& world_;
  const RobustOptions& most_;
};

}  // namespace tandem::consensus
