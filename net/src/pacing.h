// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "channels.h"
#include "packet_protection.h"
#include "rtt.h"

namespace tandem::net {

/// Token bucket in bits. A datagram may leave while the bucket is not empty, and may overdraw it:
/// over any time T at most rate * T + burst + one datagram leaves.
class Pacer {
 public:
  Pacer(double kbit_per_s, std::int64_t now) : at_(now) { set_rate(kbit_per_s, now); }

  void set_rate(double kbit_per_s, std::int64_t now) {
    fill(now);
    rate_ = kbit_per_s;
    burst_ = std::max(kMinBurst, rate_ * 1e3 * kBurstTime);
    tokens_ = std::min(tokens_, burst_);
  }
  double rate() const { return rate_; }

  bool ready(std::int64_t now) {
    fill(now);
    return tokens_ > 0.0;
  }
  void spend(std::size_t datagram_bytes) {
    tokens_ -= 8.0 * static_cast<double>(datagram_bytes + kIpUdpBytes);
  }
  /// When ready() becomes true.
  std::int64_t next(std::int64_t now) {
    fill(now);
    return tokens_ > 0.0 ? now : now + 1 + static_cast<std::int64_t>(-tokens_ / rate_ * 1e6);
  }

 private:
  static constexpr double kBurstTime = 0.02;         // s of the rate
  static constexpr double kMinBurst = 8.0 * 1200.0;  // bit

  void fill(std::int64_t now) {
    if (now <= at_) return;
    tokens_ = std::min(burst_, tokens_ + static_cast<double>(now - at_) * 1e-6 * rate_);
    at_ = now;
  }

  double rate_ = 0.0;  // kbit/s, which is bit/ms
  double burst_ = 0.0;
  double tokens_ = 0.0;
  std::int64_t at_;
};

struct CongestionOptions {
  double min_kbit = 32.0;   ///< kbit/s, never below
  double max_kbit = 256.0;  ///< the budget; also where it starts
};

/// Sets the rate of a link within its limits, once a period, from loss and delay. Rules in
/// docs/protocol.md ("Rate"): those on loss are from Google's congestion control
/// (draft-ietf-rmcat-gcc-02, Sec. 6), the one on delay is simpler, and the one on loss by other
/// traffic is our own.
class Congestion {
 public:
  Congestion(const CongestionOptions& options, std::int64_t now)
      : options_(options), rate_(options.max_kbit), period_start_(now) {}

  /// @param held_back  whether the pacer has delayed something
  void update(const Channels::Feedback& feedback, const RttEstimate& rtt, bool held_back,
              std::int64_t now);
  double rate() const { return rate_; }
  /// Fraction of packets lost in the last period.
  double loss() const { return loss_; }

 private:
  static constexpr std::int64_t kPeriod = 200'000'000;
  static constexpr std::int64_t kLongest = 2'000'000'000;
  static constexpr std::int64_t kLongestProbe = 600'000'000;
  static constexpr std::int64_t kQueue = 50'000'000;
  static constexpr std::int64_t kOverlook = 120'000'000'000;
  static constexpr std::int64_t kSeries = 5'000'000'000;
  static constexpr double kHigh = 0.10;         // fraction of packets lost
  static constexpr double kProbe = 0.6;         // fraction of the rate sent
  static constexpr std::uint64_t kEnough = 20;  // packets

  bool is_high(double loss, double packets) const;
  void on_loss(double sent, double arrived, double packets, std::int64_t now);

  CongestionOptions options_;
  double rate_;
  double loss_ = 0.0;
  std::int64_t period_start_;
  Channels::Feedback sum_;
  bool held_back_ = false;
  double series_rate_ = 0.0;  // before the first decrease for loss; 0 = none yet
  std::int64_t series_start_ = 0;
  bool probes_ = false;
  double series_loss_ = 0.0;
  double series_sent_ = 0.0;     // kbit/s
  double series_arrived_ = 0.0;  // kbit/s
  double overlooked_ = 0.0;
  std::int64_t overlook_until_ = INT64_MIN;
};

/// The rate of a link and its pacer.
class SendRate {
 public:
  SendRate(const CongestionOptions& options, std::int64_t now)
      : options_(options), congestion_(options, now), pacer_(options.max_kbit, now) {}

  void update(const Channels::Feedback& feedback, const RttEstimate& rtt, std::int64_t now) {
    congestion_.update(feedback, rtt, std::exchange(held_back_, false), now);
    if (congestion_.rate() != pacer_.rate()) pacer_.set_rate(congestion_.rate(), now);
  }
  /// The pacer has delayed something.
  void hold_back() { held_back_ = true; }
  Pacer& pacer() { return pacer_; }
  const Congestion& congestion() const { return congestion_; }
  /// Start over on a new path.
  void begin_path(std::int64_t now) {
    congestion_ = Congestion(options_, now);
    pacer_.set_rate(congestion_.rate(), now);
  }

 private:
  CongestionOptions options_;
  Congestion congestion_;
  Pacer pacer_;
  bool held_back_ = false;
};

}  // namespace tandem::net
