// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <span>
#include <vector>

#include "measures/metrics.h"
#include "session/track.h"

namespace tandem::demos {

/// A second-order Butterworth high-pass, run forwards and backwards for zero phase; the gain is 1 /
/// (1 + (cutoff/f)^4).
/// @param rate  Hz, of the samples     @param cutoff  Hz, below half the rate
std::vector<double> high_pass(std::span<const double> values, double rate, double cutoff);

/// Spectral arc length of a speed profile: the length of its normalised amplitude spectrum up to 10
/// Hz or to the last frequency above 5 % (Balasubramanian et al. 2015, Eq. 3). Negative; nearer to
/// 0 is smoother. NaN without speed.
/// @param rate  Hz
double spectral_arc_length(std::span<const double> speed, double rate);

/// Smoothness of motion as each peer shows it, over bodies that no user moves alone, while they
/// move or are held; NaN if none did.
struct Smoothness {
  static constexpr double kCutoff = 5.0;  ///< Hz, of the high-pass
  static constexpr double kPop = 5e-3;    ///< m, larger corrections in one step are pops

  Distribution acceleration;              ///< m/s^2, second difference of the shown position
  double jerk_rms = Distribution::kNone;  ///< m/s^3, third difference
  /// m, length of the position above kCutoff.
  double high_pass_rms_m = Distribution::kNone;
  Distribution arc_length;    ///< of each stretch of motion of at least half a second
  Distribution correction_m;  ///< by agreement, per step
  double pops_per_minute = Distribution::kNone;  ///< of one peer
  /// m/s, over all bodies and steps, at rest or not: agreement must neither brake nor drive bodies.
  double speed_rms = Distribution::kNone;
  /// m/s, of each body and step in free flight.
  Distribution free_speed;
};

/// Over the local peers among `peers`.
Smoothness smoothness(std::span<const PeerRecord> peers);

/// m: length above Smoothness::kCutoff of the difference between each body's path at a local peer
/// and in `reference`, while it moves or is held.
Distribution high_pass_residual(std::span<const PeerRecord> peers, const PeerRecord& reference);

}  // namespace tandem::demos
