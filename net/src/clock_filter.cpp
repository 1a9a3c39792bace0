// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "clock_filter.h"

#include <algorithm>
#include <cmath>

namespace tandem::net {

namespace {

constexpr std::int64_t kGrain = 1000;  // ns, granularity of clocks and rounding

std::int64_t drifted(std::int64_t elapsed) {
  return static_cast<std::int64_t>(
      std::ceil(ClockFilter::kMaxDrift * static_cast<double>(std::max<std::int64_t>(elapsed, 0))));
}

bool is_near(std::int64_t time) {
  return time > -ClockFilter::kFarthest && time < ClockFilter::kFarthest;
}

}  // namespace

bool ClockFilter::add(const ClockSample& sample) {
  if (!is_near(sample.their_received) || !is_near(sample.their_sent)) return false;
  const std::int64_t elapsed = sample.received - sample.sent;
  const std::int64_t held = sample.their_sent - sample.their_received;
  const std::int64_t slack = drifted(elapsed) + kGrain;
  if (elapsed < 0 || held < 0 || held > elapsed + slack) return false;

  // Theirs minus ours: bounded above by the outward trip, below by the return trip.
  const std::int64_t high = sample.their_received - sample.sent + slack;
  const std::int64_t low = sample.their_sent - sample.received - slack;
  const Kept fresh{.there = {.at = sample.sent, .offset = sample.their_received - sample.sent},
                   .back = {.at = sample.received, .offset = sample.their_sent - sample.received}};
  bool honest = true;
  if (any()) {
    const std::int64_t wider = drifted(sample.received - bounds_at_);
    const std::int64_t new_low = std::max(low, low_ - wider);
    const std::int64_t new_high = std::min(high, high_ + wider);
    honest = new_low <= new_high;
    if (honest) {
      low_ = new_low;
      high_ = new_high;
    } else {
      clear();
    }
  }
  if (!any()) {
    low_ = low;
    high_ = high;
  }
  bounds_at_ = sample.received;
  recent_.add(fresh, sample.received, kPeriod);
  long_.add(fresh, sample.received, kLongPeriod);
  return honest;
}

void ClockFilter::Ring::add(const Kept& fresh, std::int64_t now, std::int64_t period) {
  if (count_ > 0 && now - start_ < period) {
    // Within a period drift does not matter.
    Kept& latest = kept_[(next_ + kWindow - 1) % kWindow];
    if (fresh.there.offset < latest.there.offset) latest.there = fresh.there;
    if (fresh.back.offset > latest.back.offset) latest.back = fresh.back;
    return;
  }
  start_ = now;
  kept_[next_] = fresh;
  next_ = (next_ + 1) % kWindow;
  count_ = std::min(count_ + 1, kWindow);
}

ClockFilter::Between ClockFilter::between(const Ring& ring, double drift, const Bound& origin) {
  // Relative to one reading, as differences are small and readings are not.
  const auto moved = [&](const Bound& bound) {
    return static_cast<double>(bound.offset - origin.offset) +
           drift * static_cast<double>(origin.at - bound.at);
  };
  Between out{.most = moved(ring[0].there), .least = moved(ring[0].back)};
  for (std::size_t i = 1; i < ring.size(); ++i) {
    out.most = std::min(out.most, moved(ring[i].there));
    out.least = std::max(out.least, moved(ring[i].back));
  }
  return out;
}

ClockFilter::Estimate ClockFilter::at(std::int64_t now, double drift) const {
  const Bound origin{.at = now, .offset = recent_[0].there.offset};
  const Between fits = between(recent_, drift, origin);
  const std::int64_t wider = drifted(now - bounds_at_);
  Estimate out{.offset = origin.offset + std::llround(0.5 * (fits.least + fits.most)),
               .low = low_ - wider,
               .high = high_ + wider};
  out.offset = std::clamp(out.offset, out.low, out.high);
  return out;
}

ClockFilter::Drifts ClockFilter::drifts() const {
  constexpr std::size_t kEnough = 4;
  if (long_.size() < kEnough) return {};
  // The room between the two lines is largest when their slope is the drift: a function with a
  // single peak.
  const Bound origin{.at = bounds_at_, .offset = long_[0].there.offset};
  const auto room = [&](double drift) {
    const Between fits = between(long_, drift, origin);
    return fits.most - fits.least;
  };
  double low = -kMaxDrift;
  double high = kMaxDrift;
  for (int i = 0; i < 40; ++i) {
    const double third = (high - low) / 3.0;
    if (room(low + third) < room(high - third)) {
      low += third;
    } else {
      high -= third;
    }
  }
  const double best = 0.5 * (low + high);
  // Average distance of the lines from a delay-free exchange: among so many, the best.
  double excess = 0.0;
  for (std::size_t i = 0; i < long_.size(); ++i) {
    excess += static_cast<double>(long_[i].there.offset - long_[i].back.offset) +
              best * static_cast<double>(long_[i].back.at - long_[i].there.at);
  }
  const auto count = static_cast<double>(long_.size());
  const double enough =
      room(best) - 2.0 * std::max(0.0, excess / count - room(best)) / count - kGrain;
  const auto edge = [&](double inside, double outside) {
    if (room(outside) >= enough) return outside;
    for (int i = 0; i < 20; ++i) {
      const double middle = 0.5 * (inside + outside);
      (room(middle) >= enough ? inside : outside) = middle;
    }
    return inside;
  };
  return {.least = edge(best, -kMaxDrift), .most = edge(best, kMaxDrift)};
}

}  // namespace tandem::net
