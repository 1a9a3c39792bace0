// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "peer/recent_quantiles.h"

#include <algorithm>
#include <cmath>

namespace tandem::demos {

void RecentQuantiles::add(double value) {
  if (std::isnan(value)) return;
  ++count_;
  sum_ += value;
  const double place = std::log(std::max(value, kMin) / kMin) / std::log(kRatio);
  ++now_[std::min(static_cast<std::size_t>(std::min(place, 1e3)), kBins - 1)];
}

void RecentQuantiles::turn() {
  before_ = now_;
  now_ = {};
}

double RecentQuantiles::quantile(double q) const {
  std::uint64_t all = 0;
  for (std::size_t i = 0; i < kBins; ++i) all += now_[i] + before_[i];
  if (all == 0) return 0.0;
  const double rank = std::max(1.0, std::ceil(q * static_cast<double>(all)));
  double below = 0.0;
  for (std::size_t i = 0; i < kBins; ++i) {
    below += static_cast<double>(now_[i]) + static_cast<double>(before_[i]);
    // The bin's geometric centre.
    if (below >= rank) return kMin * std::pow(kRatio, static_cast<double>(i) + 0.5);
  }
  return kMin * std::pow(kRatio, static_cast<double>(kBins));
}

}  // namespace tandem::demos
