// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "common/track.h"

namespace tandem::demos {

/// Of a set of numbers. Percentiles are nearest-rank: the smallest number that at least p % of all
/// are not above. NaN where there are no numbers.
struct Distribution {
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  std::size_t count = 0;
  double mean = kNone, std = kNone;
  double p50 = kNone, p75 = kNone, p95 = kNone, p99 = kNone, max = kNone;
};

/// Reorders the values. The order they come in makes no difference to the percentiles.
Distribution distribution(std::vector<double>& values);

/// Contested: two users hold the body. Moving: one does, or it is faster than 5 cm/s at any peer.
enum class MotionClass : std::uint8_t { Resting, Moving, Contested };
inline constexpr double kMovingSpeed = 0.05;  ///< m/s

/// How far the instances of one body are apart at one session time.
struct DivergenceSample {
  consensus::SessionTime time = 0;  ///< ns
  std::uint32_t body = 0;
  MotionClass motion = MotionClass::Resting;
  double distance = 0.0;  ///< m, between the centres; largest of all pairs of peers
  double angle = 0.0;     ///< rad, geodesic; largest of all pairs
};

struct EvaluationOptions {
  /// ns: a peer whose samples are further apart was away in between.
  consensus::SessionTime max_gap = std::numeric_limits<consensus::SessionTime>::max();
};

/// Divergence at each sample of the first peer, from the first exchange on (from the start where
/// there was none), where at least two peers are there. Nothing is left out as an outlier.
std::vector<DivergenceSample> divergence(std::span<const PeerRecord> peers,
                                         const EvaluationOptions& options = {});

/// m: of each prediction, its distance from the true position of the sender's instance at the time
/// it was carried to; those to times that the sender's track does not cover are left out.
std::vector<double> prediction_errors(std::span<const PeerRecord> peers,
                                      const EvaluationOptions& options = {});

/// What a run comes to. NaN = unknown.
struct Metrics {
  Distribution divergence_m, contested_m, moving_m, resting_m;
  Distribution divergence_deg;
  Distribution prediction_error_m;
  Distribution latency_ms;                    ///< from the sender's step to each use of the update
  Distribution step_ms;                       ///< wall time of the solver's step
  Distribution penetration_m;                 ///< of the pairs that overlap
  double parse_us = Distribution::kNone;      ///< CPU time, each update
  double process_us = Distribution::kNone;    ///< CPU time, each update
  double aggregate_us = Distribution::kNone;  ///< CPU time, each shared body and step
  double bytes_per_second = Distribution::kNone;  ///< payload sent by one peer, mean over peers
  pbd::ConsensusEnergy energy;                    ///< sum over peers and steps, J
  std::uint64_t hash = 0;                         ///< of all worlds
  std::vector<DivergenceSample> samples;
};

Metrics evaluate(std::span<const PeerRecord> peers, const EvaluationOptions& options = {});

}  // namespace tandem::demos
