// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>

#include "tandem/pbd/export.h"
#include "tandem/scene.h"

namespace tandem {

/// Frame of the chassis: x forward, y left, z up.
struct TANDEM_API CarDef {
  Pose pose{.position = {0.0, 0.0, 0.8}};  ///< pose of the chassis
  Vec3 half_extents{2.0, 0.8, 0.25};       ///< m, each > 0, of the chassis
  double mass = 1200.0;                    ///< kg, > 0, without wheels
  double wheelbase = 2.6;                  ///< m, > 0, between the axles
  double track = 1.5;                      ///< m, > 0, between the wheels of an axle
  double axle_height = -0.4;  ///< m, height of the axles in the frame at rest length of the springs
  double wheel_radius = 0.35;     ///< m, > 0
  double wheel_width = 0.2;       ///< m, > 0
  double wheel_mass = 20.0;       ///< kg, > 0
  double stiffness = 30e3;        ///< N/m, > 0, of each wheel's spring
  double damping = 3e3;           ///< N s/m, >= 0
  double travel = 0.25;           ///< m, > 0, to either side of the springs' rest length
  double friction = 0.9;          ///< of tyres, >= 0, see collision::Material
  double drive_torque = 1600.0;   ///< N m, > 0, sum over all four wheels
  double brake_torque = 8000.0;   ///< N m, > 0, sum over all four wheels
  double top_speed = 40.0;        ///< m/s, > 0: the wheels turn no faster
  double max_steer = 0.6;         ///< rad, 0 to 1.5
  collision::Filter filter = {};  ///< of chassis and wheels; group 0: a new group
};

/// A chassis on four sprung wheels, all of them driven and braked, the front ones steered:
///
///     Car car(scene, {});
///     car.drive({.throttle = 1.0, .steer = 0.1});  // whenever something changes
///     scene.step(dt);
///
/// Five bodies and four pbd::WheelJointDef in the scene's joints; these and tyre friction do
/// everything. Build other vehicles from the same joints.
/// Errors: std::invalid_argument naming field, value and rule; the scene is then unchanged.
/// @par Thread safety  As its scene.
class TANDEM_API Car {
 public:
  struct TANDEM_API Controls {
    double throttle = 0.0;  ///< -1 (reverse) to 1
    double steer = 0.0;     ///< rad, to the left, of a virtual wheel between the front ones
    double brake = 0.0;     ///< 0 to 1; above 0 the drive is off
  };

  /// Adds bodies and joints to the scene, which must outlive the car and stay in place. They stay
  /// there until they are removed; the car is then invalid.
  Car(Scene& scene, const CarDef& def);

  /// Sets the controls until the next call. The front wheels are steered so that all four roll
  /// about one point, wheelbase / tan(steer) beside the rear axle (Ackermann).
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
