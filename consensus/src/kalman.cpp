// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <algorithm>
#include <cmath>

#include "predictors.h"

namespace tandem::consensus {
namespace {

using detail::seconds;
using pbd::Vec3;

// What the states that are sent are uncertain by: solvers' noise.
constexpr double kPositionVariance = 1e-10;  // m^2, (10 um)^2
constexpr double kVelocityVariance = 1e-6;   // m^2/s^2, (1 mm/s)^2

// Of the acceleration that nobody foresees, m^2/s^3; follows what the innovations say.
constexpr double kFirstNoise = 1.0;
constexpr double kLeastNoise = 1e-6;
constexpr double kMostNoise = 1e4;
constexpr double kAdaptation = 0.1;  ///< of each update
constexpr double kMostSurprise = 10.0;

/// m: a body that is so far from where it was expected was put there.
constexpr double kUnforeseen = 0.5;

/// Position and velocity of a body whose acceleration is gravity where it is free, and noise. The
/// three axes have one covariance. The noise is estimated as well, so that the variance is true.
class KalmanPredictor final : public Predictor {
 public:
  explicit KalmanPredictor(const PredictorOptions& options) : options_(options) {}

  Prediction predict(const StateUpdate& update, const MotionHistory& own,
                     const PredictionContext& context) const override {
    PredictorMemory alone;
    PredictorMemory& memory = context.memory != nullptr ? *context.memory : alone;
    const Vec3 push = detail::is_free(update) ? context.gravity : Vec3(Vec3::Zero());
    if (update.stamp > memory.stamp) take_in(update, push, memory);
    const double age = std::min(seconds(context.now - update.stamp), options_.max_extrapolation);
    PredictorMemory now = memory;
    carry(std::max(age, 0.0), push, now);
    pbd::Twist twist = update.twist;
    twist.linear = now.velocity;
    Prediction prediction = detail::to_state(update, own.newest(), now.position, twist, age);
    prediction.variance = 3.0 * now.position_variance;
    return prediction;
  }
  double gain() const override { return 1.0; }
  bool remembers() const override { return true; }

 private:
  static void carry(double dt, const Vec3& push, PredictorMemory& m) {
    m.position += dt * m.velocity + 0.5 * dt * dt * push;
    m.velocity += dt * push;
    m.position_variance +=
        dt * (2.0 * m.covariance + dt * m.velocity_variance) + m.noise * dt * dt * dt / 3.0;
    m.covariance += dt * m.velocity_variance + 0.5 * m.noise * dt * dt;
    m.velocity_variance += m.noise * dt;
  }

  static void take_in(const StateUpdate& update, const Vec3& push, PredictorMemory& m) {
    const double dt = seconds(update.stamp - m.stamp);
    const bool first = m.stamp == 0;
    m.stamp = update.stamp;
    if (!first) carry(dt, push, m);
    const Vec3 missed = update.pose.position - m.position;
    const Vec3 slower = update.twist.linear - m.velocity;
    if (first || update.flags.teleported || missed.norm() > kUnforeseen) {
      m.position = update.pose.position;
      m.velocity = update.twist.linear;
      m.position_variance = kPositionVariance;
      m.covariance = 0.0;
      m.velocity_variance = kVelocityVariance;
      if (first) m.noise = kFirstNoise;
      return;
    }
    // Both position and velocity are measured: K = P S^-1 with S = P + R.
    const double s11 = m.position_variance + kPositionVariance;
    const double s12 = m.covariance;
    const double s22 = m.velocity_variance + kVelocityVariance;
    const double det = s11 * s22 - s12 * s12;
    const double i11 = s22 / det;
    const double i12 = -s12 / det;
    const double i22 = s11 / det;
    // 1 on average where the variances are true: six numbers measured.
    const double surprise =
        (i11 * missed.squaredNorm() + 2.0 * i12 * missed.dot(slower) + i22 * slower.squaredNorm()) /
        6.0;
    const double change = kAdaptation * (std::min(surprise, kMostSurprise) - 1.0);
    const double k11 = m.position_variance * i11 + m.covariance * i12;
    const double k12 = m.position_variance * i12 + m.covariance * i22;
    const double k21 = m.covariance * i11 + m.velocity_variance * i12;
    const double k22 = m.covariance * i12 + m.velocity_variance * i22;
    m.position += k11 * missed + k12 * slower;
    m.velocity += k21 * missed + k22 * slower;
    // P = K R where K is optimal.
    m.position_variance = k11 * kPositionVariance;
    m.covariance = 0.5 * (k12 * kVelocityVariance + k21 * kPositionVariance);
    m.velocity_variance = k22 * kVelocityVariance;
    m.noise = std::clamp(m.noise * std::exp(change), kLeastNoise, kMostNoise);
  }

  PredictorOptions options_;
};

}  // namespace

std::unique_ptr<Predictor> detail::make_kalman(const PredictorOptions& options) {
  return std::make_unique<KalmanPredictor>(options);
}

}  // namespace tandem::consensus
