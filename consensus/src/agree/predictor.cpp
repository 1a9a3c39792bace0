// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/consensus/predictor.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/body_state.h"
#include "common/session_time.h"
#include "tandem/pbd/math.h"
#include "tandem/pbd/portable.h"
#include "tandem/pbd/validate.h"

namespace tandem::consensus {

using pbd::detail::require;

namespace {

using pbd::Vec3;

/// s: low-pass on measured accelerations and their frequency. At three times as much a steady
/// acceleration is found too late (tests/consensus/extrapolation_test.cpp).
constexpr double kAccelerationFilter = 0.05;
constexpr double kUnknownFrequency = 100.0;  // Hz, if there was no acceleration before
/// Hz: measured accelerations that change faster are ignored, those at half of it count fully.
/// Tennis at profile 5 (seeds 11 to 18): 12.8 hits of a player in 12 s, and 11.6 if all count
/// fully; room has 20 mm there (all p95) in place of 24, and 26 if none counts.
constexpr double kMaxFrequency = 4.0;

/// Not touched, joined or held at the stamp.
bool is_free(const StateUpdate& update) {
  return !update.flags.in_contact && !update.flags.held && !update.flags.owner_driven;
}

/// The correction to an extrapolated state.
Prediction to_state(const StateUpdate& update, const MotionSample& own, const Vec3& position,
                    const pbd::Twist& twist, double age) {
  const pbd::Quat there = pbd::rotated(update.pose.orientation, age * update.twist.angular);
  const bool by_hand = update.flags.owner_driven;
  return {gap({own.pose, own.twist}, {{position, there}, twist}),
          by_hand ? pbd::TargetMotion::Inertial : pbd::TargetMotion::WithBody};
}

/// Extrapolates a state by itself.
class Extrapolator final : public Predictor {
 public:
  Extrapolator(PredictorKind kind, const PredictorOptions& options)
      : kind_(kind), options_(options) {}

  Prediction predict(const StateUpdate& update, const MotionHistory& own,
                     const PredictionContext& context) const override {
    const double age = std::min(seconds(context.now - update.stamp), options_.max_extrapolation);
    if (kind_ == PredictorKind::None) {
      return to_state(update, own.newest(), update.pose.position, update.twist, 0.0);
    }
    Vec3 position = update.pose.position + age * update.twist.linear;
    pbd::Twist twist = update.twist;
    if (kind_ == PredictorKind::Replay) {
      const Vec3 acceleration = acceleration_of(update, context);
      position += 0.5 * age * age * acceleration;
      twist.linear += age * acceleration;
    }
    return to_state(update, own.newest(), position, twist,
                    options_.extrapolates_orientation ? age : 0.0);
  }
  bool remembers() const override { return kind_ == PredictorKind::Replay; }

 private:
  /// For owners' bodies: gravity if the body is free, else the measured acceleration while it
  /// changes slowly. A body without an owner reacts to this peer's guess, and a guessed
  /// acceleration oscillates: copies of the piano at profile 5 were then 15 degrees apart (p95),
  /// and 0.7 without it.
  Vec3 acceleration_of(const StateUpdate& update, const PredictionContext& context) const {
    if (!(update.influence >= 1.0F)) return Vec3::Zero();
    PredictorMemory* const memory = context.memory;
    if (memory != nullptr && update.stamp > memory->stamp) measure(update, *memory);
    if (is_free(update)) return context.gravity;
    if (memory == nullptr) return Vec3::Zero();
    const double fit = std::clamp(2.0 - 2.0 * memory->frequency / kMaxFrequency, 0.0, 1.0);
    return fit * memory->acceleration;
  }
  static void measure(const StateUpdate& update, PredictorMemory& memory) {
    const bool first = memory.stamp == 0 || update.flags.teleported;
    const double dt = seconds(update.stamp - memory.stamp);
    const Vec3 measured =
        first ? Vec3(Vec3::Zero()) : Vec3((update.twist.linear - memory.velocity) / dt);
    if (!first) {
      // For a sine of angular frequency w, a low-pass of time constant T misses w T times its
      // output.
      const double missed = (measured - memory.acceleration).norm();
      const double given = memory.acceleration.norm();
      const double cycles = 2.0 * std::numbers::pi * kAccelerationFilter * given;
      const double frequency =
          missed < kUnknownFrequency * cycles ? missed / cycles : kUnknownFrequency;
      const double blend = 1.0 - pbd::portable::exp(-dt / kAccelerationFilter);
      // Rises at once, falls slowly: after a hit the measured acceleration is useless for a while.
      memory.frequency =
          std::max(frequency, memory.frequency + blend * (frequency - memory.frequency));
      memory.acceleration += blend * (measured - memory.acceleration);
    } else {
      memory.acceleration.setZero();
      memory.frequency = 0.0;
    }
    memory.velocity = update.twist.linear;
    memory.stamp = update.stamp;
  }

  PredictorKind kind_;
  PredictorOptions options_;
};

}  // namespace

void PredictorOptions::validate() const {
  require(max_extrapolation >= 0.0 && std::isfinite(max_extrapolation), "PredictorOptions",
          "max_extrapolation", max_extrapolation, "finite and >= 0 s");
}

std::unique_ptr<Predictor> make_predictor(PredictorKind kind, const PredictorOptions& options) {
  options.validate();
  return std::make_unique<Extrapolator>(kind, options);
}

}  // namespace tandem::consensus
