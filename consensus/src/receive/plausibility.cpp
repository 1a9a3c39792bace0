// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/consensus/plausibility.h"

#include <algorithm>
#include <cmath>

#include "common/session_time.h"
#include "tandem/consensus/influence.h"
#include "tandem/pbd/validate.h"

namespace tandem::consensus {

using pbd::detail::require;

void PlausibilityOptions::validate() const {
  const auto positive = [](double value, const char* field) {
    require(value > 0.0, "PlausibilityOptions", field, value, "> 0");
  };
  positive(max_speed, "max_speed");
  positive(max_spin, "max_spin");
  positive(jump, "jump");
  positive(turn, "turn");
  positive(max_acceleration, "max_acceleration");
  positive(max_spin_acceleration, "max_spin_acceleration");
  positive(max_hit, "max_hit");
  require(teleport_interval >= 0.0 && teleport_interval <= 86400.0, "PlausibilityOptions",
          "teleport_interval", teleport_interval, "from 0 to 86400 s");
}

bool plausible(const StateUpdate& state, const PlausibilityOptions& limits) {
  return state.twist.linear.squaredNorm() <= limits.max_speed * limits.max_speed &&
         state.twist.angular.squaredNorm() <= limits.max_spin * limits.max_spin;
}

bool plausible(const StateUpdate& last, const StateUpdate& next,
               const PlausibilityOptions& limits) {
  if (!plausible(next, limits)) return false;
  const double dt = std::max(seconds(next.stamp - last.stamp), 0.0);
  const double steps = 1.0 + dt / kShareInterval;

  const double square = std::max(last.twist.linear.squaredNorm(), next.twist.linear.squaredNorm());
  const double way =
      limits.jump * steps + (2.0 * std::sqrt(square) + 0.5 * limits.max_acceleration * dt) * dt;
  if (!((next.pose.position - last.pose.position).squaredNorm() <= way * way)) return false;

  const double hit = limits.max_hit + limits.max_acceleration * dt;
  if (!((next.twist.linear - last.twist.linear).squaredNorm() <= hit * hit)) return false;

  // No rotation is longer than half a turn, so that after a while all are plausible.
  const double spin =
      std::sqrt(std::max(last.twist.angular.squaredNorm(), next.twist.angular.squaredNorm()));
  const double turn =
      limits.turn * steps + (2.0 * spin + 0.5 * limits.max_spin_acceleration * dt) * dt;
  constexpr double kHalfTurn = 3.141592653589793;
  if (turn >= kHalfTurn) return true;
  const double cosine =
      std::abs(last.pose.orientation.coeffs().dot(next.pose.orientation.coeffs()));
  return cosine >= std::cos(0.5 * turn);
}

}  // namespace tandem::consensus
