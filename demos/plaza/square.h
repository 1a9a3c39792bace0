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

/// The time of a square whose people are all in this process. It goes as fast as the wall's, or as
/// slow as the machine is: a step begins when all have made the one before. So nobody is ever late,
/// and what is counted in a second of it does not depend on how many cores there are.
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
  std::atomic<std::int64_t> began_ = wall();  ///< of the step, on the wall
};

/// Quantiles of a few numbers.
struct Spread {
  double p50 = 0.0;
  double p95 = 0.0;
  double p99 = 0.0;
  double most = 0.0;
};
Spread spread_of(std::vector<double> values);

/// What a run came to.
struct SquareReport {
  double session_s = 0.0;
  double wall_s = 0.0;
  double cpu_s = 0.0;    ///< of this process while people were there, user and system
  double kbit_in = 0.0;  ///< per person and session second, of payloads of NATS and UDP
  double kbit_out = 0.0;
  double messages_in = 0.0;  ///< per person and session second
  double messages_out = 0.0;
  double direct_in = 0.0;         ///< of these, by UDP
  double direct_out = 0.0;        ///< likewise
  double connected = 0.0;         ///< peers of a person, mean
  double direct = 0.0;            ///< of them spoken to by UDP alone
  double simulated = 0.0;         ///< bodies of a person, mean
  double cells = 0.0;             ///< listened to
  double summaries = 0.0;         ///< heard, per person and session second
  std::uint32_t people_told = 0;  ///< most that anybody was told of
  Spread moving_mm;               ///< between the copies of two who are connected, while it moves
  Spread resting_mm;
  std::uint64_t taken = 0;
  std::uint64_t crossings = 0;
  std::uint64_t written = 0;
  std::uint64_t refused = 0;
  std::size_t bodies_lost = 0;   ///< of which there is no record at the end
  std::size_t bodies_twice = 0;  ///< that are found in two cells at the end
};

/// All people, and who looks at them from above.
class Square {
 public:
  explicit Square(const PlazaOptions& options);
  ~Square();

  /// @return what came of it
  SquareReport run();

 private:
  void lay_out();
  void arrive();
  void look();
  void tell(double time);
  /// All that is counted from the beginning on: bytes and messages in and out, and summaries heard.
  std::array<double, 7> counts() const;
  /// What is averaged over the run.
  void sample();
  /// @param before  counts() where the run began
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
