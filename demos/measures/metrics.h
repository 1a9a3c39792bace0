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

/// Of a set of numbers. Percentiles are nearest-rank: the smallest number that at least p % of all
/// are not above. NaN where there are no numbers.
struct Distribution {
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  std::size_t count = 0;
  double mean = kNone, std = kNone;
  double p50 = kNone, p75 = kNone, p95 = kNone, p99 = kNone, max = kNone;
  double p25 = kNone;
  /// The outermost values within 1.5 times the distance between the quartiles beyond them, and the
  /// share of all that lies outside: as [friston] Figure 9 draws boxes.
  double whisker_low = kNone, whisker_high = kNone, outliers = kNone;
};

/// Reorders the values. The order they come in makes no difference to the percentiles.
Distribution distribution(std::vector<double>& values);

/// Contested: two users hold the body. Moving: one does, or it is faster than 5 cm/s at any peer.
enum class MotionClass : std::uint8_t { Resting, Moving, Contested };
inline constexpr double kMovingSpeed = 0.05;  ///< m/s

/// What a body does, finer: Owned: one user alone moves it. Held: some user's spring holds it.
/// Else by its fastest instance: Resting up to kMovingSpeed; above, Touching where it feels a
/// contact at any peer, Free where it does not.
enum class ObjectClass : std::uint8_t { Resting, Touching, Free, Held, Owned };
inline constexpr std::size_t kObjectClasses = 5;
std::string_view to_string(ObjectClass object);

/// How far the instances of one body are apart at one session time.
struct DivergenceSample {
  consensus::SessionTime time = 0;  ///< ns
  std::uint32_t body = 0;
  MotionClass motion = MotionClass::Resting;
  ObjectClass object = ObjectClass::Resting;
  bool jumped = false;    ///< its owner has put it somewhere else, and the others may not know yet
  double distance = 0.0;  ///< m, between the centres; largest of all pairs of peers
  double angle = 0.0;     ///< rad, geodesic; largest of all pairs
};

struct EvaluationOptions {
  /// ns: a peer whose samples are further apart was away in between.
  consensus::SessionTime max_gap = std::numeric_limits<consensus::SessionTime>::max();
  /// ns: so long after a jump its divergence is news on the way, not disagreement.
  consensus::SessionTime jump_window = 300'000'000;
};

/// Divergence at each sample of the first peer, from the first exchange on (from the start where
/// there was none), where at least two peers are there. Nothing is left out as an outlier.
std::vector<DivergenceSample> divergence(std::span<const PeerRecord> peers,
                                         const EvaluationOptions& options = {});

/// The class of a body from its instances at one time. @param owned  one user alone moves it
ObjectClass object_class(std::span<const TrackSample> instances, bool owned);

/// m: of each prediction, its distance from the true position of the sender's instance at the time
/// it was carried to; those to times that the sender's track does not cover are left out.
std::vector<double> prediction_errors(std::span<const PeerRecord> peers,
                                      const EvaluationOptions& options = {});

/// What a run comes to. NaN = unknown.
struct Metrics {
  Distribution divergence_m, contested_m, moving_m, resting_m;
  Distribution divergence_deg;
  /// Of each class, jumps left out.
  std::array<Distribution, kObjectClasses> object_m;
  Distribution calm_m;                     ///< divergence of all but owned bodies that jumped
  Distribution shared_m, shared_moving_m;  ///< of what nobody owns; of that what does not rest
  std::size_t jumps = 0;                   ///< how often an owner put a body somewhere else
  Distribution prediction_error_m;
  Distribution latency_ms;                    ///< from the sender's step to each use of the update
  Distribution step_ms;                       ///< wall time of the solver's step
  Distribution penetration_m;                 ///< of the pairs that overlap
  double parse_us = Distribution::kNone;      ///< CPU time, each update
  double process_us = Distribution::kNone;    ///< CPU time, each update
  double aggregate_us = Distribution::kNone;  ///< CPU time, each shared body and step
  double targets_us = Distribution::kNone;    ///< wall time of Stage::Agree, likewise
  double step_cpu_us = Distribution::kNone;   ///< CPU time of one peer's step, its peer's included
  double peak_speed = Distribution::kNone;    ///< m/s, of what nobody owns
  double bytes_per_second = Distribution::kNone;  ///< payload sent by one peer, mean over peers
  pbd::ConsensusEnergy energy;                    ///< sum over peers and steps, J
  std::uint64_t hash = 0;                         ///< of all worlds
  std::vector<DivergenceSample> samples;
};

Metrics evaluate(std::span<const PeerRecord> peers, const EvaluationOptions& options = {});

}  // namespace tandem::demos
