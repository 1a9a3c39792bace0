// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "input/hand_filter.h"

#include <cmath>
#include <cstddef>
#include <numbers>

#include "tandem/pbd/portable.h"

namespace tandem::consensus {
namespace {

using pbd::Vec3;
using Matrix = std::array<std::array<double, 5>, 5>;

// Figures: p95 apart of moving bodies at profile 5, and rms of their jerk in m/s^3, over the four
// seeds used to choose these numbers, with the local hand's velocity from a low-pass of 25 ms.

/// s, decay time of an acceleration. Cubes 11.6 mm, room 34, a piano with shared springs 4.3; with
/// 0.6 s 10.6, 38 and 6.3, with the same jerk or more.
constexpr double kMotionFading = 0.2;
/// (m/s^3)^2 s, noise that drives the acceleration. Room 34 mm, 286 m/s^3; with 2 39 mm, 228 m/s^3,
/// with 10 32 mm, 340 m/s^3.
constexpr double kJerk = 5.0;
/// Tremor: m rms of each coordinate, rad/s, and the damping ratio. With white noise of the best
/// size instead, cubes 8 ms apart have 1.3 mm in place of 0.8, and room at profile 5 507 m/s^3 in
/// place of 286.
constexpr double kTremor = 3e-4;
constexpr double kTremorRate = 2.0 * std::numbers::pi * 10.0;
constexpr double kTremorDamping = 0.15;
/// m, resolution of a tracker: two positions at almost the same time say nothing about velocity.
constexpr double kResolution = 2e-5;
/// m/s, of a hand that has just grabbed something.
constexpr double kFirstSpeed = 1.0;
/// s: after a longer silence the motion begins anew.
constexpr double kSilence = 0.3;

constexpr double squared(double x) { return x * x; }

/// x(t + h) = F x(t) + noise, in two blocks.
struct Transition {
  explicit Transition(double h)
      : fade(pbd::portable::exp(-h / kMotionFading)),
        speed(kMotionFading * (1.0 - fade)),
        way(squared(kMotionFading) * (fade - 1.0 + h / kMotionFading)),
        dt(h) {}

  double fade;   ///< decay of an acceleration
  double speed;  ///< s, its effect on the velocity
  double way;    ///< s^2, its effect on the position
  double dt;     ///< s
};

Matrix matrix(const Transition& t) {
  const double damped = kTremorRate * std::sqrt(1.0 - squared(kTremorDamping));
  const double left = pbd::portable::exp(-kTremorDamping * kTremorRate * t.dt);
  const pbd::portable::SinCos turn = pbd::portable::sin_cos(damped * t.dt);
  const double lag = kTremorDamping * kTremorRate / damped * turn.sin;
  Matrix f = {};
  f[0] = {1.0, t.dt, t.way, 0.0, 0.0};
  f[1] = {0.0, 1.0, t.speed, 0.0, 0.0};
  f[2] = {0.0, 0.0, t.fade, 0.0, 0.0};
  f[3] = {0.0, 0.0, 0.0, left * (turn.cos + lag), left * turn.sin / damped};
  f[4] = {0.0, 0.0, 0.0, -left * squared(kTremorRate) / damped * turn.sin, left * (turn.cos - lag)};
  return f;
}

/// F P F^T + Q.
Matrix propagated(const Matrix& f, const Matrix& p, double h) {
  Matrix fp = {};
  for (std::size_t i = 0; i < 5; ++i) {
    for (std::size_t j = 0; j < 5; ++j) {
      for (std::size_t k = 0; k < 5; ++k) fp[i][j] += f[i][k] * p[k][j];
    }
  }
  Matrix out = {};
  for (std::size_t i = 0; i < 5; ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      for (std::size_t k = 0; k < 5; ++k) out[i][j] += fp[i][k] * f[j][k];
    }
  }
  // White noise on the derivative of the acceleration, whose decay within h is neglected.
  out[0][0] += kJerk * h * h * h * h * h / 20.0;
  out[1][0] += kJerk * h * h * h * h / 8.0;
  out[2][0] += kJerk * h * h * h / 6.0;
  out[1][1] += kJerk * h * h * h / 3.0;
  out[2][1] += kJerk * h * h / 2.0;
  out[2][2] += kJerk * h;
  // Process noise that keeps the tremor stationary: S - F S F^T, S = diag(place, rate).
  const double place = squared(kTremor);
  const double rate = place * squared(kTremorRate);
  for (std::size_t i = 3; i < 5; ++i) {
    out[i][i] += i == 3 ? place : rate;
    for (std::size_t j = 3; j <= i; ++j) {
      out[i][j] -= f[i][3] * place * f[j][3] + f[i][4] * rate * f[j][4];
    }
  }
  for (std::size_t i = 0; i < 5; ++i) {
    for (std::size_t j = i + 1; j < 5; ++j) out[i][j] = out[j][i];
  }
  return out;
}

}  // namespace

HandFilter::Motion HandFilter::Motion::after(double dt) const {
  const Transition t(dt);
  return {position + dt * velocity + t.way * acceleration, velocity + t.speed * acceleration,
          t.fade * acceleration};
}

HandFilter::HandFilter(const Vec3& position, const Vec3& velocity)
    : motion_{position, velocity, Vec3::Zero()} {
  // The sum of motion and tremor is known exactly.
  const double tremor = squared(kTremor);
  covariance_[0][0] = covariance_[3][3] = tremor;
  covariance_[0][3] = covariance_[3][0] = -tremor;
  covariance_[1][1] = squared(kFirstSpeed);
  covariance_[2][2] = 0.5 * kJerk * kMotionFading;
  covariance_[4][4] = tremor * squared(kTremorRate);
}

void HandFilter::add(double dt, const Vec3& position, const Vec3& velocity) {
  if (!(dt > 0.0) || dt > kSilence) {
    *this = HandFilter(position, velocity);
    return;
  }
  const Transition step(dt);
  const Matrix f = matrix(step);
  covariance_ = propagated(f, covariance_, dt);
  Matrix& p = covariance_;
  motion_ = motion_.after(dt);
  tremor_ = {f[3][3] * tremor_[0] + f[3][4] * tremor_[1],
             f[4][3] * tremor_[0] + f[4][4] * tremor_[1]};
  // The sum of position and tremor is measured.
  std::array<double, 5> gain = {};
  for (std::size_t i = 0; i < 5; ++i) gain[i] = p[i][0] + p[i][3];
  const double innovation = gain[0] + gain[3] + squared(kResolution);
  const Vec3 missed = (position - motion_.position - tremor_[0]) / innovation;
  motion_.position += gain[0] * missed;
  motion_.velocity += gain[1] * missed;
  motion_.acceleration += gain[2] * missed;
  tremor_[0] += gain[3] * missed;
  tremor_[1] += gain[4] * missed;
  for (std::size_t i = 0; i < 5; ++i) {
    for (std::size_t j = 0; j < 5; ++j) p[i][j] -= gain[i] * gain[j] / innovation;
  }
}

}  // namespace tandem::consensus
