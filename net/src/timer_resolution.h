// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#ifdef _WIN32
#include <windows.h>
// After it.
#include <timeapi.h>
#endif

namespace tandem::net {

/// For its lifetime waits are accurate to 1 ms; the default on Windows is 16 ms.
class TimerResolution {
 public:
#ifdef _WIN32
  TimerResolution() { timeBeginPeriod(1); }
  ~TimerResolution() { timeEndPeriod(1); }
#else
  TimerResolution() = default;
#endif
  TimerResolution(const TimerResolution&) = delete;
  TimerResolution& operator=(const TimerResolution&) = delete;
};

}  // namespace tandem::net
