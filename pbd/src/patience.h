// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <chrono>
#include <thread>

namespace tandem::pbd {

/// Between two looks at what another thread is to write.
inline void relax() {
#if defined(__x86_64__) || defined(__i386__)
  __builtin_ia32_pause();
#elif defined(__aarch64__)
  __asm__ __volatile__("yield");
#endif
}

/// A thread that looks again and again for what others are to do. After some time it lets others
/// have its processor: one of them may be what it waits for.
class Patience {
 public:
  using Clock = std::chrono::steady_clock;

  /// In vain.
  void look() {
    relax();
    if (looks_++ % kLooks != 0) return;
    const Clock::time_point now = Clock::now();
    if (looks_ == 1) since_ = now;
    longest_ = std::max(longest_, now - since_);
    if (now - since_ > kShort) std::this_thread::yield();
  }
  /// What it waited for has come.
  void renew() { looks_ = 0; }
  Clock::duration longest() const { return longest_; }

 private:
  static constexpr int kLooks = 64;
  static constexpr std::chrono::microseconds kShort{20};

  int looks_ = 0;
  Clock::time_point since_;
  Clock::duration longest_{};
};

}  // namespace tandem::pbd
