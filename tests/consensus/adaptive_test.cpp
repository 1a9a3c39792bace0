// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// The adaptive predictor takes the way that has done well on the same body.
#include <algorithm>
#include <array>
#include <cmath>

#include "support/catch.h"
#include "tandem/consensus/predictor.h"

namespace tandem::consensus::adaptive_test {
namespace {

using pbd::Vec3;

constexpr SessionTime kStart = 1'000'000'000;
constexpr SessionTime kStep = 16'000'000;  // ns
constexpr double kDt = 0.016;              // s
constexpr int kLate = 6;                   // steps

/// m: how far predictions of the last of `steps` steps are off, of a body that touches something.
/// The remote's x is `there`(t), the own `here`(t), both with their true velocities.
template <class Here, class There>
double error_of(PredictorKind kind, int steps, const Here& here, const There& there,
                PredictorMemory* memory) {
  const auto predictor = make_predictor(kind);
  const auto velocity = [](const auto& x, double t) { return (x(t + 1e-6) - x(t - 1e-6)) / 2e-6; };
  MotionHistory own;
  double error = 0.0;
  for (int i = 0; i < steps; ++i) {
    const double t = i * kDt;
    own.push(kStart + i * kStep, {{here(t), 0.0, 0.0}, pbd::Quat::Identity()},
             {{velocity(here, t), 0.0, 0.0}, Vec3::Zero()}, {}, true);
    if (i < kLate) continue;
    const double then = (i - kLate) * kDt;
    StateUpdate update;
    update.id = {1, 1};
    update.pose.position.x() = there(then);
    update.twist.linear.x() = velocity(there, then);
    update.stamp = kStart + (i - kLate) * kStep;
    update.flags.in_contact = true;
    const Prediction p =
        predictor->predict(update, own, {.now = kStart + i * kStep, .memory = memory});
    error = std::abs(here(t) + p.translation.x() - there(t));
  }
  return error;
}

TEST_CASE("predictor: adaptive takes own motion where both move alike, and linear where not",
          "[consensus][unit]") {
  const auto swing = [](double t) { return 0.05 * std::sin(6.0 * t); };
  const auto apart = [&](double t) { return swing(t) + 0.01; };
  const auto line = [](double t) { return 0.01 * t; };  // never far
  double worst_linear = 0.0;
  double worst_blend = 0.0;
  for (int steps = 200; steps < 280; steps += 7) {
    PredictorMemory memory;
    // Both swing: own motion knows it all.
    CHECK(error_of(PredictorKind::Adaptive, steps, swing, apart, &memory) < 1e-5);
    memory = {};
    // I swing and the other goes straight on.
    CHECK(error_of(PredictorKind::Adaptive, steps, swing, line, &memory) < 1e-5);
    worst_linear =
        std::max(worst_linear, error_of(PredictorKind::Euler, steps, swing, apart, nullptr));
    worst_blend =
        std::max(worst_blend, error_of(PredictorKind::Blend, steps, swing, line, nullptr));
  }
  // Each of them alone is wrong in one of the cases: a straight line by 0.05 w^2 A^2 / 2 = 8 mm
  // where the swing turns, own motion by up to 0.05 w A = 29 mm.
  CHECK(worst_linear > 0.006);
  CHECK(worst_blend > 0.02);
}

TEST_CASE("predictor: adaptive knows its own error once it was checked", "[consensus][unit]") {
  // The other one jerks about in a way that no way foresees.
  const auto still = [](double) { return 0.0; };
  const auto wild = [](double t) { return 0.05 * std::sin(40.0 * t); };
  std::array<double, PredictorMemory::kWays> errors{};
  double squares = 0.0;
  constexpr int kSteps = 400;
  for (int steps = 200; steps < kSteps; ++steps) {
    PredictorMemory fresh;
    const double error = error_of(PredictorKind::Adaptive, steps, still, wild, &fresh);
    squares += error * error / 200.0;
    errors = fresh.error;
  }
  const double best = *std::min_element(errors.begin(), errors.end());
  CHECK(best > 0.2 * squares);
  CHECK(best < 5.0 * squares);
}

TEST_CASE("predictor: adaptive without a memory is the blend for bodies that are close",
          "[consensus][unit]") {
  const auto swing = [](double t) { return 0.05 * std::sin(6.0 * t); };
  const auto apart = [&](double t) { return swing(t) + 0.01; };
  CHECK(error_of(PredictorKind::Adaptive, 60, swing, apart, nullptr) ==
        error_of(PredictorKind::Blend, 60, swing, apart, nullptr));
}

TEST_CASE("predictor: adaptive knows of a bounce that only the velocity shows yet",
          "[consensus][analytic]") {
  // Both fall alike; the own ball came down on the ground in its last step and turned round there,
  // while the other's state was stamped before. A straight line would go on into the ground.
  constexpr double kFall = 3.0;  // m/s
  const auto height = [](double t) { return Vec3(0.0, 0.0, 0.1 - kFall * t); };
  const Vec3 down(0.0, 0.0, -kFall);
  MotionHistory own;
  for (int i = 0; i < 4; ++i) {
    own.push(kStart + i * kStep, {height(i * kDt), pbd::Quat::Identity()},
             {i < 3 ? down : Vec3(-down), Vec3::Zero()}, {}, i == 3);
  }
  StateUpdate update;
  update.id = {1, 1};
  const double stamp = 2.5 * kDt;
  update.pose.position = height(stamp);
  // It weighs a little: the velocities are not quite the same.
  update.twist.linear = down + Vec3(0.0, 0.0, -0.05);
  update.stamp = kStart + std::llround(1e9 * stamp);
  update.flags.leads = true;
  PredictorMemory memory;
  const Prediction p = make_predictor(PredictorKind::Adaptive)
                           ->predict(update, own, {.now = kStart + 3 * kStep, .memory = &memory});
  CHECK(std::abs(p.twist.linear.z()) < 0.1);
}

}  // namespace
}  // namespace tandem::consensus::adaptive_test
