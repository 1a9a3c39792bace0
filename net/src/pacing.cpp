// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "pacing.h"

#include <cmath>

namespace tandem::net {

void Congestion::update(const Channels::Feedback& feedback, const RttEstimate& rtt, bool held_back,
                        std::int64_t now) {
  sum_.acked += feedback.acked;
  sum_.acked_bytes += feedback.acked_bytes;
  sum_.lost += feedback.lost;
  sum_.late += feedback.late;
  held_back_ |= held_back;
  const std::int64_t elapsed = now - period_start_;
  const std::uint64_t lost = sum_.lost - std::min(sum_.lost, sum_.late);
  const std::uint64_t packets = sum_.acked + lost;
  if (elapsed < std::max(kPeriod, 2 * rtt.smoothed())) return;
  if (packets < kEnough && elapsed < (probes_ ? kLongestProbe : kLongest)) return;
  const bool limited = held_back_;
  const double arrived =
      8e6 * static_cast<double>(sum_.acked_bytes) / static_cast<double>(elapsed);  // kbit/s
  period_start_ = now;
  sum_ = {};
  held_back_ = false;
  if (packets == 0) return;
  loss_ = static_cast<double>(lost) / static_cast<double>(packets);
  const double sent = arrived / std::max(1.0 - loss_, 0.01);

  if (now >= overlook_until_) overlooked_ = 0.0;
  if (rtt.any() && rtt.recent() - rtt.base() > kQueue) {
    rate_ *= 0.85;
    if (limited) rate_ = std::min(rate_, 0.9 * arrived);
    series_rate_ = 0.0;
  } else if (const double count = static_cast<double>(packets); is_high(loss_, count)) {
    on_loss(sent, arrived, count, now);
  } else {
    const bool clean = loss_ < std::max(0.02, overlooked_);
    if (clean || now - series_start_ > kSeries) series_rate_ = 0.0;
    if (clean && limited) rate_ *= 1.08;
  }
  rate_ = std::clamp(rate_, options_.min_kbit, options_.max_kbit);
}

bool Congestion::is_high(double loss, double packets) const {
  // Of twenty packets with 5 % loss, three are lost in every thirteenth period.
  const bool first = series_rate_ == 0.0;
  const double chance = first ? 1.5 * std::sqrt(kHigh * (1.0 - kHigh) / packets) : 0.0;
  return loss > std::max(kHigh + chance, overlooked_);
}

void Congestion::on_loss(double sent, double arrived, double packets, std::int64_t now) {
  if (series_rate_ == 0.0) {
    series_rate_ = rate_;
    series_start_ = now;
    series_loss_ = loss_;
    series_sent_ = sent;
    series_arrived_ = arrived;
    probes_ = false;
    return;  // once may be chance
  }
  if (!probes_) {
    series_loss_ = std::max(series_loss_, loss_);
    series_sent_ = std::max(series_sent_, sent);
    series_arrived_ = std::max(series_arrived_, arrived);
    probes_ = true;
    rate_ = std::min(rate_, kProbe * series_sent_);
    return;
  }
  // Packets in flight when the probe began count too: slightly above it.
  if (sent <= 1.1 * kProbe * series_sent_ && arrived <= 0.8 * series_arrived_) {
    rate_ = series_rate_;
    probes_ = false;
    const double loss = std::max(loss_, series_loss_);
    const double chance = 2.0 * std::sqrt(loss * (1.0 - loss) / packets);
    overlooked_ = 1.3 * loss + 0.05 + chance;
    overlook_until_ = now + kOverlook;
    series_rate_ = 0.0;
    return;
  }
  rate_ *= 1.0 - 0.5 * loss_;
}

}  // namespace tandem::net
