// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace tandem::net {

/// Four readings of one exchange, ns: sent here, had there, answered there, had here. The first and
/// the last are of the own clock, the others are what the other end says of its own.
struct ClockSample {
  std::int64_t sent = 0;
  std::int64_t their_received = 0;
  std::int64_t their_sent = 0;
  std::int64_t received = 0;
};

/// How far another clock is ahead of the own one, from the exchanges with its owner. Of each period
/// the fastest way there and the fastest way back are kept, each by itself; the offset lies between
/// two lines through the best of either. What is certain is an interval, kept over all exchanges
/// and wider by kMaxDrift of what passes. docs/protocol.md ("Session time").
class ClockFilter {
 public:
  static constexpr double kMaxDrift = 250e-6;  // between two crystals, each good to 100 ppm
  static constexpr std::size_t kWindow = 64;
  static constexpr std::int64_t kLongPeriod = 1'000'000'000;  // the same for drifts()
  static constexpr std::int64_t kPeriod = 100'000'000;        // ns, for which the best is kept
  /// No reading of an honest clock is beyond; sums of these do not overflow.
  static constexpr std::int64_t kFarthest = std::int64_t{1} << 60;

  /// False where no clock that keeps to kMaxDrift gives this: nothing remains of what was known,
  /// this exchange is the first again (or is left out, where it contradicts itself).
  bool add(const ClockSample& sample);

  bool any() const { return recent_.size() > 0; }
  /// When the last exchange ended that was not left out.
  std::int64_t latest() const { return bounds_at_; }
  std::size_t size() const { return recent_.size(); }

  struct Estimate {
    std::int64_t offset = 0;  // ns, theirs minus ours
    std::int64_t low = 0;     // the offset is not below this,
    std::int64_t high = 0;    // nor above that
  };
  /// At the own time `now`, not long after the last exchange. Only where any().
  /// @param drift  of the offset, ns per ns, as far as it is known
  Estimate at(std::int64_t now, double drift) const;
  /// Drifts that fit what came in the last minute, of which the truth is one in all likelihood. All
  /// of +-kMaxDrift where there is not enough yet.
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
    Bound there;  // the offset is at most this,
    Bound back;   // and at least that
  };

  /// The best of each period, a window of them.
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
    double most = 0.0;   // what is there at `origin` by the ways there, as if it was `drift`
    double least = 0.0;  // and by the ways back
  };
  static Between between(const Ring& ring, double drift, const Bound& origin);

  Ring recent_;
  Ring long_;
  std::int64_t bounds_at_ = 0;
  std::int64_t low_ = 0;
  std::int64_t high_ = 0;
};

}  // namespace tandem::net
