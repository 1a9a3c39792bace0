// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/consensus/plausibility.h"

#include <algorithm>
#include <cmath>

#include "common/session_time.h"
#include "tandem/consensus/influence.h"
#include "tandem/pbd/portable.h"
#include "tandem/pbd/validate.h"

namespace tandem::consensus {

using pbd::detail::require;

namespace {

constexpr double kMaxSpin = 1000.0;           // rad/s
constexpr double kTurn = 1.0;                 // rad, as PlausibilityOptions::jump
constexpr double kMaxAcceleration = 1000.0;   // m/s^2, between two states
constexpr double kMaxSpinAcceleration = 1e3;  // rad/s^2
constexpr double kMaxHit = 100.0;             // m/s, sudden change of velocity

}  // namespace

void PlausibilityOptions::validate() const {
  const auto positive = [](double value, const char* field) {
    require(value > 0.0, "PlausibilityOptions", field, value, "> 0");
  };
  positive(max_speed, "max_speed");
  positive(jump, "jump");
}

bool plausible(const StateUpdate& state, const PlausibilityOptions& limits) {
  return state.twist.linear.squaredNorm() <= limits.max_speed * limits.max_speed &&
         state.twist.angular.squaredNorm() <= kMaxSpin * kMaxSpin;
}

bool plausible(const StateUpdate& last, const StateUpdate& next,
               const PlausibilityOptions& limits) {
  if (!plausible(next, limits)) return false;
  const double dt = std::max(seconds(next.stamp - last.stamp), 0.0);
  const double steps = 1.0 + dt / kShareInterval;

  const double square = std::max(last.twist.linear.squaredNorm(), next.twist.linear.squaredNorm());
  const double way =
      limits.jump * steps + (2.0 * std::sqrt(square) + 0.5 * kMaxAcceleration * dt) * dt;
  if (!((next.pose.position - last.pose.position).squaredNorm() <= way * way)) return false;

  const double hit = kMaxHit + kMaxAcceleration * dt;
  if (!((next.twist.linear - last.twist.linear).squaredNorm() <= hit * hit)) return false;

  // Rotations are at most half a turn: after a while all are plausible.
  const double spin =
      std::sqrt(std::max(last.twist.angular.squaredNorm(), next.twist.angular.squaredNorm()));
  const double turn = kTurn * steps + (2.0 * spin + 0.5 * kMaxSpinAcceleration * dt) * dt;
  constexpr double kHalfTurn = 3.141592653589793;
  if (turn >= kHalfTurn) return true;
  const double cosine =
      std::abs(last.pose.orientation.coeffs().dot(next.pose.orientation.coeffs()));
  return cosine >= pbd::portable::sin_cos(0.5 * turn).cos;
}

}  // namespace tandem::consensus
