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
  double hand_stiffness = 250.0;   ///< N/m, of the hand about where it means to be
  double hand_damping = 6.0;       ///< N s/m
  double hand_limit = 10.0;        ///< N
  bool controller = true;          ///< of passivity; false: it is observed only
};

/// Where something is and how it moves.
struct HapticPoint {
  pbd::Vec3 position = pbd::Vec3::Zero();  ///< m
  pbd::Vec3 velocity = pbd::Vec3::Zero();  ///< m/s
};

/// A simulated haptic device with a loop of its own. A virtual coupling (spring and damper) pulls
/// the pen to the proxy, a point of the simulation, with no more force than the motors have; the
/// simulation sees the pen as the other end of the same spring. Between two of its frames the proxy
/// is carried on by its velocity.
///
/// The passivity observer adds up the energy that flows from the hand and the pen into the coupling
/// and what is behind it: passive as long as that never falls below minus what was stored at the
/// start, which is nothing, since the coupling closes at zero stretch. Where it would, the
/// passivity controller [hannaford2002] adds just the damping that takes the missing energy out
/// again, within what the motors have and what a cycle of the loop bears: what others do to a
/// shared body a long way off cannot shake the hand.
class HapticDevice {
 public:
  HapticDevice(const HapticOptions& options, const pbd::Vec3& position);

  /// The loop from the last time on. @param seconds  to run
  /// @param meant  m, where the hand means to be at the end; it gets there evenly
  /// @param proxy  as it was when the time began; none where nothing is grasped
  void run(double seconds, const pbd::Vec3& meant, const std::optional<HapticPoint>& proxy);

  const HapticPoint& pen() const { return pen_; }
  double force() const { return force_; }                  ///< N, of the motors, in the last cycle
  double largest_force() const { return largest_force_; }  ///< N, of the motors
  double largest_wanted() const { return largest_wanted_; }  ///< N, what the coupling asked for
  double energy() const { return energy_; }                  ///< J, of the observer
  double least_energy() const { return least_energy_; }      ///< J
  double taken_out() const { return taken_out_; }            ///< J, by the controller
  double fastest() const { return fastest_; }                ///< m/s

 private:
  HapticOptions options_;
  HapticPoint pen_;
  pbd::Vec3 meant_;
  /// m/s, of the pen after a cycle with these forces (N).
  pbd::Vec3 next_velocity(const pbd::Vec3& hand, const pbd::Vec3& motors) const;
  /// N, of the motors so that the observer does not fall below 0.
  pbd::Vec3 controlled(const pbd::Vec3& hand, const pbd::Vec3& motors);
  double debt_ = 0.0;  ///< s that are not run yet
  double force_ = 0.0, largest_force_ = 0.0, largest_wanted_ = 0.0;
  double energy_ = 0.0, least_energy_ = 0.0, most_energy_ = 0.0, taken_out_ = 0.0, fastest_ = 0.0;
};

}  // namespace tandem::demos
