// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <functional>
#include <utility>

#include "tandem/consensus/predictor.h"

namespace tandem::consensus::testing {

/// A body that has always moved as a function of session time says, and is known until `now`.
class KnownMotion final : public MotionHistory {
 public:
  using Path = std::function<MotionSample(SessionTime)>;

  /// At rest in the origin.
  explicit KnownMotion(SessionTime now)
      : KnownMotion(now, [](SessionTime time) { return MotionSample{.time = time}; }) {}
  KnownMotion(SessionTime now, Path path) : now_(now), path_(std::move(path)) {}

  MotionSample newest() const override { return path_(now_); }
  MotionSample at_time(SessionTime time) const override { return path_(std::min(time, now_)); }

 private:
  SessionTime now_;
  Path path_;
};

}  // namespace tandem::consensus::testing
