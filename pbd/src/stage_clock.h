// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <chrono>

#include "tandem/pbd/report.h"

namespace tandem::pbd {

/// Adds the time since the last call to a stage.
class StageClock {
 public:
  void start(bool enabled) {
    seconds_.fill(0.0);
    enabled_ = enabled;
    if (enabled_) last_ = std::chrono::steady_clock::now();
  }
  void stop(Stage stage) {
    if (!enabled_) return;
    const auto now = std::chrono::steady_clock::now();
    seconds_[static_cast<std::size_t>(stage)] += std::chrono::duration<double>(now - last_).count();
    last_ = now;
  }
  const std::array<double, kStageCount>& seconds() const { return seconds_; }

 private:
  std::array<double, kStageCount> seconds_{};
  std::chrono::steady_clock::time_point last_;
  bool enabled_ = false;
};

}  // namespace tandem::pbd
