// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Predictors that carry a state on by itself: none, and what is not replayed; and their limits.
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "consensus/known_motion.h"
#include "support/catch.h"
#include "tandem/consensus/predictor.h"

namespace tandem::consensus::extrapolation_test {
namespace {

using pbd::Vec3;
using testing::KnownMotion;

constexpr SessionTime kStart = 1'000'000'000;
constexpr SessionTime kStep = 16'000'000;  // ns
constexpr double kDt = 0.016;              // s
const Vec3 kGravity(0.0, 0.0, -9.81);

StateUpdate state(int index, const Vec3& position, const Vec3& velocity) {
  StateUpdate update;
  update.id = {1, 1};
  update.pose.position = position;
  update.twist.linear = velocity;
  update.stamp = kStart + index * kStep;
  return update;
}

StateUpdate owned(StateUpdate update) {
  update.influence = 1.0F;
  return update;
}

/// Prediction by `kind` of a body (the local copy rests at the origin) `ahead` s after the last of
/// `count` states that `motion` gives.
template <class Motion>
Prediction after(PredictorKind kind, const PredictorOptions& options, int count, double ahead,
                 const Motion& motion) {
  const auto predictor = make_predictor(kind, options);
  PredictorMemory memory;
  Prediction prediction;
  for (int i = 0; i < count; ++i) {
    const StateUpdate update = motion(i);
    const SessionTime now = update.stamp + std::llround(1e9 * ahead);
    prediction = predictor->predict(update, KnownMotion(now),
                                    {.now = now, .gravity = kGravity, .memory = &memory});
  }
  return prediction;
}

TEST_CASE("predictor: without one a state stays where it was stamped", "[consensus][unit]") {
  const auto p = after(PredictorKind::None, {}, 1, 0.3, [](int i) {
    return state(i, {1.0, 2.0, 3.0}, {4.0, 5.0, 6.0});
  });
  CHECK(p.translation == Vec3(1.0, 2.0, 3.0));
  CHECK(p.twist.linear == Vec3(4.0, 5.0, 6.0));
  CHECK(p.rotation.norm() == 0.0);
}

TEST_CASE("predictor: an owner's projectile is met exactly, and nobody else's acceleration counts",
          "[consensus][analytic]") {
  const Vec3 x(0.1, 0.2, 3.0);
  const Vec3 v(2.0, -1.0, 4.0);
  const auto fall = [&](double t) { return Vec3(x + t * v + 0.5 * t * t * kGravity); };
  for (const double ahead : {0.0, 0.03, 0.15, 0.4}) {
    const auto p =
        after(PredictorKind::Replay, {}, 1, ahead, [&](int i) { return owned(state(i, x, v)); });
    CHECK((p.translation - fall(ahead)).norm() < 1e-8);  // ns in the age
    CHECK((p.twist.linear - (v + ahead * kGravity)).norm() < 1e-7);
    const auto shared =
        after(PredictorKind::Replay, {}, 1, ahead, [&](int i) { return state(i, x, v); });
    CHECK((shared.translation - (x + ahead * v)).norm() < 1e-8);
  }
}

TEST_CASE("predictor: an owner's steady acceleration is measured, not a quick change",
          "[consensus][analytic]") {
  const Vec3 a(1.5, 0.0, 0.5);
  const double ahead = 0.1;
  const auto pushed = [&](int i) {
    const double t = i * kDt;
    StateUpdate update = owned(state(i, 0.5 * t * t * a, t * a));
    update.flags.in_contact = true;
    return update;
  };
  // The low-pass (50 ms) has come to its end after a second.
  const double then = 60 * kDt + ahead;
  const auto p = after(PredictorKind::Replay, {}, 61, ahead, pushed);
  CHECK((p.translation - 0.5 * then * then * a).norm() < 1e-6);

  // 12 Hz, above the limit: the same as Euler, whatever the phase.
  const double w = 2.0 * std::numbers::pi * 12.0;
  for (int count = 100; count < 106; ++count) {
    const auto shaken = [&](int i) {
      const double t = i * kDt;
      StateUpdate update = owned(
          state(i, {0.01 * std::sin(w * t), 0.0, 0.0}, {0.01 * w * std::cos(w * t), 0.0, 0.0}));
      update.flags.in_contact = true;
      return update;
    };
    const auto second = after(PredictorKind::Replay, {}, count, ahead, shaken);
    const auto first = after(PredictorKind::Euler, {}, count, ahead, shaken);
    CHECK((second.translation - first.translation).norm() == 0.0);
  }
}

TEST_CASE("predictor: nothing is carried on for longer than the limit", "[consensus][unit]") {
  const Vec3 v(1.0, 0.0, 0.0);
  const auto move = [&](int i) {
    StateUpdate update = state(i, i * kDt * v, v);
    update.flags.in_contact = true;
    return update;
  };
  for (const auto kind : {PredictorKind::Euler, PredictorKind::Replay}) {
    const auto at = [&](double ahead, double limit) {
      return after(kind, {.max_extrapolation = limit}, 40, ahead, move).translation.x();
    };
    CHECK(at(0.5, 0.1) == Approx(39 * kDt + 0.1).margin(1e-6));
    CHECK(at(0.05, 0.1) == Approx(39 * kDt + 0.05).margin(1e-6));
    CHECK(at(0.5, 0.0) == Approx(39 * kDt).margin(1e-6));
  }
  CHECK_THROWS_AS(make_predictor(PredictorKind::Euler, {.max_extrapolation = -1.0}),
                  std::invalid_argument);
}

}  // namespace
}  // namespace tandem::consensus::extrapolation_test
