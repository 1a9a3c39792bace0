// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "couple/two_step.h"

#include "common/body_state.h"
#include "tandem/consensus/influence.h"
#include "tandem/pbd/math.h"

namespace tandem::consensus {
namespace {

/// Differences that are ignored.
struct Limits {
  double distance = 0.0;       ///< m
  double angle = 0.0;          ///< rad
  double speed = 0.0;          ///< m/s
  double angular_speed = 0.0;  ///< rad/s
};
/// [friston] Sec. 4.6.
constexpr Limits kThresholds{
    .distance = 1e-3, .angle = 0.017453292519943295, .speed = 1e-2, .angular_speed = 1e-2};
/// The solver's own limits for targets of sleeping bodies.
constexpr Limits kAgrees{.distance = 1e-3, .angle = 0.0175};
constexpr double kRestAfter = 0.5;  // s

pbd::Vec3 rotation_to(const pbd::World& world, const pbd::PoseTarget& target) {
  if (target.use_rotation_error) return target.rotation_error;
  return pbd::rotation_between(world.pose(target.body).orientation, target.pose.orientation);
}

bool within(const pbd::World& world, const pbd::PoseTarget& target, const Limits& limits) {
  const pbd::Vec3 apart = target.pose.position - world.pose(target.body).position;
  return apart.norm() <= limits.distance && rotation_to(world, target).norm() <= limits.angle;
}

}  // namespace

bool rests(const pbd::World& world, const pbd::PoseTarget& target, double dt, double& still) {
  const bool slow = is_slow(world.twist(target.body)) && is_slow(target.twist);
  still = slow && within(world, target, kAgrees) ? still + dt : 0.0;
  return still >= kRestAfter;
}

pbd::Correction average_state(pbd::World& world, const pbd::PoseTarget& target, double dt,
                              bool thresholds) {
  // A sleeping body that agrees is not woken, as with the solver's own targets.
  if (!world.awake(target.body) && within(world, target, kAgrees)) return {};
  const double share = share_per_step(target.share, dt);  // of each difference
  const Limits limits = thresholds && share < 1.0 ? kThresholds : Limits{};
  const pbd::BodyState own = world.state(target.body);
  const auto part = [share](const pbd::Vec3& gap, double limit) {
    return gap.norm() > limit ? pbd::Vec3(share * gap) : pbd::Vec3(pbd::Vec3::Zero());
  };
  pbd::Correction correction;
  correction.translation = part(target.pose.position - own.pose.position, limits.distance);
  correction.rotation = part(rotation_to(world, target), limits.angle);
  correction.twist.linear = part(target.twist.linear - own.twist.linear, limits.speed);
  correction.twist.angular = part(target.twist.angular - own.twist.angular, limits.angular_speed);
  // Setting a state wakes the body: one that needs no correction may fall asleep.
  if (!correction.translation.isZero(0.0) || !correction.rotation.isZero(0.0)) {
    world.set_pose(target.body, {own.pose.position + correction.translation,
                                 pbd::rotated(own.pose.orientation, correction.rotation)});
  }
  if (!correction.twist.linear.isZero(0.0) || !correction.twist.angular.isZero(0.0)) {
    world.set_twist(target.body, {own.twist.linear + correction.twist.linear,
                                  own.twist.angular + correction.twist.angular});
  }
  return correction;
}

}  // namespace tandem::consensus
