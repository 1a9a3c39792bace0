// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <chrono>
#include <thread>

namespace tandem::pbd {

/// Pause between two reads of a value that another thread will write.
inline void relax() {
#if defined(__x86_64__) || defined(__i386__)
  __builtin_ia32_pause();
#elif defined(__aarch64__)
  __asm__ __volatile__("yield");
#endif
}

/// Spin-waiting of a thread. After some time it yields: the thread that it waits for may need its
/// processor.
class Patience {
 public:
  using Clock = std::chrono::steady_clock;

  /// Call after a read without success.
  void look() {
    relax();
    if (looks_++ % kLooks != 0) return;
    const Clock::time_point now = Clock::now();
    if (looks_ == 1) since_ = now;
    longest_ = std::max(longest_, now - since_);
    if (now - since_ > kShort) std::this_thread::yield();
  }
  /// Call after success.
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
