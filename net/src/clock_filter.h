// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace tandem::net {

/// Four readings of one exchange, ns: sent here, received there, answered there, received here. The
/// first and the last are of the local clock, the others of the other end's, as reported.
struct ClockSample {
  std::int64_t sent = 0;
  std::int64_t their_received = 0;
  std::int64_t their_sent = 0;
  std::int64_t received = 0;
};

/// Offset of another clock from the local one, by exchanges with its owner. In each period the
/// fastest outward and the fastest return trip are kept separately; the offset lies between two
/// lines through the best of each. The certain bound is an interval over all exchanges, widened by
/// kMaxDrift over time. docs/protocol.md ("Session time").
class ClockFilter {
 public:
  static constexpr double kMaxDrift = 250e-6;  // between two crystals, each good to 100 ppm
  static constexpr std::size_t kWindow = 64;
  static constexpr std::int64_t kLongPeriod = 1'000'000'000;  // kPeriod for drifts()
  static constexpr std::int64_t kPeriod = 100'000'000;        // ns, interval for the best
  /// Bound on readings of honest clocks; sums of these do not overflow.
  static constexpr std::int64_t kFarthest = std::int64_t{1} << 60;

  /// False if no clock within kMaxDrift can give this sample: the filter is reset and starts with
  /// it (or skips it, if it contradicts itself).
  bool add(const ClockSample& sample);

  bool any() const { return recent_.size() > 0; }
  /// End of the last exchange that was not skipped.
  std::int64_t latest() const { return bounds_at_; }
  std::size_t size() const { return recent_.size(); }

  struct Estimate {
    std::int64_t offset = 0;  // ns, theirs minus ours
    std::int64_t low = 0;     // lower bound of the offset
    std::int64_t high = 0;    // upper bound of the offset
  };
  /// At the local time `now`, soon after the last exchange. @pre any()
  /// @param drift  of the offset, ns per ns, as far as it is known
  Estimate at(std::int64_t now, double drift) const;
  /// Drifts compatible with the exchanges of the last minute; the true one is very likely among
  /// them. All of +-kMaxDrift until there are enough.
  struct Drifts {
    double least = -kMaxDrift;
    double most = kMaxDrift;
  };
  Drifts drifts() const;
  void clear() { *this = {}; }

 private:
  struct Bound {
    std::int64_t at = 0;  // own time
    std::int64_t offset = 0;
  };
  struct Kept {
    Bound there;  // upper bound of the offset
    Bound back;   // lower bound of the offset
  };

  /// The best of each period, for a window of periods.
  class Ring {
   public:
    void add(const Kept& fresh, std::int64_t now, std::int64_t period);
    std::size_t size() const { return count_; }
    const Kept& operator[](std::size_t index) const { return kept_[index]; }

   private:
    std::array<Kept, kWindow> kept_{};
    std::size_t count_ = 0;
    std::size_t next_ = 0;
    std::int64_t start_ = 0;
  };
  struct Between {
    double most = 0.0;   // offset at `origin` by outward trips, extrapolated with `drift`
    double least = 0.0;  // offset by return trips
  };
  static Between between(const Ring& ring, double drift, const Bound& origin);

  Ring recent_;
  Ring long_;
  std::int64_t bounds_at_ = 0;
  std::int64_t low_ = 0;
  std::int64_t high_ = 0;
};

}  // namespace tandem::net
