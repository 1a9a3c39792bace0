// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "peer/recent_quantiles.h"

#include <cmath>
#include <limits>

#include "support/catch.h"

namespace tandem::demos::recent_quantiles_test {
namespace {

TEST_CASE("recent quantiles: of 1 to 1000 each is within a bin of the true one", "[demos][unit]") {
  RecentQuantiles q;
  for (int i = 1; i <= 1000; ++i) q.add(1e-3 * i);
  // A bin is 8 % wide and its middle is told: 4 %.
  for (const double p : {0.01, 0.5, 0.95, 0.99, 1.0}) {
    CAPTURE(p);
    CHECK(q.quantile(p) == Approx(p).epsilon(0.04));
  }
  CHECK(q.count() == 1000);
  CHECK(q.sum() == Approx(500.5));
}

TEST_CASE("recent quantiles: samples two turns old are forgotten but stay counted",
          "[demos][unit]") {
  RecentQuantiles q;
  CHECK(q.quantile(0.5) == 0.0);
  q.add(1.0);
  q.turn();
  CHECK(q.quantile(0.5) == Approx(1.0).epsilon(0.04));
  q.turn();
  CHECK(q.quantile(0.5) == 0.0);
  CHECK(q.count() == 1);
}

TEST_CASE("recent quantiles: no number is out of range", "[demos][fault]") {
  RecentQuantiles q;
  q.add(std::numeric_limits<double>::quiet_NaN());
  CHECK(q.count() == 0);
  for (const double value : {0.0, -1.0, 1e300, std::numeric_limits<double>::infinity()}) {
    q.add(value);
  }
  CHECK(q.quantile(0.25) <= 1.1 * RecentQuantiles::kMin);
  CHECK(q.quantile(1.0) > 30.0);
}

}  // namespace
}  // namespace tandem::demos::recent_quantiles_test
