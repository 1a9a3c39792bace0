// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Predictors that carry a state on by itself: none, second order, Kalman; and their limits.
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "consensus/random.h"
#include "support/catch.h"
#include "tandem/consensus/predictor.h"

namespace tandem::consensus::extrapolation_test {
namespace {

using pbd::Vec3;
using testing::Dice;

constexpr SessionTime kStart = 1'000'000'000;
constexpr SessionTime kStep = 16'000'000;  // ns
constexpr double kDt = 0.016;              // s
const Vec3 kGravity(0.0, 0.0, -9.81);

/// An own body that rests in the origin: what a predictor says is where the remote one is.
MotionHistory at_origin() {
  MotionHistory history;
  history.push(kStart, {}, {}, {}, false);
  return history;
}

StateUpdate state(int index, const Vec3& position, const Vec3& velocity) {
  StateUpdate update;
  update.id = {1, 1};
  update.pose.position = position;
  update.twist.linear = velocity;
  update.stamp = kStart + index * kStep;
  return update;
}

/// Where `kind` sees a body `ahead` s after the last of `count` states that `motion` gives.
template <class Motion>
Prediction after(PredictorKind kind, const PredictorOptions& options, int count, double ahead,
                 const Motion& motion) {
  const auto predictor = make_predictor(kind, options);
  const MotionHistory own = at_origin();
  PredictorMemory memory;
  Prediction prediction;
  for (int i = 0; i < count; ++i) {
    const StateUpdate update = motion(i);
    const SessionTime now = update.stamp + std::llround(1e9 * ahead);
    prediction =
        predictor->predict(update, own, {.now = now, .gravity = kGravity, .memory = &memory});
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

TEST_CASE("predictor: second order meets a projectile exactly", "[consensus][analytic]") {
  const Vec3 x(0.1, 0.2, 3.0);
  const Vec3 v(2.0, -1.0, 4.0);
  const auto fall = [&](double t) { return Vec3(x + t * v + 0.5 * t * t * kGravity); };
  for (const double ahead : {0.0, 0.03, 0.15, 0.4}) {
    const auto p =
        after(PredictorKind::SecondOrder, {}, 1, ahead, [&](int i) { return state(i, x, v); });
    CHECK((p.translation - fall(ahead)).norm() < 1e-8);  // ns in the age
    CHECK((p.twist.linear - (v + ahead * kGravity)).norm() < 1e-7);
  }
}

TEST_CASE("predictor: second order measures a steady acceleration, not a quick change",
          "[consensus][analytic]") {
  const Vec3 a(1.5, 0.0, 0.5);
  const double ahead = 0.1;
  const auto pushed = [&](int i) {
    const double t = i * kDt;
    StateUpdate update = state(i, 0.5 * t * t * a, t * a);
    update.flags.in_contact = true;
    return update;
  };
  // The low-pass (50 ms) has come to its end after a second.
  const double then = 60 * kDt + ahead;
  const auto p = after(PredictorKind::SecondOrder, {}, 61, ahead, pushed);
  CHECK((p.translation - 0.5 * then * then * a).norm() < 1e-6);

  // 12 Hz, above the limit: the same as Euler, whatever the phase.
  const double w = 2.0 * std::numbers::pi * 12.0;
  for (int count = 100; count < 106; ++count) {
    const auto shaken = [&](int i) {
      const double t = i * kDt;
      StateUpdate update =
          state(i, {0.01 * std::sin(w * t), 0.0, 0.0}, {0.01 * w * std::cos(w * t), 0.0, 0.0});
      update.flags.in_contact = true;
      return update;
    };
    const auto second = after(PredictorKind::SecondOrder, {}, count, ahead, shaken);
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
  for (const auto kind :
       {PredictorKind::Euler, PredictorKind::SecondOrder, PredictorKind::Kalman}) {
    const auto at = [&](double ahead, double limit) {
      return after(kind, {.max_extrapolation = limit}, 40, ahead, move).translation.x();
    };
    CHECK(at(0.5, 0.1) == Approx(39 * kDt + 0.1).margin(1e-6));
    CHECK(at(0.05, 0.1) == Approx(39 * kDt + 0.05).margin(1e-6));
    CHECK(at(0.5, 0.0) == Approx(39 * kDt).margin(1e-6));
  }
  CHECK_THROWS_AS(make_predictor(PredictorKind::Euler, {.max_extrapolation = -1.0}),
                  std::invalid_argument);
  CHECK_THROWS_AS(make_predictor(PredictorKind::Blend,
                                 {.max_frequency = std::numeric_limits<double>::quiet_NaN()}),
                  std::invalid_argument);
}

TEST_CASE("predictor: Kalman's own variance is the square of the errors it makes",
          "[consensus][unit]") {
  // A body pushed about at random: white noise in the acceleration, of which it knows nothing.
  for (const double noise : {0.01, 1.0}) {  // m/s in each step
    for (const double ahead : {0.05, 0.2}) {
      const auto predictor = make_predictor(PredictorKind::Kalman);
      const MotionHistory own = at_origin();
      Dice dice(11);
      std::vector<Vec3> xs;
      std::vector<Vec3> vs;
      Vec3 x = Vec3::Zero();
      Vec3 v = Vec3::Zero();
      for (int i = 0; i < 4000; ++i) {
        xs.push_back(x);
        vs.push_back(v);
        // In many small pushes: position and velocity are hit by noise of their own.
        for (int k = 0; k < 16; ++k) {
          const Vec3 push = 0.25 * noise * dice.vec3(1.0);
          x += kDt / 16.0 * (v + 0.5 * push);
          v += push;
        }
      }
      PredictorMemory memory;
      double squares = 0.0;
      double variances = 0.0;
      const int steps = static_cast<int>(std::lround(ahead / kDt));
      for (int i = 0; i + steps < 4000; ++i) {
        StateUpdate update =
            state(i, xs[static_cast<std::size_t>(i)], vs[static_cast<std::size_t>(i)]);
        update.flags.in_contact = true;
        const Prediction p = predictor->predict(
            update, own, {.now = update.stamp + steps * kStep, .memory = &memory});
        if (i < 500) continue;
        squares += (p.translation - xs[static_cast<std::size_t>(i + steps)]).squaredNorm();
        variances += p.variance;
      }
      INFO("noise " << noise << " m/s, " << ahead << " s ahead");
      CHECK(variances / squares > 0.6);
      CHECK(variances / squares < 1.7);
    }
  }
}

TEST_CASE("predictor: Kalman follows a free fall and forgets a jump", "[consensus][analytic]") {
  const auto fall = [](double t) { return Vec3(0.5 * t * t * kGravity); };
  const auto falling = [&](int i) { return state(i, fall(i * kDt), i * kDt * kGravity); };
  const auto p = after(PredictorKind::Kalman, {}, 60, 0.1, falling);
  CHECK((p.translation - fall(59 * kDt + 0.1)).norm() < 1e-6);

  const auto jumping = [](int i) {
    StateUpdate update = state(i, {i < 30 ? 0.0 : 0.4, 0.0, 0.0}, Vec3::Zero());
    update.flags = {.in_contact = true, .teleported = i == 30};
    return update;
  };
  CHECK(after(PredictorKind::Kalman, {}, 31, 0.1, jumping).translation.x() == 0.4);
}

TEST_CASE("predictor: pure local motion asks nobody how the body is moved", "[consensus][unit]") {
  MotionHistory own;
  for (int i = 0; i < 20; ++i)
    own.push(kStart + i * kStep, {{0.1 * i, 0.0, 0.0}, {}}, {}, {}, false);
  StateUpdate update = state(9, {5.0, 0.0, 0.0}, {7.0, 0.0, 0.0});
  update.pose.position.x() = 0.1 * 9 + 0.05;
  update.flags.owner_driven = true;
  const PredictionContext context{.now = kStart + 19 * kStep};
  // 5 cm apart at the stamp, and so now; the blend takes the driver's velocity.
  CHECK(make_predictor(PredictorKind::LocalMotion)->predict(update, own, context).translation.x() ==
        Approx(0.05).epsilon(1e-12));
  CHECK(make_predictor(PredictorKind::Blend)->predict(update, own, context).translation.x() ==
        Approx(0.95 + 10 * kDt * 7.0 - 1.9).epsilon(1e-12));
}

}  // namespace
}  // namespace tandem::consensus::extrapolation_test
