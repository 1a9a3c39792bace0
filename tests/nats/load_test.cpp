// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "load.h"

#include "support/catch.h"

namespace tandem::nats::load_test {
namespace {

using Verdict = Load::Verdict;
constexpr std::int64_t kMs = 1'000'000;

TEST_CASE("load: late, missing or dropped answers show a slow peer", "[nats]") {
  Load load;
  std::int64_t now = 1000 * kMs;
  const auto next = [&] { return now += Load::kLook; };
  load.said(now);
  load.heard(now, now + 3 * kMs);
  CHECK(load.look(0, true, next()) == Verdict::Well);
  CHECK(load.lag() == 3 * kMs);
  CHECK(load.look(0, true, next()) == Verdict::Wait);  // nothing was said since
  CHECK(load.look(1, true, next()) == Verdict::Slow);
  CHECK(load.look(1, true, next()) == Verdict::Wait);
  load.said(now);
  load.heard(now, now + 450 * kMs);
  CHECK(load.look(1, true, next()) == Verdict::Slow);
  load.said(now);
  CHECK(load.look(1, true, next()) == Verdict::Wait);
  CHECK(load.look(1, true, next()) == Verdict::Slow);
}

TEST_CASE("load: nobody is slow where there is no server", "[nats]") {
  Load load;
  std::int64_t now = 1000 * kMs;
  load.said(now);
  for (int i = 0; i < 10; ++i) {
    now += Load::kLook;
    CHECK(load.look(0, false, now) == Verdict::Wait);
  }
  CHECK(load.look(0, true, now += Load::kLook) == Verdict::Wait);
}

}  // namespace
}  // namespace tandem::nats::load_test
