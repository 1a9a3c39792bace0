// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include "plaza/visitor.h"

namespace tandem::demos {

/// The time of a square whose people are all in this process: wall time, or slower on a slow
/// machine. A step begins when all have finished the one before, so rates do not depend on the
/// number of cores.
/// @par Thread safety  now(): from any thread.
class SquareClock {
 public:
  explicit SquareClock(std::int64_t step) : step_(step) {}

  std::int64_t now() const;
  /// Waits until the next step may begin. @return its beginning, ns
  std::int64_t begin_step();

 private:
  using Steady = std::chrono::steady_clock;
  static std::int64_t wall();

  std::int64_t step_;  ///< ns
  std::atomic<std::int64_t> base_ = 1'000'000'000;
  std::atomic<std::int64_t> began_ = wall();  ///< of the step, wall time
};

struct Spread {
  double p50 = 0.0;
  double p95 = 0.0;
  double p99 = 0.0;
  double most = 0.0;
};
Spread spread_of(std::vector<double> values);

struct SquareReport {
  double session_s = 0.0;
  double wall_s = 0.0;
  double cpu_s = 0.0;    ///< of this process while people were present, user and system
  double kbit_in = 0.0;  ///< per person and session second, payloads of NATS and UDP
  double kbit_out = 0.0;
  double messages_in = 0.0;  ///< per person and session second
  double messages_out = 0.0;
  double direct_in = 0.0;         ///< of these, by UDP
  double direct_out = 0.0;        ///< by UDP
  double connected = 0.0;         ///< peers per person, mean
  double direct = 0.0;            ///< of them by UDP alone
  double simulated = 0.0;         ///< bodies per person, mean
  double cells = 0.0;             ///< subscribed
  double summaries = 0.0;         ///< received, per person and session second
  std::uint32_t people_told = 0;  ///< maximum known to one person
  Spread moving_mm;               ///< between the copies of two connected people, while it moves
  Spread resting_mm;
  std::uint64_t taken = 0;
  std::uint64_t crossings = 0;
  std::uint64_t written = 0;
  std::uint64_t refused = 0;
  std::size_t bodies_lost = 0;   ///< without a record at the end
  std::size_t bodies_twice = 0;  ///< in two cells at the end
};

/// All people, and an observer above.
class Square {
 public:
  explicit Square(const PlazaOptions& options);
  ~Square();

  /// -
  SquareReport run();

 private:
  void lay_out();
  void arrive();
  void look();
  void tell(double time);
  /// Totals since the start: bytes and messages in and out, and summaries heard.
  std::array<double, 7> counts() const;
  /// Adds samples to the averages.
  void sample();
  /// @param before  counts() at the start of the run
  void sum_up(const std::array<double, 7>& before);
  void census();

  PlazaOptions options_;
  SquareClock clock_;
  std::vector<std::shared_ptr<nats::NatsHub>> hubs_;
  std::vector<std::unique_ptr<Visitor>> people_;
  SquareReport report_;
  std::size_t samples_ = 0;
  std::vector<double> moving_;  ///< mm, since the last tell()
  std::vector<double> resting_;
  std::vector<double> all_moving_;
  std::vector<double> all_resting_;
  std::map<consensus::SharedId, pbd::Vec3> before_;
};

}  // namespace tandem::demos
