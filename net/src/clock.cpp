// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/net/clock.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "require.h"

namespace tandem::net {

namespace {

template <class Clock>
std::int64_t reading_of() {
  using std::chrono::duration_cast, std::chrono::nanoseconds;
  return duration_cast<nanoseconds>(Clock::now().time_since_epoch()).count();
}

/// ns, system clock minus steady clock: read between two close readings of the steady clock, as a
/// reading may be interrupted.
std::int64_t system_offset() {
  std::int64_t closest = INT64_MAX, offset = 0;
  for (int reading = 0; reading < 5; ++reading) {
    const std::int64_t before = reading_of<std::chrono::steady_clock>();
    const std::int64_t system = reading_of<std::chrono::system_clock>();
    const std::int64_t after = reading_of<std::chrono::steady_clock>();
    if (after - before >= closest) continue;
    closest = after - before;
    offset = system - before - closest / 2;
  }
  return offset;
}

/// Distance of `time` to the last multiple of `step` at or before it.
std::int64_t after_multiple(std::int64_t time, std::int64_t step) {
  const std::int64_t rest = time % step;
  return rest < 0 ? rest + step : rest;
}

}  // namespace

SessionClock::SessionClock() : offset_(system_offset()), steady_(true) {
  source_ = [offset = offset_] { return reading_of<std::chrono::steady_clock>() + offset; };
}

SessionClock::SessionClock(Source source) : source_(std::move(source)) {
  if (!source_) {
    pbd::detail::refuse("SessionClock: source", "callable", "empty");
  }
}

SessionTime SessionClock::now() {
  const SessionTime reading = source_();
  held_ = reading < last_ ? last_ - reading : 0;
  last_ = std::max(last_, reading);
  return last_;
}

std::int64_t SessionClock::stepped() const { return steady_ ? system_offset() - offset_ : 0; }

PhysicsClockOptions PhysicsClockOptions::at_rate(double hz) {
  PhysicsClockOptions result;
  result.nominal_step = std::llround(1e9 / hz);
  result.max_step = std::max(result.max_step, 2 * result.nominal_step);
  result.stall_limit = std::max(result.stall_limit, result.max_steps_per_call * result.max_step);
  return result;
}

void PhysicsClockOptions::validate() const {
  const auto check = [](bool ok, const char* field, std::int64_t value, const char* rule) {
    require(ok, "PhysicsClockOptions", field, value, rule);
  };
  constexpr std::int64_t kDay = 86'400'000'000'000;  // keeps all sums far from overflow
  check(nominal_step > 0, "nominal_step", nominal_step, "> 0 ns");
  check(max_step >= nominal_step, "max_step", max_step, ">= nominal_step");
  check(max_step <= kDay, "max_step", max_step, "at most a day");
  check(max_steps_per_call >= 1 && max_steps_per_call <= PhysicsClock::kMaxSteps,
        "max_steps_per_call", max_steps_per_call, "in [1, PhysicsClock::kMaxSteps]");
  check(stall_limit >= max_steps_per_call * max_step && stall_limit <= 365 * kDay, "stall_limit",
        stall_limit, "in [max_steps_per_call * max_step, a year]");
}

PhysicsClock::PhysicsClock(const PhysicsClockOptions& options, SessionTime start)
    : options_(options) {
  options_.validate();
  time_ = start - after_multiple(start, options_.nominal_step);
}

ClockTick PhysicsClock::advance(SessionTime now) {
  ClockTick tick;
  std::int64_t lag = now - time_;
  const std::int64_t nominal = options_.nominal_step;
  if (lag > options_.stall_limit || lag < -options_.stall_limit) {
    tick.skipped = lag - after_multiple(lag, nominal) - nominal;
    time_ += tick.skipped;
    total_skipped_ += tick.skipped;
    lag -= tick.skipped;
  }
  // Longer steps only if the largest number of nominal ones would not catch up.
  const std::int64_t due = lag / nominal, most = options_.max_steps_per_call;
  const std::int64_t usual =
      std::clamp((due + most - 1) / most, std::int64_t{1}, options_.max_step / nominal) * nominal;
  std::size_t count = 0;
  while (lag >= nominal && count < static_cast<std::size_t>(options_.max_steps_per_call)) {
    const std::int64_t step = std::min(lag - lag % nominal, usual);
    steps_[count++] = step;
    time_ += step;
    lag -= step;
  }
  tick.steps = std::span(steps_.data(), count);
  tick.lag = lag;
  tick.held = std::max<std::int64_t>(0, -lag);
  return tick;
}

}  // namespace tandem::net
