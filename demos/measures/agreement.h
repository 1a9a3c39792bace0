// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <span>
#include <vector>

#include "measures/metrics.h"
#include "session/track.h"

namespace tandem::demos {

/// Of pairs of bodies that touch at either of two peers, the share that does not touch at both
/// (Jaccard distance), for each look of the first peer and the other's look nearest to it. Stacks
/// that fell differently show here, which centimetres hide. Local peers only.
std::vector<double> contact_disagreement(std::span<const PeerRecord> peers);

/// s: from the last thing that any user did other than driving what they own until no body that
/// is not owned was further apart than `tolerance` (m) any more. NaN where that never came or
/// nobody did anything.
double time_to_agree(std::span<const PeerRecord> peers, std::span<const DivergenceSample> samples,
                     double tolerance);

/// s: from the end of the sender's step to the end of the step in which the listener uses the news
/// of it: the mean age of what the listener used, and its step.
double news_age(const PeerRecord& listener, const PeerRecord& sender);

/// Of bodies that one user holds and nobody else does: how far they are apart (m), and what nobody
/// can know whom the news reach so late as the others: half the acceleration at the holder's peer,
/// mean over the age of the news, times that age squared. Both of the same samples.
struct HeldByOne {
  Distribution apart_m, limit_m;
};
HeldByOne held_by_one(std::span<const PeerRecord> peers, const EvaluationOptions& options = {});

/// m: the same limit for every body at every step of the first peer, all news being `age` (s) old:
/// nothing where no hand moves it, by a spring or as its owner. No network with this age can come
/// below these numbers, whatever it does.
Distribution limit_of_all(std::span<const PeerRecord> peers, double age,
                          const EvaluationOptions& options = {});

/// Blows that bodies get from what a user alone moves: a change of velocity of more than 2 m/s in
/// a step within 0.35 m of such a body, at its owner's peer.
struct Blow {
  consensus::SessionTime time = 0;  ///< ns
  std::uint32_t body = 0;
};
std::vector<Blow> blows(std::span<const PeerRecord> peers);

/// Divergence of bodies that were hit, after the news of it should have come and settled, and
/// before.
struct AfterBlows {
  static constexpr double kSettle = 0.15;  ///< s, after delivery
  static constexpr double kAhead = 0.05;   ///< s, a racket may hit earlier where it is foreseen
  std::size_t blows = 0;
  Distribution before_m, after_m;
};
/// @param delivery  s, from the blow until the other peer uses the news of it
AfterBlows after_blows(std::span<const PeerRecord> peers, std::span<const DivergenceSample> samples,
                       double delivery);

}  // namespace tandem::demos
