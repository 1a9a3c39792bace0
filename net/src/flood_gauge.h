// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>

namespace tandem::net {

/// Detects floods of useless datagrams: then reading waits for more of them, which saves calls and
/// wake-ups. Times in ns.
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
  static constexpr std::size_t kMax = 100;             // datagrams per kWindow
  static constexpr std::int64_t kWindow = 10'000'000;  // ns

  std::int64_t window_start_ = 0;
  std::size_t useless_ = 0;  // since window_start_
  bool before_ = false;      // whether the window before was flooded
};

}  // namespace tandem::net
