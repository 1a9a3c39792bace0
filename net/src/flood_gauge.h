// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>

namespace tandem::net {

/// Whether so many datagrams are of no use that more should be let come together before they are
/// looked at: one call and one awakening for many. Times in ns.
class FloodGauge {
 public:
  void count_useless() { ++useless_; }
  bool is_flooded(std::int64_t now) {
    if (now - window_start_ > kWindow) {
      before_ = useless_ > kMax;
      useless_ = 0;
      window_start_ = now;
    }
    return before_ || useless_ > kMax;
  }

 private:
  static constexpr std::size_t kMax = 100;             // datagrams in
  static constexpr std::int64_t kWindow = 10'000'000;  // ns

  std::int64_t window_start_ = 0;
  std::size_t useless_ = 0;  // since then
  bool before_ = false;      // flooded in the window before
};

}  // namespace tandem::net
