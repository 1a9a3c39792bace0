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

}  // namespace

void learn(SwingFit& fit, SessionTime before, const pbd::Vec3& at, const StateUpdate& update) {
  for (SwingFit::Probe& probe : fit.probes) {
    if (probe.time == 0 || update.stamp < probe.time) continue;
    if (before != 0 && before <= probe.time && !update.flags.teleported) {
      const double f =
          static_cast<double>(probe.time - before) / static_cast<double>(update.stamp - before);
      const pbd::Vec3 y = at + f * (update.pose.position - at) - probe.position;
      const auto add = [](double& sum, double value) { sum = kKept * sum + value; };
      add(fit.aa, probe.apart.squaredNorm());
      add(fit.ad, probe.apart.dot(probe.drift));
      add(fit.dd, probe.drift.squaredNorm());
      add(fit.ay, probe.apart.dot(y));
      add(fit.dy, probe.drift.dot(y));
      add(fit.yy, y.squaredNorm());
    }
    probe.time = 0;
  }
}

void expect(SwingFit& fit, SessionTime now, double age, const pbd::Vec3& own,
            const pbd::Vec3& apart, const pbd::Vec3& drift) {
  SessionTime latest = 0;
  SwingFit::Probe* empty = nullptr;
  for (SwingFit::Probe& probe : fit.probes) {
    latest = std::max(latest, probe.time);
    if (probe.time == 0 && empty == nullptr) empty = &probe;
  }
  const bool due = latest == 0 || seconds(now - latest) > age / SwingFit::kProbes;
  if (empty != nullptr && due) *empty = {now, own, apart, drift};
}

SwingParts parts_of(const SwingFit& fit) {
  constexpr double kSquare = kLeast * kLeast;
  const double aa = fit.aa + kSquare;
  const double dd = fit.dd + kSquare;
  const double ay = fit.ay + kSquare;
  const double det = aa * dd - fit.ad * fit.ad;
  SwingParts parts{.apart = std::clamp((ay * dd - fit.dy * fit.ad) / det, 0.0, 1.0),
                   .drift = std::clamp((fit.dy * aa - ay * fit.ad) / det, 0.0, 1.0)};
  // What of the square of y they explain; twice, since a share that is wrong feeds itself.
  const double explained =
      2.0 * (parts.apart * ay + parts.drift * fit.dy) -
      (parts.apart * parts.apart * aa + 2.0 * parts.apart * parts.drift * fit.ad +
       parts.drift * parts.drift * dd);
  const double known = std::clamp(explained / (fit.yy + kSquare), 0.0, 1.0);
  parts.apart *= known * known;
  parts.drift *= known * known;
  return parts;
}

}  // namespace tandem::consensus::detail
