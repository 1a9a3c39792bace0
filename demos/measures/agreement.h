// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <span>
#include <vector>

#include "measures/metrics.h"
#include "session/track.h"

namespace tandem::demos {

/// Jaccard distance of the pairs in contact at two peers, per look of the first peer and the
/// other's nearest look. It shows stacks that fell differently, which distances in centimetres
/// hide. Local peers only.
std::vector<double> contact_disagreement(std::span<const PeerRecord> peers);

/// s, from the last action of any user (other than moving bodies they own) until no unowned body
/// was more than `tolerance` (m) apart. NaN if that never happened or nobody acted.
double time_to_agree(std::span<const PeerRecord> peers, std::span<const DivergenceSample> samples,
                     double tolerance);

/// s, from the end of the sender's step to the end of the step in which the listener uses it: the
/// mean age of used updates plus the listener's step.
double news_age(const PeerRecord& listener, const PeerRecord& sender);

/// Bodies held by exactly one user. apart_m: distance of the copies, m. limit_m: the unavoidable
/// error with updates of this age: half the holder's mean acceleration over the age, times age
/// squared. Both over the same samples.
struct HeldByOne {
  Distribution apart_m, limit_m;
};
HeldByOne held_by_one(std::span<const PeerRecord> peers, const EvaluationOptions& options = {});

/// m: the same limit for every body at every step of the first peer, with all updates `age` (s)
/// old; 0 for bodies that no user moves. No method can do better with this age.
Distribution limit_of_all(std::span<const PeerRecord> peers, double age,
                          const EvaluationOptions& options = {});

/// An impact from a body that a user alone moves: the velocity changes by more than 2 m/s in a step
/// within 0.35 m of such a body, at its owner's peer.
struct Blow {
  consensus::SessionTime time = 0;  ///< ns
  std::uint32_t body = 0;
};
std::vector<Blow> blows(std::span<const PeerRecord> peers);

/// Divergence of impacted bodies after the update should have arrived and settled, and before.
struct AfterBlows {
  static constexpr double kSettle = 0.15;  ///< s, after delivery
  static constexpr double kAhead = 0.05;   ///< s, a peer that predicts the racket may hit earlier
  std::size_t blows = 0;
  Distribution before_m, after_m;
};
/// @param delivery  s, from the impact until the other peer uses its update
AfterBlows after_blows(std::span<const PeerRecord> peers, std::span<const DivergenceSample> samples,
                       double delivery);

}  // namespace tandem::demos
