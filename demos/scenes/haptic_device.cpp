// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "scenes/haptic_device.h"

#include <algorithm>
#include <cmath>

namespace tandem::demos {

namespace {

pbd::Vec3 cut(const pbd::Vec3& force, double limit) {
  const double norm = force.norm();
  return norm > limit ? pbd::Vec3(limit / norm * force) : force;
}

}  // namespace

HapticDevice::HapticDevice(const HapticOptions& options, const pbd::Vec3& position)
    : options_(options), meant_(position) {
  pen_.position = position;
}

void HapticDevice::run(double seconds, const pbd::Vec3& meant,
                       const std::optional<HapticPoint>& proxy) {
  const HapticOptions& o = options_;
  const double cycle = 1.0 / o.rate;
  debt_ += seconds;
  const auto cycles = static_cast<int>(std::floor(debt_ * o.rate + 1e-9));
  debt_ -= cycles * cycle;
  const pbd::Vec3 from = meant_;
  force_ = 0.0;
  for (int i = 1; i <= cycles; ++i) {
    const double part = static_cast<double>(i) / cycles;
    const pbd::Vec3 hand_at = from + part * (meant - from);
    const pbd::Vec3 hand =
        cut(o.hand_stiffness * (hand_at - pen_.position) - o.hand_damping * pen_.velocity,
            o.hand_limit);
    pbd::Vec3 motors = pbd::Vec3::Zero();
    if (proxy) {
      const pbd::Vec3 there = proxy->position + (i - 1) * cycle * proxy->velocity;
      const pbd::Vec3 wanted = o.coupling_stiffness * (there - pen_.position) +
                               o.coupling_damping * (proxy->velocity - pen_.velocity);
      largest_wanted_ = std::max(largest_wanted_, wanted.norm());
      motors = cut(wanted, o.force_limit);
      if (o.controller) motors = controlled(hand, motors);
    }
    force_ = motors.norm();
    largest_force_ = std::max(largest_force_, force_);
    const pbd::Vec3 before = pen_.velocity;
    pen_.velocity = next_velocity(hand, motors);
    pen_.position += cycle * pen_.velocity;
    energy_ -= cycle * motors.dot(0.5 * (before + pen_.velocity));
    least_energy_ = std::min(least_energy_, energy_);
    most_energy_ = std::max(most_energy_, energy_);
    fastest_ = std::max(fastest_, pen_.velocity.norm());
  }
  meant_ = meant;
}

pbd::Vec3 HapticDevice::next_velocity(const pbd::Vec3& hand, const pbd::Vec3& motors) const {
  return pen_.velocity +
         (hand + motors - options_.friction * pen_.velocity) / (options_.rate * options_.mass);
}

pbd::Vec3 HapticDevice::controlled(const pbd::Vec3& hand, const pbd::Vec3& motors) {
  const double cycle = 1.0 / options_.rate;
  const pbd::Vec3 mean = 0.5 * (pen_.velocity + next_velocity(hand, motors));
  // A pen that hardly moves dissipates nothing: damping begins slightly early, if there was a
  // reserve.
  constexpr double kReserve = 1e-3;  // J
  const double missing =
      cycle * motors.dot(mean) - energy_ + std::min(kReserve, 0.5 * most_energy_);  // J
  const double square = mean.squaredNorm();
  if (missing <= 0.0 || square <= 0.0) return motors;
  // Beyond half of m / cycle the damping alone would reverse the pen.
  const double damping = std::min(missing / (cycle * square), 0.5 * options_.mass / cycle);
  pbd::Vec3 result = cut(motors - damping * mean, options_.force_limit);
  // The motors must not supply energy that damping cannot remove: no force along the motion.
  const double given = cycle * result.dot(mean);
  if (given > energy_) result -= result.dot(mean) / square * mean;
  taken_out_ += cycle * (motors - result).dot(mean);
  return result;
}

}  // namespace tandem::demos
