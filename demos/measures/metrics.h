// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string_view>
#include <vector>

#include "session/track.h"

namespace tandem::demos {

/// Statistics of a set of numbers. Percentiles are nearest-rank: the smallest number that at least
/// p % do not exceed. NaN for an empty set.
struct Distribution {
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  std::size_t count = 0;
  double mean = kNone, std = kNone;
  double p50 = kNone, p75 = kNone, p95 = kNone, p99 = kNone, max = kNone;
  double p25 = kNone;
  /// The outermost values within 1.5 times the interquartile range of the quartiles, and the share
  /// outside: box plots as in [friston] Figure 9.
  double whisker_low = kNone, whisker_high = kNone, outliers = kNone;
};

/// Reorders the values; percentiles do not depend on their order.
Distribution distribution(std::vector<double>& values);

/// Contested: two users hold the body. Moving: one holds it, or it is faster than 5 cm/s at any
/// peer.
enum class MotionClass : std::uint8_t { Resting, Moving, Contested };
inline constexpr double kMovingSpeed = 0.05;  ///< m/s

/// Owned: one user alone moves it. Held: some user's spring holds it. Otherwise by its fastest
/// instance: Resting up to kMovingSpeed; above it, Touching if it has a contact at any peer, Free
/// if not.
enum class ObjectClass : std::uint8_t { Resting, Touching, Free, Held, Owned };
inline constexpr std::size_t kObjectClasses = 5;
std::string_view to_string(ObjectClass object);

/// Distance between the instances of one body at one session time.
struct DivergenceSample {
  consensus::SessionTime time = 0;  ///< ns
  std::uint32_t body = 0;
  MotionClass motion = MotionClass::Resting;
  ObjectClass object = ObjectClass::Resting;
  bool jumped = false;    ///< its owner teleported it, and the others may not know yet
  double distance = 0.0;  ///< m, between the centres; maximum over pairs of peers
  double angle = 0.0;     ///< rad, geodesic; maximum over pairs
};

struct EvaluationOptions {
  /// ns: a peer with a larger gap between samples was away in it.
  consensus::SessionTime max_gap = std::numeric_limits<consensus::SessionTime>::max();
  /// ns: for this long after a teleport divergence is latency, not disagreement.
  consensus::SessionTime jump_window = 300'000'000;
};

/// Divergence at each sample of the first peer with at least two peers present, from the first
/// exchange on (from the start if there was none). No outliers are removed.
std::vector<DivergenceSample> divergence(std::span<const PeerRecord> peers,
                                         const EvaluationOptions& options = {});

/// The class of a body from its instances at one time. @param owned  one user alone moves it
ObjectClass object_class(std::span<const TrackSample> instances, bool owned);

/// m: distance of each prediction from the true position of the sender's instance at the predicted
/// time, if the sender's track covers that time.
std::vector<double> prediction_errors(std::span<const PeerRecord> peers,
                                      const EvaluationOptions& options = {});

/// Results of a run. NaN = unknown.
struct Metrics {
  Distribution divergence_m, contested_m, moving_m, resting_m;
  Distribution divergence_deg;
  /// By class, without teleports.
  std::array<Distribution, kObjectClasses> object_m;
  Distribution calm_m;                     ///< divergence without owned bodies that were teleported
  Distribution shared_m, shared_moving_m;  ///< of unowned bodies; of those not at rest
  std::size_t jumps = 0;                   ///< teleports by owners
  Distribution prediction_error_m;
  Distribution latency_ms;                    ///< from the sender's step to each use of the update
  Distribution step_ms;                       ///< wall time of the solver's step
  Distribution penetration_m;                 ///< of overlapping pairs
  double parse_us = Distribution::kNone;      ///< CPU time per update
  double process_us = Distribution::kNone;    ///< CPU time per update
  double aggregate_us = Distribution::kNone;  ///< CPU time per shared body and step
  double targets_us = Distribution::kNone;  ///< wall time of Stage::Agree, per shared body and step
  double step_cpu_us = Distribution::kNone;       ///< CPU time of one peer's step, with agreement
  double peak_speed = Distribution::kNone;        ///< m/s, of unowned bodies
  double bytes_per_second = Distribution::kNone;  ///< payload sent by one peer, mean over peers
  pbd::ConsensusEnergy energy;                    ///< sum over peers and steps, J
  std::uint64_t hash = 0;                         ///< of all worlds
  std::vector<DivergenceSample> samples;
};

Metrics evaluate(std::span<const PeerRecord> peers, const EvaluationOptions& options = {});

}  // namespace tandem::demos
