// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "clock_sync.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "tandem/pbd/portable.h"

namespace tandem::net {

using consensus::PeerId;

namespace {

constexpr SessionTime kLatestSession = SessionTime{1} << 62;  // bound in consensus
constexpr double kPull = 4e9;    // ns, time constant for closing the distance
constexpr double kLetGo = 10e9;  // ns, time constant for giving up a lost reference's rate
constexpr std::int64_t kDriftPeriod = 1'000'000'000;  // ns, interval of drift estimates
constexpr std::int64_t kTolerance = 2'000'000;        // ns, beside the bounds: clocks in transition
constexpr std::int64_t kClaimLife = 5'000'000'000;    // ns, for which a claimed rate is believed

std::int64_t scaled(double rate, std::int64_t elapsed) {
  return static_cast<std::int64_t>(std::llround(rate * static_cast<double>(elapsed)));
}

/// An honest reference needs no more than its own clock's error.
double believed(std::int32_t rate) {
  return std::clamp(1e-9 * rate, -ClockFilter::kMaxDrift, ClockFilter::kMaxDrift);
}

std::int64_t microseconds(std::uint32_t bound) { return std::int64_t{bound} * 1000; }

}  // namespace

ClockSync::ClockSync(PeerId self, bool follow, std::int64_t now, std::int64_t correction)
    : self_(self), follow_(follow), start_(now), base_(correction), base_at_(now) {}

std::int64_t ClockSync::correction(std::int64_t now) const {
  return base_ + scaled(rate_, now - base_at_);
}

void ClockSync::set_correction(std::int64_t correction, std::int64_t now) {
  base_ = correction;
  base_at_ = now;
}

void ClockSync::on_exchange(PeerId peer, const ClockSample& sample, const ClockClaim& claim) {
  PeerClock& clock = peers_[peer];
  // Keeps sums and differences of these from overflow.
  const bool sane = claim.sent > -ClockFilter::kFarthest && claim.sent < ClockFilter::kFarthest &&
                    claim.correction > -kLatestSession && claim.correction < kLatestSession &&
                    claim.sent + claim.correction > -ClockFilter::kFarthest &&
                    claim.sent + claim.correction < kLatestSession;
  if (!sane) {
    ++faults_;
    return;
  }
  // An exchange that resets the filter counts too.
  if (!clock.filter.add(sample)) ++faults_;
  if (!clock.filter.any() || clock.filter.latest() != sample.received) return;
  clock.claim = claim;
  clock.heard = sample.received;
}

ClockSync::Candidate ClockSync::candidate(PeerId peer, const PeerClock& clock,
                                          std::int64_t now) const {
  const ClockClaim& claim = clock.claim;
  const double rate = believed(claim.rate);
  // Peers in the session run at its rate, and so do we but for the drift.
  const auto estimate = clock.filter.at(now, drift_ - rate);
  const std::int64_t age =
      std::clamp<std::int64_t>(now + estimate.offset - claim.sent, 0, kClaimLife);
  const std::int64_t theirs = claim.correction + scaled(rate, age);
  return {.peer = peer,
          .target = estimate.offset + theirs,
          .low = estimate.low + theirs,
          .high = estimate.high + theirs,
          .bound = microseconds(claim.bound)};
}

ClockSync::Candidate ClockSync::choose(std::int64_t now) const {
  std::uint8_t rank = rank_;
  const auto counts = [&](const PeerClock& clock) {
    return clock.filter.any() && now - clock.heard < kStale;
  };
  for (const auto& [peer, clock] : peers_) {
    if (counts(clock)) rank = std::max(rank, clock.claim.rank);
  }
  std::vector<Candidate> candidates;
  if (rank_ == rank) {
    const std::int64_t own = correction(now);
    candidates.push_back({.peer = self_, .target = own, .low = own, .high = own});
  }
  for (const auto& [peer, clock] : peers_) {
    if (counts(clock) && clock.claim.rank == rank)
      candidates.push_back(candidate(peer, clock, now));
  }
  std::ranges::sort(candidates, {}, &Candidate::peer);
  const auto votes = [&](const Candidate& c) {
    return std::ranges::count_if(candidates, [&](const Candidate& other) {
      return c.low - kTolerance <= other.high && other.low <= c.high + kTolerance;
    });
  };
  // Sorted by id: the first of the largest.
  return *std::ranges::max_element(candidates, {}, votes);
}

void ClockSync::settle(bool together, std::int64_t now) {
  if (rank_ == Settled) return;
  if (!together) {
    together_since_ = INT64_MAX;
    if (now - start_ >= kAloneAfter) rank_ = Alone;
    return;
  }
  if (together_since_ == INT64_MAX) together_since_ = now;
  if (now - together_since_ >= kSettling) rank_ = Settled;
}

void ClockSync::follow(const Candidate& reference, std::int64_t now) {
  if (now >= drift_due_) {
    const PeerClock& clock = peers_.at(reference.peer);
    const auto fits = clock.filter.drifts();
    const double rate = believed(clock.claim.rate);
    // No further than the exchanges require.
    constexpr double kMax = 2.0 * ClockFilter::kMaxDrift;
    drift_ = std::clamp(std::clamp(drift_, fits.least + rate, fits.most + rate), -kMax, kMax);
    drift_due_ = now + kDriftPeriod;
  }
  base_ = correction(now);
  base_at_ = now;
  const std::int64_t missing = reference.target - base_;
  if (rank_ != Settled && (!jumped_ || std::llabs(missing) > kFar)) {
    base_ = reference.target;
    rate_ = drift_;
    last_ = INT64_MIN;
    jumped_ = true;
    ++jumps_;
    together_since_ = now;
    return;
  }
  const double most = std::llabs(missing) > kFar ? kMaxSlewFar : kMaxSlew;
  rate_ = drift_ + std::clamp(static_cast<double>(missing) / kPull, -most, most);
}

void ClockSync::update(std::int64_t now) {
  const Candidate reference = choose(now);
  const bool is_self = reference.peer == self_;
  bool together = !is_self;
  for (const auto& [peer, clock] : peers_) together |= clock.filter.any();
  reference_ = reference.peer;
  if (follow_) {
    if (is_self) {
      // Continue at the present rate and slowly return to the local clock's: claims are not
      // followed beyond their peer's presence. Others have taken over this time: no more jumps.
      jumped_ |= together;
      if (updated_ != INT64_MIN) {
        drift_ *= pbd::portable::exp(
            -static_cast<double>(std::max<std::int64_t>(now - updated_, 0)) / kLetGo);
      }
      base_ = correction(now);
      base_at_ = now;
      rate_ = drift_;
    } else {
      follow(reference, now);
    }
  }
  settle(together, now);
  const std::int64_t own = correction(now);
  offset_ = is_self ? 0 : reference.target - own;
  bound_ = is_self ? 0
                   : std::max({own - reference.low, reference.high - own, std::int64_t{0}}) +
                         reference.bound;
  updated_ = now;
}

SessionTime ClockSync::now(std::int64_t now) {
  last_ = std::max(last_, at(now));
  return last_;
}

ClockClaim ClockSync::claim(std::int64_t now) const {
  return {.sent = now,
          .correction = correction(now),
          .rate = static_cast<std::int32_t>(std::lround(rate_ * 1e9)),
          .bound =
              static_cast<std::uint32_t>(std::min<std::int64_t>((bound_ + 999) / 1000, UINT32_MAX)),
          .rank = rank_};
}

ClockStatus ClockSync::status(std::int64_t now) {
  // Since the last update clocks may have drifted apart.
  const std::int64_t since = updated_ == INT64_MIN ? 0 : std::max<std::int64_t>(now - updated_, 0);
  const bool is_reference = reference_ == self_;
  return {.now = this->now(now),
          .error_bound = is_reference || reference_ == 0
                             ? bound_
                             : bound_ + scaled(ClockFilter::kMaxDrift, since),
          .offset = offset_,
          .reference = reference_,
          .synchronised = rank_ == Settled,
          .jumps = jumps_,
          .faults = faults_};
}

}  // namespace tandem::net
