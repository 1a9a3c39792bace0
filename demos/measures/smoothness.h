// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <span>
#include <vector>

#include "measures/metrics.h"
#include "session/track.h"

namespace tandem::demos {

/// What is faster than `cutoff`: a Butterworth high-pass of second order, run forwards and
/// backwards, so that nothing is shifted; the gain is 1 / (1 + (cutoff/f)^4), 1/2 at the cutoff.
/// @param rate  Hz, of the samples     @param cutoff  Hz, below half the rate
std::vector<double> high_pass(std::span<const double> values, double rate, double cutoff);

/// Spectral arc length of a speed profile: the length of its normalised amplitude spectrum up to
/// 10 Hz or where it last exceeds 5 % (Balasubramanian et al. 2015, Eq. 3). Dimensionless, below 0;
/// smoother is nearer to 0. NaN where there is no speed.
/// @param rate  Hz
double spectral_arc_length(std::span<const double> speed, double rate);

/// How smoothly bodies move at the peers where they are watched. Of all that no user alone moves,
/// while it moves or is held; NaN where nothing did.
struct Smoothness {
  static constexpr double kCutoff = 5.0;  ///< Hz, of the high-pass
  static constexpr double kPop = 5e-3;    ///< m, corrections above this in one step are pops

  Distribution acceleration;  ///< m/s^2, second difference of the position as it is shown
  double jerk_rms = Distribution::kNone;  ///< m/s^3, third difference
  /// m, length of what is faster than kCutoff in the position.
  double high_pass_rms_m = Distribution::kNone;
  Distribution arc_length;    ///< of each stretch of motion of at least half a second
  Distribution correction_m;  ///< by agreement, each step
  double pops_per_minute = Distribution::kNone;  ///< of one peer
  /// m/s, of all bodies and steps, at rest or not: what agreement must neither brake nor drive.
  double speed_rms = Distribution::kNone;
  /// m/s, of each body and step in free flight.
  Distribution free_speed;
};

/// Over the local peers among `peers`.
Smoothness smoothness(std::span<const PeerRecord> peers);

/// m: length of what is faster than Smoothness::kCutoff in the difference between each body's way
/// at a local peer and its way in `reference`, while it moves or is held.
Distribution high_pass_residual(std::span<const PeerRecord> peers, const PeerRecord& reference);

}  // namespace tandem::demos
