// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "swing_fit.h"

#include <algorithm>

#include "predictors.h"

namespace tandem::consensus::detail {
namespace {

/// What is kept of the sums with each probe.
constexpr double kKept = 0.95;
/// m: differences below say nothing.
constexpr double kLeast = 5e-5;
/// Where the fit leaves this much unexplained, agreement gives no energy at all.
constexpr double kConfused = 0.05;

double square(double value) { return value * value; }

}  // namespace

void learn(SwingFit& fit, SessionTime before, const pbd::Vec3& position, const pbd::Vec3& velocity,
           const StateUpdate& update) {
  for (SwingFit::Probe& probe : fit.probes) {
    if (probe.time == 0 || update.stamp < probe.time) continue;
    if (before != 0 && before <= probe.time && !update.flags.teleported) {
      const double f =
          static_cast<double>(probe.time - before) / static_cast<double>(update.stamp - before);
      const pbd::Vec3 y = position + f * (update.pose.position - position) - probe.position;
      const pbd::Vec3 v =
          probe.age * (velocity + f * (update.twist.linear - velocity) - probe.velocity);
      const auto add = [](double& sum, double value) { sum = kKept * sum + value; };
      add(fit.aa, probe.apart.squaredNorm());
      add(fit.ad, probe.apart.dot(probe.drift));
      add(fit.dd, probe.drift.squaredNorm());
      add(fit.ay, probe.apart.dot(y));
      add(fit.dy, probe.drift.dot(y));
      add(fit.yy, y.squaredNorm());
      add(fit.dv, probe.drift.dot(v));
      add(fit.vv, v.squaredNorm());
    }
    probe.time = 0;
  }
}

void expect(SwingFit& fit, SessionTime now, double age, const MotionSample& own,
            const pbd::Vec3& apart, const pbd::Vec3& drift) {
  SessionTime latest = 0;
  SwingFit::Probe* empty = nullptr;
  for (SwingFit::Probe& probe : fit.probes) {
    latest = std::max(latest, probe.time);
    if (probe.time == 0 && empty == nullptr) empty = &probe;
  }
  const bool due = latest == 0 || seconds(now - latest) > age / SwingFit::kProbes;
  if (empty == nullptr || !due) return;
  *empty = {.time = now,
            .position = own.pose.position,
            .velocity = own.twist.linear,
            .apart = apart,
            .drift = drift,
            .age = age};
}

SwingParts parts_of(const SwingFit& fit) {
  constexpr double kSquare = kLeast * kLeast;
  const double aa = fit.aa + kSquare;
  const double dd = fit.dd + kSquare;
  const double ay = fit.ay + kSquare;
  const double dv = fit.dv + kSquare;
  const double det = aa * dd - fit.ad * fit.ad;
  SwingParts parts{.apart = std::clamp((ay * dd - fit.dy * fit.ad) / det, 0.0, 1.0),
                   .drift = std::clamp((fit.dy * aa - ay * fit.ad) / det, 0.0, 1.0),
                   .velocity = std::clamp(dv / dd, 0.0, 1.0)};
  // The part of the squares that they explain; twice, since a share that is wrong feeds itself.
  const double position = 2.0 * (parts.apart * ay + parts.drift * fit.dy) -
                          (parts.apart * parts.apart * aa + parts.drift * parts.drift * dd +
                           2.0 * parts.apart * parts.drift * fit.ad);
  const double velocity = 2.0 * parts.velocity * dv - parts.velocity * parts.velocity * dd;
  const double known = std::clamp(position / (fit.yy + kSquare), 0.0, 1.0);
  parts.apart *= square(known);
  parts.drift *= square(known);
  parts.velocity *= square(std::clamp(velocity / (fit.vv + kSquare), 0.0, 1.0));
  parts.unknown = std::min(1.0, (1.0 - known) / kConfused);
  return parts;
}

pbd::Vec3 without_forward(double part, const pbd::Vec3& change, const pbd::Vec3& way) {
  const double along = change.dot(way);
  if (!(along > 0.0)) return change;
  return change - part * along / way.squaredNorm() * way;
}

}  // namespace tandem::consensus::detail
