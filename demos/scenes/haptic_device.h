// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <optional>

#include "tandem/pbd/types.h"

namespace tandem::demos {

/// A small desktop device with a pen, and the hand that holds it.
struct HapticOptions {
  double rate = 1000.0;            ///< Hz, of the device's own loop
  double mass = 0.1;               ///< kg, of the pen as felt, with the fingers
  double friction = 0.2;           ///< N s/m, of the device
  double force_limit = 3.3;        ///< N, of the motors
  double coupling_stiffness = 80;  ///< N/m, between pen and proxy
  double coupling_damping = 2.0;   ///< N s/m
  double hand_stiffness = 250.0;   ///< N/m, of the hand about its intended position
  double hand_damping = 6.0;       ///< N s/m
  double hand_limit = 10.0;        ///< N
  bool controller = true;          ///< passivity controller; false: observer only
};

struct HapticPoint {
  pbd::Vec3 position = pbd::Vec3::Zero();  ///< m
  pbd::Vec3 velocity = pbd::Vec3::Zero();  ///< m/s
};

/// A simulated haptic device with its own loop. A virtual coupling (spring and damper) pulls the
/// pen to the proxy, a point of the simulation, within the motors' force limit; the simulation sees
/// the pen as the spring's other end. Between frames the proxy moves on at its velocity.
///
/// The passivity observer sums the energy that flows from hand and pen into the coupling, from 0,
/// since the coupling closes without stretch. If the sum would become negative, the passivity
/// controller [hannaford2002] adds just enough damping, within the motors' limit and the stability
/// limit of a cycle: remote users of a shared body cannot shake the hand.
class HapticDevice {
 public:
  HapticDevice(const HapticOptions& options, const pbd::Vec3& position);

  /// Continues the loop. @param seconds  to run
  /// @param meant  m, the hand's intended position at the end; it moves there uniformly
  /// @param proxy  as at the last call's time; none if nothing is grasped
  void run(double seconds, const pbd::Vec3& meant, const std::optional<HapticPoint>& proxy);

  const HapticPoint& pen() const { return pen_; }
  double force() const { return force_; }                  ///< N, of the motors, in the last cycle
  double largest_force() const { return largest_force_; }  ///< N, of the motors
  double largest_wanted() const { return largest_wanted_; }  ///< N, requested by the coupling
  double energy() const { return energy_; }                  ///< J, of the observer
  double least_energy() const { return least_energy_; }      ///< J
  double taken_out() const { return taken_out_; }            ///< J, removed by the controller
  double fastest() const { return fastest_; }                ///< m/s

 private:
  HapticOptions options_;
  HapticPoint pen_;
  pbd::Vec3 meant_;
  /// m/s, of the pen after a cycle with these forces (N).
  pbd::Vec3 next_velocity(const pbd::Vec3& hand, const pbd::Vec3& motors) const;
  /// N, of the motors, limited so that the observer does not fall below 0.
  pbd::Vec3 controlled(const pbd::Vec3& hand, const pbd::Vec3& motors);
  double debt_ = 0.0;  ///< s still to run
  double force_ = 0.0, largest_force_ = 0.0, largest_wanted_ = 0.0;
  double energy_ = 0.0, least_energy_ = 0.0, most_energy_ = 0.0, taken_out_ = 0.0, fastest_ = 0.0;
};

}  // namespace tandem::demos
