// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/net/clock.h"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <random>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "support/catch.h"

namespace clock_test {

using namespace tandem::net;

namespace {

constexpr std::int64_t kMs = 1'000'000;
constexpr SessionTime kStart = 1'700'000'000'000'000'000;  // a wall-clock time of today, ns
constexpr SessionTime kAligned = 16 * kMs * 1'000'000;     // ns, a multiple of 16 ms

std::vector<std::int64_t> steps(const ClockTick& tick) {
  return {tick.steps.begin(), tick.steps.end()};
}

}  // namespace

TEST_CASE("clock: a call on time gives one nominal step", "[net][unit]") {
  const std::int64_t nominal = PhysicsClockOptions{}.nominal_step;
  PhysicsClock clock({}, kStart);
  const SessionTime first = clock.physics_time();
  for (int frame = 1; frame <= 600; ++frame) {
    const ClockTick tick = clock.advance(first + frame * nominal);
    REQUIRE(steps(tick) == std::vector<std::int64_t>{nominal});
    REQUIRE(tick.lag == 0);
  }
  CHECK(clock.physics_time() == first + 600 * nominal);
}

TEST_CASE("clock: peers that start and call at other times step at the same ones", "[net][unit]") {
  const std::int64_t step = 16 * kMs;
  for (const SessionTime start : {SessionTime{0}, 1 * kMs, 15 * kMs, 16 * kMs, -5 * kMs, kStart}) {
    CAPTURE(start);
    PhysicsClock clock({.nominal_step = step}, start);
    CHECK(clock.physics_time() % step == 0);
    CHECK(clock.physics_time() <= start);
    CHECK(start - clock.physics_time() < step);
  }
}

TEST_CASE("clock: no step before one fits", "[net][unit]") {
  PhysicsClock clock({.nominal_step = 16 * kMs}, kAligned);
  CHECK(clock.advance(kAligned).steps.empty());
  CHECK(clock.advance(kAligned + 16 * kMs - 1).steps.empty());
  CHECK(steps(clock.advance(kAligned + 16 * kMs)) == std::vector<std::int64_t>{16 * kMs});
}

TEST_CASE("clock: a late call gives several steps that make up for it", "[net][unit]") {
  // 100 ms in 8 steps of 16 ms at most: 16 * 6 = 96, and 4 ms are too short for a step.
  PhysicsClock clock({.nominal_step = 16 * kMs}, kAligned);
  const ClockTick tick = clock.advance(kAligned + 100 * kMs);
  CHECK(steps(tick) == std::vector<std::int64_t>(6, 16 * kMs));
  CHECK(tick.lag == 4 * kMs);
}

TEST_CASE("clock: steps are several nominal ones where single ones would not catch up",
          "[net][unit]") {
  // 200 ms are 12 steps of 16 ms, and 8 may be made: six of 32. For 500 ms, 31 steps, 8 steps of 32
  // ms are made, and 15 steps are left to the next call.
  PhysicsClock clock({.nominal_step = 16 * kMs, .max_step = 32 * kMs}, kAligned);
  CHECK(steps(clock.advance(kAligned + 200 * kMs)) == std::vector<std::int64_t>(6, 32 * kMs));
  const ClockTick tick = clock.advance(kAligned + 192 * kMs + 500 * kMs);
  CHECK(steps(tick) == std::vector<std::int64_t>(8, 32 * kMs));
  CHECK(tick.lag == 500 * kMs - 256 * kMs);
  std::vector<std::int64_t> rest(7, 32 * kMs);
  rest.push_back(16 * kMs);
  CHECK(steps(clock.advance(kAligned + 192 * kMs + 500 * kMs)) == rest);
}

TEST_CASE("clock: a stall is skipped by whole steps and reported", "[net][unit]") {
  PhysicsClock clock({.nominal_step = 16 * kMs, .stall_limit = 1000 * kMs}, kAligned);
  const ClockTick tick = clock.advance(kAligned + 3600'005 * kMs);
  CHECK(steps(tick) == std::vector<std::int64_t>{16 * kMs});
  CHECK(tick.skipped == 3600'000 * kMs - 16 * kMs);
  CHECK(tick.lag == 5 * kMs);
  CHECK(clock.physics_time() == kAligned + 3600'000 * kMs);
  CHECK(clock.total_skipped() == tick.skipped);

  SECTION("at the limit it is simulated") {
    const SessionTime now = clock.physics_time() + 992 * kMs;
    std::int64_t sum = 0;
    for (int call = 0; call < 10; ++call) {
      const ClockTick later = clock.advance(now);
      CHECK(later.skipped == 0);
      for (const std::int64_t step : later.steps) sum += step;
    }
    CHECK(sum == 992 * kMs);
  }
}

TEST_CASE("clock: physics waits for a shared time that is behind it", "[net][unit]") {
  PhysicsClock clock({.nominal_step = 16 * kMs}, kAligned);
  CHECK(clock.advance(kAligned - 500 * kMs).steps.empty());
  CHECK(clock.physics_time() == kAligned);
  // Further behind than stall_limit it follows.
  const ClockTick tick = clock.advance(kAligned - 5000 * kMs);
  CHECK(tick.skipped < -5000 * kMs);
  CHECK(clock.physics_time() <= kAligned - 5000 * kMs);
  CHECK(clock.physics_time() > kAligned - 5016 * kMs);
}

TEST_CASE("clock: no drift over a million irregular calls", "[net][unit]") {
  for (const std::int64_t nominal : {8 * kMs, 1'000 * kMs / 72, 1'000 * kMs / 60, 32 * kMs}) {
    PhysicsClock clock({.nominal_step = nominal, .max_step = 64 * kMs}, kStart);
    const SessionTime first = clock.physics_time();
    std::mt19937_64 random(static_cast<std::uint64_t>(nominal));
    SessionTime now = kStart;
    std::int64_t sum = 0;
    bool whole = true, not_ahead = true, close_behind = true, agrees = true;
    for (int call = 0; call < 250'000; ++call) {
      // Mostly around a frame, sometimes a hitch; never more than one call can make up for.
      const std::uint64_t longest = random() % 50 == 0 ? 250 * kMs : 25 * kMs;
      now += static_cast<std::int64_t>(random() % longest);
      const ClockTick tick = clock.advance(now);
      for (const std::int64_t step : tick.steps) {
        whole &= step > 0 && step % nominal == 0;
        sum += step;
      }
      not_ahead &= clock.physics_time() <= now;
      close_behind &= now - clock.physics_time() < nominal;
      agrees &= first + sum == clock.physics_time() && tick.skipped == 0;
    }
    CHECK(whole);
    CHECK(not_ahead);
    CHECK(close_behind);
    CHECK(agrees);
  }
}

TEST_CASE("clock: late jitter leaves the steps nominal", "[net][unit]") {
  // Frames at 60 Hz that come up to 3 ms late: the lag that is left takes up the jitter.
  const std::int64_t nominal = PhysicsClockOptions{}.nominal_step;
  PhysicsClock clock({}, kStart);
  const SessionTime first = clock.physics_time();
  std::mt19937_64 random(5);
  int odd = 0;
  for (int frame = 1; frame <= 6000; ++frame) {
    const SessionTime now =
        first + frame * nominal + static_cast<std::int64_t>(random() % (3 * kMs));
    const ClockTick tick = clock.advance(now);
    REQUIRE(tick.steps.size() == 1);
    odd += tick.steps.front() != nominal;
  }
  CHECK(odd == 0);
}

TEST_CASE("clock: options that cannot work are refused by name", "[net][fault]") {
  const auto refused = [](PhysicsClockOptions options, const std::string& field) {
    CHECK_THROWS_WITH(PhysicsClock(options, 0),
                      Catch::Matchers::Contains("PhysicsClockOptions: " + field + " must be "));
  };
  refused({.nominal_step = 0}, "nominal_step");
  refused({.nominal_step = 40 * kMs}, "max_step");
  refused({.max_steps_per_call = 0}, "max_steps_per_call");
  refused({.max_steps_per_call = 33}, "max_steps_per_call");
  refused({.stall_limit = 255 * kMs}, "stall_limit");
}

TEST_CASE("clock: the session clock never goes back", "[net][unit]") {
  std::vector<SessionTime> source = {100, 200, 150, 199, 201};
  std::size_t at = 0;
  SessionClock clock([&] { return source[at++]; });
  CHECK(clock.now() == 100);
  CHECK(clock.now() == 200);
  CHECK(clock.held() == 0);
  CHECK(clock.now() == 200);
  CHECK(clock.held() == 50);
  CHECK(clock.now() == 200);
  CHECK(clock.now() == 201);
  CHECK(clock.held() == 0);
  CHECK_THROWS_AS(SessionClock(SessionClock::Source{}), std::invalid_argument);
}

TEST_CASE("clock: session time follows the steady clock, however the other one is set",
          "[net][unit]") {
  using std::chrono::steady_clock;
  SessionClock clock;
  const auto steady = steady_clock::now();
  const SessionTime start = clock.now();
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  const std::int64_t passed =
      std::chrono::duration_cast<std::chrono::nanoseconds>(steady_clock::now() - steady).count();
  const std::int64_t told = clock.now() - start;
  CHECK(told >= 20'000'000);
  CHECK(told <= passed + 1'000'000);  // it was read later than the other one at the start
  CHECK(std::abs(clock.stepped()) < 100'000'000);
  SessionClock own([] { return SessionTime{5}; });
  CHECK(own.stepped() == 0);
}

TEST_CASE("clock: two session clocks of one host agree to microseconds", "[net][unit]") {
  constexpr std::int64_t kClose = 10'000;  // ns
  SessionClock a, b;
  const SessionTime first = a.now();
  const SessionTime between = b.now();
  const SessionTime last = a.now();
  CHECK(first <= between + kClose);
  CHECK(between <= last + kClose);
}

TEST_CASE("physics clock: how long it holds still for a clock that went back is said", "[net]") {
  PhysicsClock clock({}, 0);
  CHECK(clock.advance(20'000'000).held == 0);
  const std::int64_t ahead = clock.physics_time();
  // Half a second back: less than what is skipped, so nothing moves until it has passed again.
  const ClockTick tick = clock.advance(ahead - 500'000'000);
  CHECK(tick.steps.empty());
  CHECK(tick.held == 500'000'000);
  CHECK(clock.advance(ahead - 100'000'000).held == 100'000'000);
  CHECK(clock.advance(ahead + 17'000'000).held == 0);
  // Further back it is skipped, and nothing is held.
  CHECK(clock.advance(ahead - 60'000'000'000).held == 0);
}

}  // namespace clock_test
