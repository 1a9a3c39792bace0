// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>

#include "tandem/pbd/export.h"
#include "tandem/scene.h"

namespace tandem {

/// Its frame is that of the chassis: x forward, y left, z up.
struct TANDEM_API CarDef {
  Pose pose{.position = {0.0, 0.0, 0.8}};  ///< of the chassis
  Vec3 half_extents{2.0, 0.8, 0.25};       ///< m, each > 0, of the chassis
  double mass = 1200.0;                    ///< kg, > 0, without wheels
  double wheelbase = 2.6;                  ///< m, > 0, between the axles
  double track = 1.5;                      ///< m, > 0, between the wheels of an axle
  double axle_height = -0.4;               ///< m, of the axles in the frame, springs at ease
  double wheel_radius = 0.35;              ///< m, > 0
  double wheel_width = 0.2;                ///< m, > 0
  double wheel_mass = 20.0;                ///< kg, > 0
  double stiffness = 30e3;                 ///< N/m, > 0, of each wheel's spring
  double damping = 3e3;                    ///< N s/m, >= 0
  double travel = 0.25;                    ///< m, > 0, to either side of where springs are at ease
  double friction = 0.9;                   ///< of tyres, >= 0, see collision::Material
  double drive_torque = 1600.0;            ///< N m, > 0, of all four wheels
  double brake_torque = 8000.0;            ///< N m, > 0, likewise
  double top_speed = 40.0;                 ///< m/s, > 0: the wheels turn no faster
  double max_steer = 0.6;                  ///< rad, 0 to 1.5
  collision::Filter filter = {};           ///< of chassis and wheels; a group of its own where 0
};

/// A chassis on four wheels with springs, all of them driven and braked, the two in front steered:
///
///     Car car(scene, {});
///     car.drive({.throttle = 1.0, .steer = 0.1});  // whenever something changes
///     scene.step(dt);
///
/// Five bodies and four pbd::WheelJointDef in the scene's joints; what it does is done by those and
/// by the friction of the tyres. Who wants another vehicle makes one of the same joints.
/// Errors: std::invalid_argument naming field, value and rule; the scene is then as it was.
/// @par Thread safety  As its scene.
class TANDEM_API Car {
 public:
  struct TANDEM_API Controls {
    double throttle = 0.0;  ///< -1, back, to 1
    double steer = 0.0;     ///< rad, to the left, of a wheel between those in front
    double brake = 0.0;     ///< 0 to 1; above 0 nothing drives
  };

  /// Adds bodies and joints to the scene, which outlives it and stays where it is. They stay there
  /// until they are removed; the car is then dead.
  Car(Scene& scene, const CarDef& def);

  /// Until it is called again. The wheels in front stand so that all four roll about one point,
  /// wheelbase / tan(steer) beside the rear axle (Ackermann).
  void drive(const Controls& controls);

  BodyId chassis() const { return chassis_; }
  /// Front left, front right, rear left, rear right.
  const std::array<BodyId, 4>& wheels() const { return wheels_; }
  const std::array<pbd::JointId, 4>& joints() const { return joints_; }
  double speed() const;  ///< m/s, forward

 private:
  Vec3 hub(int wheel) const;

  Scene* scene_;
  CarDef def_;
  BodyId chassis_;
  std::array<BodyId, 4> wheels_;
  std::array<pbd::JointId, 4> joints_;
  std::array<pbd::WheelJointDef, 4> defs_;
};

}  // namespace tandem
