// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// A translation unit of its own: programs without cars do not link it.
#include "tandem/car.h"

#include <cmath>
#include <numbers>
#include <vector>

#include "add_whole.h"
#include "tandem/pbd/math.h"
#include "tandem/pbd/portable.h"
#include "tandem/pbd/validate.h"

namespace tandem {
namespace {

constexpr int kWheels = 4;

void check(const CarDef& def) {
  constexpr std::string_view kKind = "CarDef";
  const auto above_zero = [&](double value, const char* field) {
    pbd::detail::require(value > 0.0 && std::isfinite(value), kKind, field, value,
                         "finite and > 0");
  };
  above_zero(def.wheelbase, "wheelbase");
  above_zero(def.track, "track");
  above_zero(def.wheel_radius, "wheel_radius");
  above_zero(def.wheel_width, "wheel_width");
  above_zero(def.wheel_mass, "wheel_mass");
  above_zero(def.mass, "mass");
  above_zero(def.half_extents.minCoeff(), "half_extents");
  above_zero(def.stiffness, "stiffness");
  above_zero(def.travel, "travel");
  above_zero(def.drive_torque, "drive_torque");
  above_zero(def.brake_torque, "brake_torque");
  above_zero(def.top_speed, "top_speed");
  pbd::detail::require_finite(Vec3::Constant(def.axle_height), kKind, "axle_height");
  pbd::detail::require(def.damping >= 0.0 && std::isfinite(def.damping), kKind, "damping",
                       def.damping, "finite and >= 0");
  pbd::detail::require(def.friction >= 0.0 && std::isfinite(def.friction), kKind, "friction",
                       def.friction, "finite and >= 0");
  pbd::detail::require(def.max_steer >= 0.0 && def.max_steer <= 1.5, kKind, "max_steer",
                       def.max_steer, "from 0 to 1.5 rad");
}

}  // namespace

Car::Car(Scene& scene, const CarDef& def) : scene_(&scene), def_(def) {
  check(def);
  // Wheels pass through the chassis.
  if (def_.filter.group == 0) def_.filter.group = scene.new_group();
  std::vector<BodyId> parts;
  detail::add_whole(scene, parts, [&] {
    chassis_ = scene.add(Box{def.half_extents},
                         {.mass = def.mass, .pose = def.pose, .filter = def_.filter});
    parts.push_back(chassis_);
    const Quat& upright = def.pose.orientation;
    const Quat across = pbd::exp_map(-0.5 * std::numbers::pi * Vec3::UnitX());  // z becomes y
    for (int i = 0; i < kWheels; ++i) {
      const Vec3 at = def.pose.to_world(hub(i));
      wheels_[i] = scene.add(Cylinder{def.wheel_radius, 0.5 * def.wheel_width},
                             {.mass = def.wheel_mass,
                              .pose = {at, upright * across},
                              .material = {.friction = def.friction},
                              .filter = def_.filter});
      parts.push_back(wheels_[i]);
      defs_[i] = pbd::wheel_joint_at(scene.world(), chassis_, wheels_[i], at,
                                     upright * Vec3::UnitY(), upright * Vec3::UnitZ());
      defs_[i].suspension = {.freedom = pbd::Freedom::Limited,
                             .lower = -def.travel,
                             .upper = def.travel,
                             .spring = {.stiffness = def.stiffness, .damping = def.damping}};
      joints_[i] = scene.add_joint(defs_[i]);
    }
  });
}

/// m, place of the wheel in the frame of the chassis at rest length of the springs.
Vec3 Car::hub(int wheel) const {
  return {(wheel < 2 ? 0.5 : -0.5) * def_.wheelbase, (wheel % 2 == 0 ? 0.5 : -0.5) * def_.track,
          def_.axle_height};
}

void Car::drive(const Controls& controls) {
  constexpr std::string_view kKind = "Car::Controls";
  pbd::detail::require(std::abs(controls.throttle) <= 1.0, kKind, "throttle", controls.throttle,
                       "from -1 to 1");
  pbd::detail::require(std::abs(controls.steer) <= def_.max_steer, kKind, "steer", controls.steer,
                       "from -max_steer to max_steer");
  pbd::detail::require(controls.brake >= 0.0 && controls.brake <= 1.0, kKind, "brake",
                       controls.brake, "from 0 to 1");
  const auto [sine, cosine] = pbd::portable::sin_cos(controls.steer);
  for (int i = 0; i < kWheels; ++i) {
    pbd::WheelJointDef& def = defs_[i];
    if (i < 2) {
      def.steer =
          pbd::portable::atan2(def_.wheelbase * sine, def_.wheelbase * cosine - hub(i).y() * sine);
    }
    def.brake = controls.brake * def_.brake_torque / kWheels;
    def.drive = {};
    if (controls.throttle != 0.0) {
      def.drive = {.mode = pbd::MotorMode::Velocity,
                   .target = std::copysign(def_.top_speed / def_.wheel_radius, controls.throttle),
                   .max_force = std::abs(controls.throttle) * def_.drive_torque / kWheels};
    }
    scene_->joints().set(scene_->world(), joints_[i], def);
  }
}

double Car::speed() const {
  const pbd::BodyState& state = scene_->world().state(chassis_);
  return state.twist.linear.dot(state.pose.orientation * Vec3::UnitX());
}

}  // namespace tandem
