// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <cmath>

#include "tandem/consensus/robust.h"
#include "tandem/pbd/tether.h"
#include "tandem/pbd/world.h"

namespace tandem::consensus {

/// Sum of the strengths of some springs, or the fractions left of it.
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

/// Limits on users' springs, own ones included: all peers must simulate the same.
class SpringLimits {
 public:
  // The first three apply to each spring, and to the sum of one user's springs on one body.
  static constexpr double kMaxPull = 1000.0;      ///< m/s^2: force over the mass of the body
  static constexpr double kMaxStiffness = 1e5;    ///< 1/s^2: stiffness over the mass of the body
  static constexpr double kMaxDamping = 2000.0;   ///< 1/s: damping over the mass of the body
  static constexpr double kMaxHandSpeed = 100.0;  ///< m/s, of remote hands

  SpringLimits(const pbd::World& world, const RobustOptions& options)
      : world_(world), options_(options) {}

  /// Limit one spring. @return whether it was changed
  bool limit(pbd::Tether::Def& def) const {
    const double mass = mass_of(def.body);
    const pbd::Tether::Def asked = def;
    const double speed = def.anchor_velocity.norm();
    if (speed > kMaxHandSpeed) def.anchor_velocity *= kMaxHandSpeed / speed;
    def.stiffness = std::min(def.stiffness, kMaxStiffness * mass);
    def.damping = std::min(def.damping, kMaxDamping * mass);
    def.max_force = std::min(def.max_force, kMaxPull * mass);
    // A cut of max_force alone is not reported: the force may never be so large.
    return speed > kMaxHandSpeed || def.stiffness < asked.stiffness || def.damping < asked.damping;
  }
  bool too_far(const pbd::Tether::Def& def) const {
    const pbd::Pose& pose = world_.pose(def.body);
    const pbd::Vec3 held = pose.position + pose.orientation * def.anchor_l;
    return !((def.anchor_w - held).squaredNorm() <= options_.max_reach * options_.max_reach);
  }
  /// Limit the force so that a step of `dt` s makes the body no faster than allowed, or than it is;
  /// the spring is one of `count` of its user on the body. A limit on the force alone is not
  /// enough: 1 kN on 1 kg for 0.5 s give 330 m/s.
  /// @param world  the world with the body, here or in a replay
  void slow(const pbd::World& world, double dt, int count, pbd::Tether::Def& def) const {
    const pbd::BodyState& state = world.state(def.body);
    const pbd::Vec3 arm = state.pose.orientation * def.anchor_l;
    const pbd::Vec3 v = state.twist.linear + state.twist.angular.cross(arm);
    const pbd::Vec3 pull = def.stiffness * (def.anchor_w - state.pose.position - arm) +
                           def.damping * (def.anchor_velocity - v);
    const double strength = pull.norm();
    if (!(strength > 0.0)) return;
    const double along = v.dot(pull) / strength;
    const double most = options_.max_pull_speed;
    // With it |v + more pull / strength| is `most`, or |v| if that is larger.
    const double more =
        std::sqrt(along * along + std::max(0.0, most * most - v.squaredNorm())) - along;
    constexpr double kNone = 1e-9;      // N: a tether's force must be above 0
    constexpr double kShortest = 1e-3;  // s
    const double force = mass_of(def.body) * more / (std::max(1, count) * std::max(dt, kShortest));
    def.max_force = std::max(kNone, std::min(def.max_force, force));
  }
  /// The fractions left for each of one user's springs on a body. `sum` is over springs that were
  /// limited one by one.
  SpringStrength share_of(pbd::BodyId body, const SpringStrength& sum) const {
    const double mass = mass_of(body);
    const auto part = [mass](double limit, double asked) {
      return asked > limit * mass ? limit * mass / asked : 1.0;
    };
    return {.force = part(kMaxPull, sum.force),
            .stiffness = part(kMaxStiffness, sum.stiffness),
            .damping = part(kMaxDamping, sum.damping)};
  }
  static void apply(const SpringStrength& share, pbd::Tether::Def& def) {
    def.max_force *= share.force;
    def.stiffness = std::max(def.stiffness * share.stiffness, pbd::Tether::kMinStiffness);
    def.damping *= share.damping;
  }

 private:
  /// At least 1 kg: a light body is usually part of a heavier one.
  double mass_of(pbd::BodyId body) const { return std::max(world_.props(body).mass, 1.0); }

  const pbd::World& world_;
  const RobustOptions& options_;
};

}  // namespace tandem::consensus
