// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "scenes/hand.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "scenes/random.h"

namespace tandem::demos {

double min_jerk(double s) {
  s = std::clamp(s, 0.0, 1.0);
  return s * s * s * (10.0 + s * (6.0 * s - 15.0));
}

HandPath::HandPath(double time, const pbd::Vec3& position) { knots_.push_back({time, position}); }

HandPath& HandPath::wait(double duration) { return move_by(pbd::Vec3::Zero(), duration); }

HandPath& HandPath::move_by(const pbd::Vec3& offset, double duration) {
  return move_to(knots_.back().position + offset, duration);
}

HandPath& HandPath::move_to(const pbd::Vec3& position, double duration) {
  knots_.push_back({knots_.back().time + duration, position});
  return *this;
}

pbd::Vec3 HandPath::at(double time) const {
  const auto next = std::upper_bound(knots_.begin(), knots_.end(), time,
                                     [](double t, const Knot& knot) { return t < knot.time; });
  if (next == knots_.begin()) return knots_.front().position;
  const Knot& from = *(next - 1);
  if (next == knots_.end()) return from.position;
  const double s = (time - from.time) / (next->time - from.time);
  return from.position + min_jerk(s) * (next->position - from.position);
}

MinJerkMove::MinJerkMove(const pbd::Vec3& position) {
  to_.position = position;
  coefficients_.fill(pbd::Vec3::Zero());
  coefficients_[0] = position;
}

MinJerkMove::MinJerkMove(double start, const State& from, double end, const State& to)
    : start_(start), end_(end), to_(to) {
  const double t = end - start;
  const pbd::Vec3 way = to.position - from.position;
  coefficients_[0] = from.position;
  coefficients_[1] = from.velocity;
  coefficients_[2] = 0.5 * from.acceleration;
  coefficients_[3] = (20.0 * way - t * (8.0 * to.velocity + 12.0 * from.velocity) -
                      t * t * (3.0 * from.acceleration - to.acceleration)) /
                     (2.0 * t * t * t);
  coefficients_[4] = (-30.0 * way + t * (14.0 * to.velocity + 16.0 * from.velocity) +
                      t * t * (3.0 * from.acceleration - 2.0 * to.acceleration)) /
                     (2.0 * t * t * t * t);
  coefficients_[5] = (12.0 * way - 6.0 * t * (to.velocity + from.velocity) -
                      t * t * (from.acceleration - to.acceleration)) /
                     (2.0 * t * t * t * t * t);
}

MinJerkMove::State MinJerkMove::at(double time) const {
  State state;
  if (time >= end_) {
    state = to_;
    state.position += (time - end_) * to_.velocity;
    state.acceleration.setZero();
    return state;
  }
  const double t = std::max(0.0, time - start_);
  const auto& c = coefficients_;
  state.position = c[0] + t * (c[1] + t * (c[2] + t * (c[3] + t * (c[4] + t * c[5]))));
  state.velocity = c[1] + t * (2.0 * c[2] + t * (3.0 * c[3] + t * (4.0 * c[4] + t * 5.0 * c[5])));
  state.acceleration = 2.0 * c[2] + t * (6.0 * c[3] + t * (12.0 * c[4] + t * 20.0 * c[5]));
  return state;
}

Tremor::Tremor(std::uint64_t seed, double rms)
    // Each sine carries amplitude^2 / 2 of the mean square.
    : amplitude_(rms * std::sqrt(2.0 / static_cast<double>(kSines))) {
  Random random(seed);
  const double width = (kMaxHz - kMinHz) / static_cast<double>(kSines);
  for (auto& axis : sines_) {
    for (std::size_t i = 0; i < kSines; ++i) {
      // Each sine has its own band, so that the mean square is exact.
      const double low = kMinHz + width * static_cast<double>(i);
      axis[i].frequency = 2.0 * std::numbers::pi * random.uniform(low, low + width);
      axis[i].phase = random.uniform(0.0, 2.0 * std::numbers::pi);
    }
  }
}

pbd::Vec3 Tremor::at(double time) const {
  pbd::Vec3 offset = pbd::Vec3::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    for (const Sine& sine : sines_[static_cast<std::size_t>(axis)]) {
      offset[axis] += amplitude_ * std::sin(sine.frequency * time + sine.phase);
    }
  }
  return offset;
}

}  // namespace tandem::demos
