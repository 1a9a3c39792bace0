// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <ctime>

namespace tandem::pbd {

/// s: CPU time of the calling thread, or of the process where threads have none.
inline double thread_cpu_seconds() {
#ifdef CLOCK_THREAD_CPUTIME_ID
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
#else
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
#endif
}

/// Adds the CPU time (s) that the calling thread spends in a scope to a sum.
class CpuTimer {
 public:
  explicit CpuTimer(double& sum) : sum_(sum), start_(thread_cpu_seconds()) {}
  ~CpuTimer() { sum_ += thread_cpu_seconds() - start_; }
  CpuTimer(const CpuTimer&) = delete;
  CpuTimer& operator=(const CpuTimer&) = delete;

 private:
  double& sum_;
  double start_;
};

/// CPU time of consecutive pieces of work, with one clock reading each: a reading costs as much as
/// handling a small packet.
class CpuLaps {
 public:
  /// Adds the time (s) since the last reading.
  void add(double& sum) {
    const double now = thread_cpu_seconds();
    sum += now - last_;
    last_ = now;
  }

 private:
  double last_ = thread_cpu_seconds();
};

}  // namespace tandem::pbd
