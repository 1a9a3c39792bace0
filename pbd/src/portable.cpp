// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/pbd/portable.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "tandem/pbd/bit_cast.h"

namespace tandem::pbd::portable {
namespace {

constexpr double kPi = 0x1.921fb54442d18p+1;
constexpr double kPiRest = 0x1.1a62633145c07p-53;  // pi - kPi

/// ln 2 in two parts; the first one has 32 bits, so that its multiples up to 2^21 are exact.
constexpr double kLn2 = 0x1.62e42fee00000p-1;
constexpr double kLn2Rest = 0x1.a39ef35793c76p-33;

/// c[0] + c[1] x + ...
template <std::size_t N>
double polynomial(double x, const std::array<double, N>& c) {
  double sum = c[N - 1];
  for (std::size_t i = N - 1; i-- > 0;) sum = sum * x + c[i];
  return sum;
}

/// The nearest integer, for |x| < 2^51: doubles beyond 2^52 have no fraction.
double nearest(double x) {
  constexpr double kShift = 0x1.8p+52;
  return (x + kShift) - kShift;
}

/// 2^n. @pre -1022 <= n <= 1023
double power_of_two(std::int64_t n) {
  return bit_cast<double>(static_cast<std::uint64_t>(n + 1023) << 52);
}

/// n with 2^n <= x < 2^(n + 1). @pre x is a normal number > 0
std::int64_t exponent(double x) {
  return static_cast<std::int64_t>(bit_cast<std::uint64_t>(x) >> 52) - 1023;
}

/// x = turns pi / 2 + rest + below, with |rest| <= pi / 4 and a correction below its last place.
struct Quadrant {
  double turns, rest, below;
};

/// @pre |x| <= 2^20
Quadrant quadrant(double x) {
  constexpr double kTwoOverPi = 0x1.45f306dc9c883p-1;
  // pi / 2 in three parts. The first two have 33 bits, so that their multiples are exact.
  constexpr double kHalfPi1 = 0x1.921fb54400000p+0;
  constexpr double kHalfPi2 = 0x1.0b4611a600000p-34;
  constexpr double kHalfPi3 = 0x1.3198a2e037073p-69;
  const double turns = nearest(x * kTwoOverPi);
  const double a = x - turns * kHalfPi1;  // exact
  const double b = -turns * kHalfPi2;
  const double sum = a + b;
  const double part = sum - a;
  const double lost = (a - (sum - part)) + (b - part);  // [knuth1998] Sec. 4.2.2, Theorem B
  const double rest = sum + (lost - turns * kHalfPi3);
  return {turns, rest, (sum - rest) + (lost - turns * kHalfPi3)};
}

/// sin(x + below), |x| <= pi / 4. Truncation error below x^19 / 19! < 2^-61 x.
double sine(double x, double below) {
  static constexpr std::array<double, 8> kSeries{
      -1.0 / 6,        1.0 / 120,         -1.0 / 5040,           1.0 / 362880,
      -1.0 / 39916800, 1.0 / 6227020800., -1.0 / 1307674368000., 1.0 / 355687428096000.};
  const double x2 = x * x;
  return x + (x * (x2 * polynomial(x2, kSeries)) + below * (1.0 - 0.5 * x2));
}

/// cos(x + below), |x| <= pi / 4. Truncation error below x^18 / 18! < 2^-58.
double cosine(double x, double below) {
  static constexpr std::array<double, 7> kSeries{
      1.0 / 24,        -1.0 / 720,          1.0 / 40320,          -1.0 / 3628800,
      1.0 / 479001600, -1.0 / 87178291200., 1.0 / 20922789888000.};
  const double x2 = x * x;
  const double start = 1.0 - 0.5 * x2;
  const double lost = (1.0 - start) - 0.5 * x2;
  return start + (lost + (x2 * x2 * polynomial(x2, kSeries) - x * below));
}

/// e^x = 2^n (1 + rest), |rest| < 0.42. Truncation error below r^15 / 15! < 2^-62 r.
struct Power {
  std::int64_t n;
  double rest;
};

/// @pre |x| < 1100
Power power(double x) {
  constexpr double kLog2E = 0x1.71547652b82fep+0;
  static constexpr std::array<double, 13> kSeries{
      1.0 / 2,         1.0 / 6,           1.0 / 24,          1.0 / 120,     1.0 / 720,
      1.0 / 5040,      1.0 / 40320,       1.0 / 362880,      1.0 / 3628800, 1.0 / 39916800,
      1.0 / 479001600, 1.0 / 6227020800., 1.0 / 87178291200.};
  const double n = nearest(x * kLog2E);
  const double a = x - n * kLn2;  // exact
  const double b = n * kLn2Rest;
  const double r = a - b;
  const double below = (a - r) - b;
  return {static_cast<std::int64_t>(n), r + (r * r * polynomial(r, kSeries) + below * (1.0 + r))};
}

/// atan(t), 0 <= t <= 1, as `start` + `rest`, where the latter is smaller.
struct Arc {
  double start, rest;
};

/// atan t = atan c + atan((t - c) / (1 + c t)) with c = k / 8 nearby. Truncation error below
/// (3/32)^16 / 17 < 2^-58 of it.
Arc arc(double t) {
  static constexpr std::array<Arc, 9> kAtan{{{0x0.0p+0, 0x0.0p+0},
                                             {0x1.fd5ba9aac2f6ep-4, -0x1.cd37686760c17p-59},
                                             {0x1.f5b75f92c80ddp-3, 0x1.8ab6e3cf7afbdp-57},
                                             {0x1.6f61941e4def1p-2, -0x1.c63aae6f6e918p-56},
                                             {0x1.dac670561bb4fp-2, 0x1.a2b7f222f65e2p-56},
                                             {0x1.1e00babdefeb4p-1, -0x1.928df287a668fp-58},
                                             {0x1.4978fa3269ee1p-1, 0x1.2419a87f2a458p-56},
                                             {0x1.700a7c5784634p-1, -0x1.8c34d25aadef6p-56},
                                             {0x1.921fb54442d18p-1, 0x1.1a62633145c07p-55}}};
  static constexpr std::array<double, 7> kSeries{-1.0 / 3,  1.0 / 5,  -1.0 / 7, 1.0 / 9,
                                                 -1.0 / 11, 1.0 / 13, -1.0 / 15};
  const double k = t < 3.0 / 32 ? 0.0 : nearest(8.0 * t);  // atan 1/8 - atan u would lose a digit
  const double c = k / 8.0;
  const double u = (t - c) / (1.0 + c * t);
  const double u2 = u * u;
  const Arc& known = kAtan[static_cast<std::size_t>(k)];
  const double bend = u * (u2 * polynomial(u2, kSeries));
  if (k == 0.0) return {u, bend};
  return {known.start, u + (bend + known.rest)};
}

}  // namespace

SinCos sin_cos(double angle) {
  if (!(std::abs(angle) < 1e6)) angle = std::fmod(angle, 2.0 * kPi);
  if (std::isnan(angle)) return {angle, angle};
  if (angle == 0.0) return {angle, 1.0};
  const Quadrant q = quadrant(angle);
  const double s = sine(q.rest, q.below);
  const double c = cosine(q.rest, q.below);
  switch (static_cast<std::int64_t>(q.turns) & 3) {
    case 0:
      return {s, c};
    case 1:
      return {c, -s};
    case 2:
      return {-s, -c};
    default:
      return {-c, s};
  }
}

double atan2(double y, double x) {
  if (std::isnan(x) || std::isnan(y)) return x + y;
  const double across = std::abs(x);
  const double up = std::abs(y);
  const bool steep = up > across;
  const double large = steep ? up : across;
  const double small = steep ? across : up;
  const double t = small == large ? (large == 0.0 ? 0.0 : 1.0) : small / large;
  Arc a = arc(t);
  // Rotates to the octant of the point.
  if (steep) a = {0.5 * kPi, (0.5 * kPiRest - a.rest) - a.start};
  if (std::signbit(x)) a = {kPi - a.start, kPiRest - a.rest};
  return std::copysign(a.start + a.rest, y);
}

double exp(double x) {
  if (std::isnan(x)) return x;
  if (x > 710.0) return std::numeric_limits<double>::infinity();
  if (x < -746.0) return 0.0;
  const Power p = power(x);
  const std::int64_t half = p.n / 2;  // 2^n may overflow where e^x does not
  return (1.0 + p.rest) * power_of_two(half) * power_of_two(p.n - half);
}

double expm1(double x) {
  if (std::isnan(x) || x == 0.0) return x;
  if (x > 40.0) return exp(x);
  if (x < -40.0) return -1.0;
  const Power p = power(x);
  const double scale = power_of_two(p.n);
  return scale * p.rest + (scale - 1.0);
}

double log1p(double x) {
  if (std::isnan(x) || x == 0.0 || x == std::numeric_limits<double>::infinity()) return x;
  if (x < -1.0) return std::numeric_limits<double>::quiet_NaN();
  if (x == -1.0) return -std::numeric_limits<double>::infinity();
  // 1 + x = 2^n (1 + f) + lost
  double n = 0.0;
  double f = x;
  double lost = 0.0;
  if (x < -0.29 || x > 0.41) {
    const double sum = 1.0 + x;
    lost = (x > 1.0 ? 1.0 - (sum - x) : x - (sum - 1.0)) / sum;
    n = static_cast<double>(exponent(sum));
    f = sum / power_of_two(exponent(sum)) - 1.0;
    if (f > 0.41) {
      n += 1.0;
      f = 0.5 * (f - 1.0);
    }
  }
  // ln(1 + f) = 2 artanh(s). Truncation error below s^25 / 25 < 2^-64 s.
  static constexpr std::array<double, 11> kSeries{2.0 / 3,  2.0 / 5,  2.0 / 7,  2.0 / 9,
                                                  2.0 / 11, 2.0 / 13, 2.0 / 15, 2.0 / 17,
                                                  2.0 / 19, 2.0 / 21, 2.0 / 23};
  const double s = f / (2.0 + f);
  const double s2 = s * s;
  return n * kLn2 + (f + (n * kLn2Rest + lost - s * (f - s2 * polynomial(s2, kSeries))));
}

}  // namespace tandem::pbd::portable
