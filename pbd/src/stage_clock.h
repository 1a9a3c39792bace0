// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <chrono>
#include <span>

#include "tandem/pbd/report.h"
#include "tandem/pbd/stage_observer.h"

namespace tandem::pbd {

/// Adds the time since the last call to a stage, and tells the observer, if any.
class StageClock {
 public:
  void start(bool enabled, StageObserver* observer) {
    seconds_.fill(0.0);
    observer_ = observer;
    enabled_ = enabled || observer != nullptr;
    if (enabled_) last_ = std::chrono::steady_clock::now();
  }
  void stop(Stage stage) {
    if (!enabled_) return;
    const auto now = std::chrono::steady_clock::now();
    seconds_[static_cast<std::size_t>(stage)] += std::chrono::duration<double>(now - last_).count();
    if (observer_ != nullptr) observer_->on_stage(stage, last_, now);
    last_ = now;
  }
  /// Distributes the time since the last call over stages in proportion to these clocks, which ran
  /// in parallel.
  void share_out(std::span<const StageClock> clocks) {
    if (!enabled_) return;
    std::array<double, kStageCount> seconds{};
    double sum = 0.0;
    for (const StageClock& clock : clocks) {
      for (std::size_t i = 0; i < kStageCount; ++i) {
        seconds[i] += clock.seconds_[i];
        sum += clock.seconds_[i];
      }
    }
    const auto now = std::chrono::steady_clock::now();
    const double all = std::chrono::duration<double>(now - last_).count();
    for (std::size_t i = 0; i < kStageCount && sum > 0.0; ++i) {
      seconds_[i] += all * seconds[i] / sum;
    }
    last_ = now;
  }
  const std::array<double, kStageCount>& seconds() const { return seconds_; }

 private:
  std::array<double, kStageCount> seconds_{};
  std::chrono::steady_clock::time_point last_;
  StageObserver* observer_ = nullptr;
  bool enabled_ = false;
};

}  // namespace tandem::pbd
