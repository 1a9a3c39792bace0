// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/consensus/influence.h"

#include <cmath>
#include <limits>
#include <stdexcept>

#include "support/catch.h"

namespace influence_test {

using namespace tandem::consensus;

namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kFrame = 1.0 / 60.0;

}  // namespace

TEST_CASE("influence: share and weight are each other's inverse", "[consensus][analytic]") {
  CHECK(weight_of_share(0.5) == 1.0);
  CHECK(weight_of_share(0.8) == Approx(4.0).epsilon(1e-15));
  CHECK(share_of_weight(1.0) == 0.5);
  CHECK(share_of_weight(3.0) == 0.75);
  for (const double s : {1e-12, 1e-6, 0.08, 0.3, 0.999}) {
    CHECK(share_of_weight(weight_of_share(s)) == Approx(s).epsilon(1e-13));
  }
}

TEST_CASE("influence: the ends of the range are exact", "[consensus][unit]") {
  CHECK(weight_of_share(1.0) == kInf);
  CHECK(weight_of_share(0.0) == 0.0);
  CHECK(share_of_weight(kInf) == 1.0);
  CHECK(share_of_weight(0.0) == 0.0);
  CHECK(share_per_step(1.0, 1e-4) == 1.0);
  CHECK(share_per_step(0.0, 1.0) == 0.0);
  CHECK(share_per_step(0.3, 0.0) == 0.0);
  CHECK(weight_of_share(kNan) == 0.0);
  CHECK(share_of_weight(kNan) == 0.0);
  CHECK(share_per_step(kNan, 1.0) == 0.0);
}

TEST_CASE("influence: a step of 1/60 s closes the share, and steps compound",
          "[consensus][analytic]") {
  CHECK(share_per_step(0.08, kFrame) == Approx(0.08).epsilon(1e-15));
  // Two frames leave 0.92^2 of the gap; a third of a frame, three times, leaves 0.92.
  CHECK(share_per_step(0.08, 2.0 * kFrame) == Approx(1.0 - 0.92 * 0.92).epsilon(1e-15));
  const double third = share_per_step(0.08, kFrame / 3.0);
  CHECK(std::pow(1.0 - third, 3.0) == Approx(0.92).epsilon(1e-15));
  // 72 steps a second close in a second what 60 do.
  CHECK(std::pow(1.0 - share_per_step(0.08, 1.0 / 72.0), 72.0) ==
        Approx(std::pow(0.92, 60.0)).epsilon(1e-13));
  // To first order a small share is proportional to the step: nothing is lost to rounding.
  CHECK(share_per_step(1e-14, 0.5 * kFrame) == Approx(0.5e-14).epsilon(1e-12));
}

TEST_CASE("influence: options out of range are refused by name", "[consensus][fault]") {
  const auto message = [](auto change) -> std::string {
    InfluenceOptions options;
    change(options);
    try {
      options.validate();
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "accepted";
  };
  CHECK(message([](InfluenceOptions&) {}) == "accepted");
  CHECK_THAT(message([](InfluenceOptions& o) { o.baseline = 1.5; }),
             Catch::Contains("baseline must be") && Catch::Contains("is 1.5") &&
                 Catch::Contains("0 to 1"));
  CHECK_THAT(message([](InfluenceOptions& o) { o.leading = -0.1; }), Catch::Contains("leading"));
  CHECK_THAT(message([](InfluenceOptions& o) { o.held_alone = 1.1; }),
             Catch::Contains("held_alone"));
  CHECK_THAT(message([](InfluenceOptions& o) { o.max_age = kNan; }), Catch::Contains("max_age"));
  CHECK_THAT(message([](InfluenceOptions& o) { o.max_age = kInf; }), Catch::Contains("max_age"));
}

}  // namespace influence_test
