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

std::vector<std::int64_t> steps(const ClockTick& tick) {
  return {tick.steps.begin(), tick.steps.end()};
}

}  // namespace

TEST_CASE("clock: a call on time gives one nominal step", "[net][unit]") {
  PhysicsClock clock({}, kStart);
  const std::int64_t nominal = PhysicsClockOptions{}.nominal_step;
  for (int frame = 1; frame <= 600; ++frame) {
    const ClockTick tick = clock.advance(kStart + frame * nominal);
    REQUIRE(steps(tick) == std::vector<std::int64_t>{nominal});
    REQUIRE(tick.lag == 0);
  }
  CHECK(clock.physics_time() == kStart + 600 * nominal);
}

TEST_CASE("clock: no step before the shortest one fits", "[net][unit]") {
  PhysicsClock clock({}, kStart);
  CHECK(clock.advance(kStart).steps.empty());
  CHECK(clock.advance(kStart + 8 * kMs - 1).steps.empty());
  CHECK(steps(clock.advance(kStart + 8 * kMs)) == std::vector<std::int64_t>{8 * kMs});
}

TEST_CASE("clock: a late call gives several steps that make up for it", "[net][unit]") {
  // 100 ms in 8 steps of 16 ms at most: 16 * 6 = 96, and 4 ms are too short for a step.
  PhysicsClock clock({.nominal_step = 16 * kMs}, kStart);
  const ClockTick tick = clock.advance(kStart + 100 * kMs);
  CHECK(steps(tick) == std::vector<std::int64_t>(6, 16 * kMs));
  CHECK(tick.lag == 4 * kMs);
}

TEST_CASE("clock: steps grow where nominal ones would not catch up", "[net][unit]") {
  // 200 ms with 8 steps: 25 ms each. 300 ms: 8 * 32 = 256 at most, 44 are left to the next call.
  PhysicsClock clock({.nominal_step = 16 * kMs}, kStart);
  CHECK(steps(clock.advance(kStart + 200 * kMs)) == std::vector<std::int64_t>(8, 25 * kMs));
  const ClockTick tick = clock.advance(kStart + 500 * kMs);
  CHECK(steps(tick) == std::vector<std::int64_t>(8, 32 * kMs));
  CHECK(tick.lag == 44 * kMs);
  CHECK(steps(clock.advance(kStart + 500 * kMs)) ==
        std::vector<std::int64_t>{16 * kMs, 16 * kMs, 12 * kMs});
}

TEST_CASE("clock: a stall is skipped, reported, and leaves no lag", "[net][unit]") {
  PhysicsClock clock({.nominal_step = 16 * kMs, .stall_limit = 1000 * kMs}, kStart);
  const ClockTick tick = clock.advance(kStart + 3600'000 * kMs);
  CHECK(steps(tick) == std::vector<std::int64_t>{16 * kMs});
  CHECK(tick.skipped == 3600'000 * kMs - 16 * kMs);
  CHECK(tick.lag == 0);
  CHECK(clock.physics_time() == kStart + 3600'000 * kMs);
  CHECK(clock.total_skipped() == tick.skipped);

  SECTION("at the limit it is simulated") {
    const SessionTime now = clock.physics_time() + 1000 * kMs;
    std::int64_t sum = 0;
    for (int call = 0; call < 10; ++call) {
      const ClockTick later = clock.advance(now);
      CHECK(later.skipped == 0);
      for (const std::int64_t step : later.steps) sum += step;
    }
    CHECK(sum == 1000 * kMs);
  }
}

TEST_CASE("clock: physics waits for a shared time that is behind it", "[net][unit]") {
  PhysicsClock clock({}, kStart);
  CHECK(clock.advance(kStart - 500 * kMs).steps.empty());
  CHECK(clock.physics_time() == kStart);
  // Further behind than stall_limit it follows.
  const ClockTick tick = clock.advance(kStart - 5000 * kMs);
  CHECK(tick.skipped < -5000 * kMs);
  CHECK(clock.physics_time() == kStart - 5000 * kMs);
}

TEST_CASE("clock: no drift over a million irregular calls", "[net][unit]") {
  for (const std::int64_t nominal : {8 * kMs, 1'000 * kMs / 72, 1'000 * kMs / 60, 32 * kMs}) {
    PhysicsClock clock({.nominal_step = nominal}, kStart);
    std::mt19937_64 random(static_cast<std::uint64_t>(nominal));
    SessionTime now = kStart;
    std::int64_t sum = 0;
    bool in_range = true, not_ahead = true, close_behind = true, agrees = true;
    for (int call = 0; call < 250'000; ++call) {
      // Mostly around a frame, sometimes a hitch; never more than one call can make up for.
      const std::uint64_t longest = random() % 50 == 0 ? 250 * kMs : 25 * kMs;
      now += static_cast<std::int64_t>(random() % longest);
      const ClockTick tick = clock.advance(now);
      for (const std::int64_t step : tick.steps) {
        in_range &= step >= 8 * kMs && step <= 32 * kMs;
        sum += step;
      }
      not_ahead &= clock.physics_time() <= now;
      close_behind &= now - clock.physics_time() < 8 * kMs;
      agrees &= kStart + sum == clock.physics_time() && tick.skipped == 0;
    }
    CHECK(in_range);
    CHECK(not_ahead);
    CHECK(close_behind);
    CHECK(agrees);
  }
}

TEST_CASE("clock: late jitter leaves the steps nominal", "[net][unit]") {
  // Frames at 60 Hz that come up to 3 ms late: the lag that is left takes up the jitter.
  const std::int64_t nominal = PhysicsClockOptions{}.nominal_step;
  PhysicsClock clock({}, kStart);
  std::mt19937_64 random(5);
  int odd = 0;
  for (int frame = 1; frame <= 6000; ++frame) {
    const SessionTime now =
        kStart + frame * nominal + static_cast<std::int64_t>(random() % (3 * kMs));
    const ClockTick tick = clock.advance(now);
    REQUIRE(tick.steps.size() == 1);
    odd += tick.steps.front() != nominal;
  }
  CHECK(odd == 0);
}

TEST_CASE("clock: options that cannot work are refused by name", "[net][fault]") {
  const auto refused = [](PhysicsClockOptions options, const std::string& field) {
    CHECK_THROWS_WITH(PhysicsClock(options, 0),
                      Catch::Matchers::Contains("PhysicsClockOptions: " + field + " is "));
  };
  refused({.min_step = 0}, "min_step");
  refused({.min_step = 40 * kMs}, "max_step");
  refused({.nominal_step = 33 * kMs}, "nominal_step");
  refused({.nominal_step = 7 * kMs}, "nominal_step");
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

TEST_CASE("clock: session time goes on with the steady clock, whoever sets the other one",
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

TEST_CASE("clock: two session clocks of one host agree", "[net][unit]") {
  SessionClock a, b;
  const SessionTime first = a.now();
  const SessionTime between = b.now();
  const SessionTime last = a.now();
  CHECK(first <= between);
  CHECK(between <= last);
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
