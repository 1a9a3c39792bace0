// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Errors against the C library's functions of 64 bit mantissas: where long double has no more bits
// than double, as elsewhere than on x86, these cases say nothing and are left out.
#include "tandem/pbd/portable.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "support/catch.h"
#include "tandem/pbd/random.h"

namespace portable_test {

namespace portable = tandem::pbd::portable;
using tandem::pbd::SplitMix64;

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kPi = 3.141592653589793;
constexpr int kSamples = 300000;
constexpr bool kHasReference = std::numeric_limits<long double>::digits > 60;
#ifdef _WIN32  // whose sinl knows pi to 66 bits: near its multiples nothing is left
constexpr bool kHasSines = false;
#else
constexpr bool kHasSines = kHasReference;
#endif

/// The largest error of a function, in units in the last place of the right result.
class Worst {
 public:
  void compare(double got, long double right) {
    int exponent = 0;
    std::frexp(static_cast<double>(right), &exponent);
    exponent = std::max(exponent, std::numeric_limits<double>::min_exponent);
    const auto error = std::ldexp(std::abs(got - right), 53 - exponent);
    ulp_ = std::max(ulp_, static_cast<double>(error));
  }
  double ulp() const { return ulp_; }

 private:
  double ulp_ = 0.0;
};

/// A number of either sign and of a size from 2^low to 1.
double spread(SplitMix64& random, unsigned low) {
  return std::ldexp(random.uniform(-1.0, 1.0), -static_cast<int>(random.below(low)));
}

}  // namespace

TEST_CASE("portable: sines and cosines are right to less than 1.1 ulp", "[pbd][analytic]") {
  if (!kHasSines) return;
  SplitMix64 random(1);
  Worst sine, cosine;
  const auto compare = [&](double x) {
    const portable::SinCos got = portable::sin_cos(x);
    sine.compare(got.sin, std::sin(static_cast<long double>(x)));
    cosine.compare(got.cos, std::cos(static_cast<long double>(x)));
  };
  for (int i = 0; i < kSamples; ++i) {
    compare(random.uniform(-10.0, 10.0));
    compare(random.uniform(-1e6, 1e6));
    compare(spread(random, 300));
  }
  // Next to the zeros, where nothing of the angle is left but the digits that pi / 2 has further
  // down.
  for (int k = 1; k < 600000; ++k) compare(k * (0.5 * kPi));
  CHECK(sine.ulp() < 1.1);
  CHECK(cosine.ulp() < 1.1);
}

TEST_CASE("portable: arcs, powers and logarithms are right to less than 2 ulp", "[pbd][analytic]") {
  if (!kHasReference) return;
  SplitMix64 random(2);
  Worst arc, power, power_less_one, logarithm;
  for (int i = 0; i < kSamples; ++i) {
    const double x = spread(random, 60);
    const double y = spread(random, 60);
    arc.compare(portable::atan2(y, x), std::atan2(static_cast<long double>(y), x));
    const double near = random.uniform(-1.0, 1.0);
    arc.compare(portable::atan2(y, near), std::atan2(static_cast<long double>(y), near));
    const double p = random.uniform(-708.0, 709.0);
    for (const double e : {x, near, p, p / 20.0}) {
      power.compare(portable::exp(e), std::exp(static_cast<long double>(e)));
      power_less_one.compare(portable::expm1(e), std::expm1(static_cast<long double>(e)));
    }
    for (const double l : {x, near, 3.0 * near * near, std::exp(std::abs(p))}) {
      logarithm.compare(portable::log1p(l), std::log1p(static_cast<long double>(l)));
    }
  }
  CHECK(arc.ulp() < 2.0);
  CHECK(power.ulp() < 1.0);
  CHECK(power_less_one.ulp() < 2.0);
  CHECK(logarithm.ulp() < 2.0);
}

TEST_CASE("portable: edges are those of C", "[pbd][unit]") {
  const auto same = [](double l, double r) {
    return std::isnan(l) ? std::isnan(r) : l == r && std::signbit(l) == std::signbit(r);
  };
  for (const double y : {0.0, -0.0, 1.0, -1.0, 1e-310, 1e308, kInfinity, -kInfinity, kNan}) {
    for (const double x : {0.0, -0.0, 1.0, -1.0, -1e-310, -1e308, kInfinity, -kInfinity, kNan}) {
      INFO(y << ' ' << x);
      CHECK(same(portable::atan2(y, x), std::atan2(y, x)));
    }
  }
  for (const double x : {0.0, -0.0, kInfinity, -kInfinity, kNan, 800.0, -800.0, 5e-324, -1e-310}) {
    INFO(x);
    CHECK(same(portable::exp(x), std::exp(x)));
    CHECK(same(portable::expm1(x), std::expm1(x)));
    CHECK(same(portable::sin_cos(x).sin, std::sin(x)));
    CHECK(same(portable::sin_cos(x).cos, std::cos(x)));
  }
  for (const double x : {0.0, -0.0, kInfinity, kNan, -1.0, -1.5, 5e-324, -1e-310}) {
    INFO(x);
    CHECK(same(portable::log1p(x), std::log1p(x)));
  }
  // The smallest and the largest numbers, of which the powers of two are none.
  CHECK(portable::exp(-745.0) == 5e-324);
  CHECK(portable::exp(-708.5) > 0.0);
  CHECK(portable::exp(709.7) == Approx(std::exp(709.7)).epsilon(1e-15));
}

TEST_CASE("portable: an angle of any size has a sine and a cosine that belong together",
          "[pbd][unit]") {
  for (const double angle : {1e6, -3e9, 1e22, 1e300, 1.7e308}) {
    const portable::SinCos got = portable::sin_cos(angle);
    CHECK(got.sin * got.sin + got.cos * got.cos == Approx(1.0).epsilon(1e-15));
  }
  // 4e-17 of the angle is what its remainder may be off by.
  CHECK(portable::sin_cos(3e9).sin == Approx(std::sin(3e9)).margin(3e-7));
}

}  // namespace portable_test
