// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "session/virtual_coupling.h"

#include <cmath>
#include <numbers>

#include "tandem/pbd/math.h"
#include "tandem/pbd/solver.h"
#include "tandem/pbd/validate.h"

namespace tandem::demos {
namespace {

using pbd::Vec3;

// As the solver's own targets have them, which let a body sleep.
constexpr double kNear = 1e-3;      // m
constexpr double kTurned = 0.0175;  // rad
constexpr double kSlow = 0.01;      // m/s
constexpr double kSlowSpin = 0.02;  // rad/s
constexpr double kRestAfter = 0.5;  // s

Vec3 rotation_to(const pbd::World& world, const pbd::PoseTarget& target) {
  if (target.use_rotation_error) return target.rotation_error;
  return pbd::rotation_between(world.pose(target.body).orientation, target.pose.orientation);
}

bool agrees(const pbd::World& world, const pbd::PoseTarget& target) {
  const Vec3 apart = target.pose.position - world.pose(target.body).position;
  return apart.norm() <= kNear && rotation_to(world, target).norm() <= kTurned;
}

bool slow(const pbd::Twist& twist) {
  return twist.linear.norm() < kSlow && twist.angular.norm() < kSlowSpin;
}

/// e'' = -(w^2 e + 2 z w e') with all three at the end of the step.
/// @param gap  m or rad     @param closing  its rate     @return acceleration, no longer than most
Vec3 pull_of(const Vec3& gap, const Vec3& closing, double dt, double most,
             const VirtualCouplingOptions& options) {
  const double w = 2.0 * std::numbers::pi * options.frequency;
  const double stiffness = w * w;                          // 1/s^2
  const double damping = 2.0 * options.damping_ratio * w;  // 1/s
  const Vec3 pull = (stiffness * (gap + dt * closing) + damping * closing) /
                    (1.0 + dt * damping + dt * dt * stiffness);
  const double strength = pull.norm();
  return strength > most ? Vec3(most / strength * pull) : pull;
}

}  // namespace

void VirtualCouplingOptions::validate() const {
  const auto check = [](bool good, const char* field, double value, const char* rule) {
    pbd::detail::require(good, "VirtualCouplingOptions", field, value, rule);
  };
  check(frequency > 0.0 && frequency <= 100.0, "frequency", frequency, "above 0 to 100 Hz");
  check(damping_ratio >= 0.0 && damping_ratio <= 100.0, "damping_ratio", damping_ratio, "0 to 100");
  check(max_acceleration > 0.0 && std::isfinite(max_acceleration), "max_acceleration",
        max_acceleration, "finite and > 0 m/s^2");
  check(max_angular_acceleration > 0.0 && std::isfinite(max_angular_acceleration),
        "max_angular_acceleration", max_angular_acceleration, "finite and > 0 rad/s^2");
}

VirtualCoupling::VirtualCoupling(pbd::World& world, consensus::Peer& peer,
                                 const VirtualCouplingOptions& options)
    : world_(world), peer_(peer), options_(options) {
  options.validate();
  world.set_target_source(nullptr);
}

void VirtualCoupling::pull(consensus::SessionTime now) {
  const double dt = last_ != 0 ? 1e-9 * static_cast<double>(now - last_) : 1.0 / 60.0;  // s
  last_ = now;
  targets_.clear();
  peer_.collect(world_, dt, {}, targets_);
  still_.resize(world_.slot_count(), 0.0);
  for (const pbd::PoseTarget& target : targets_) {
    if (rests(target, dt)) continue;
    // What sleeps and agrees is no reason to wake.
    if (!world_.awake(target.body) && agrees(world_, target)) continue;
    if (target.share >= 1.0) {
      follow(target);
    } else {
      pull_towards(target, dt);
    }
  }
}

void VirtualCoupling::follow(const pbd::PoseTarget& target) {
  const pbd::BodyState own = world_.state(target.body);
  const Vec3 way = target.pose.position - own.pose.position;
  const Vec3 turn = rotation_to(world_, target);
  const pbd::Twist kick{target.twist.linear - own.twist.linear,
                        target.twist.angular - own.twist.angular};
  // Setting anything wakes: what is where it should be may go to sleep.
  if (!way.isZero(0.0) || !turn.isZero(0.0)) {
    world_.set_pose(target.body,
                    {own.pose.position + way, pbd::rotated(own.pose.orientation, turn)});
  }
  if (!kick.linear.isZero(0.0) || !kick.angular.isZero(0.0)) {
    world_.set_twist(target.body,
                     {own.twist.linear + kick.linear, own.twist.angular + kick.angular});
  }
}

bool VirtualCoupling::rests(const pbd::PoseTarget& target, double dt) {
  double& still = still_[target.body.index];
  const bool calm = agrees(world_, target) && slow(world_.twist(target.body)) && slow(target.twist);
  still = calm ? still + dt : 0.0;
  return still >= kRestAfter;
}

void VirtualCoupling::pull_towards(const pbd::PoseTarget& target, double dt) {
  const pbd::BodyProps& props = world_.props(target.body);
  if (props.type != pbd::BodyType::Dynamic) return;
  const pbd::BodyState own = world_.state(target.body);
  const Vec3 linear =
      pull_of(target.pose.position - own.pose.position, target.twist.linear - own.twist.linear, dt,
              options_.max_acceleration, options_);
  const Vec3 angular = pull_of(pbd::rotation_between(own.pose.orientation, target.pose.orientation),
                               target.twist.angular - own.twist.angular, dt,
                               options_.max_angular_acceleration, options_);
  const pbd::Mat3 turn = own.pose.orientation.toRotationMatrix();
  world_.apply_force(target.body, props.mass * linear);
  world_.apply_torque(target.body, turn * (props.inertia * (turn.transpose() * angular)));
}

}  // namespace tandem::demos
