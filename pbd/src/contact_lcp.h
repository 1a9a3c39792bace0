// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// The normals of a manifold, solved together.
#pragma once

#include <array>

#include "contact_lanes.h"

namespace tandem::pbd::kernel {

/// One number per point of a manifold.
template <class V>
struct Four {
  V p[4];
  V& operator[](std::size_t i) { return p[i]; }
  const V& operator[](std::size_t i) const { return p[i]; }
};

template <class V>
V sum(const Four<V>& x) {
  return (x[0] + x[1]) + (x[2] + x[3]);
}

template <class V>
V dot(const Four<V>& l, const Four<V>& r) {
  return (l[0] * r[0] + l[1] * r[1]) + (l[2] * r[2] + l[3] * r[3]);
}

/// Symmetric 4 x 4; the lower triangle.
template <class V>
struct Sym4 {
  V m00, m10, m11, m20, m21, m22, m30, m31, m32, m33;
  friend Four<V> operator*(const Sym4& m, const Four<V>& x) {
    return {{(m.m00 * x[0] + m.m10 * x[1]) + (m.m20 * x[2] + m.m30 * x[3]),
             (m.m10 * x[0] + m.m11 * x[1]) + (m.m21 * x[2] + m.m31 * x[3]),
             (m.m20 * x[0] + m.m21 * x[1]) + (m.m22 * x[2] + m.m32 * x[3]),
             (m.m30 * x[0] + m.m31 * x[1]) + (m.m32 * x[2] + m.m33 * x[3])}};
  }
};

/// x with m x = r, m positive definite: L D L^T, unrolled.
template <class V>
Four<V> solve_symmetric(const Sym4<V>& m, const Four<V>& r) {
  const V one(1.0);
  const V i0 = one / m.m00;
  const V l10 = m.m10 * i0, l20 = m.m20 * i0, l30 = m.m30 * i0;
  const V i1 = one / (m.m11 - l10 * m.m10);
  const V c21 = m.m21 - l20 * m.m10, c31 = m.m31 - l30 * m.m10;
  const V l21 = c21 * i1, l31 = c31 * i1;
  const V i2 = one / (m.m22 - l20 * m.m20 - l21 * c21);
  const V c32 = m.m32 - l30 * m.m20 - l31 * c21;
  const V l32 = c32 * i2;
  const V i3 = one / (m.m33 - l30 * m.m30 - l31 * c31 - l32 * c32);
  const V y1 = r[1] - l10 * r[0];
  const V y2 = r[2] - l20 * r[0] - l21 * y1;
  const V y3 = r[3] - l30 * r[0] - l31 * y1 - l32 * y2;
  Four<V> x;
  x[3] = y3 * i3;
  x[2] = y2 * i2 - l32 * x[3];
  x[1] = y1 * i1 - l21 * x[2] - l31 * x[3];
  x[0] = r[0] * i0 - l10 * x[1] - l20 * x[2] - l30 * x[3];
  return x;
}

/// Solves  0 <= z + d  _|_  e + B d >= 0  for d, the change of the multipliers z (N s) of points
/// with velocities e (m/s) and the mobility B (1/kg, positive semi-definite). Absent points have z
/// = 0.
/// Principal pivoting: guess which points carry a load, solve, exchange those on the wrong side; at
/// first all at once, later one at a time, which cannot cycle.
/// Source: [murty1974] for one at a time.
/// @param there  the points in use
template <class V>
Four<V> solve_lcp(const std::array<Mask<V>, 4>& there, const Sym4<V>& B, const Four<V>& z,
                  const Four<V>& e) {
  // Share added to the diagonal: three points on a line, or bodies that cannot turn, make B
  // singular. It acts on the change only, so repeated solves converge to the rigid solution.
  const V ridged(1.0 + 1e-6);
  constexpr int kAtOnce = 3;
  constexpr int kMax = 16;
  const V zero(0.0);
  const V one(1.0);
  std::array<Mask<V>, 4> loaded;
  V fastest = zero;
  for (std::size_t i = 0; i < 4; ++i) {
    loaded[i] = there[i] & ((z[i] > zero) | (e[i] < zero));
    fastest = most(fastest, xsimd::select(there[i], xsimd::abs(e[i]), zero));
  }
  const V slowest = V(-1e-9) * fastest;
  // Both paths below give the same bits, signs of zeros included: which one is taken depends on the
  // other rows of the batch, and so on its width.
  const auto unsigned_zeros = [&](const Four<V>& d) {
    return Four<V>{{d[0] + zero, d[1] + zero, d[2] + zero, d[3] + zero}};
  };
  if (xsimd::all((loaded[0] & loaded[1]) & (loaded[2] & loaded[3]))) {
    // Fast path: all four points are loaded. The first round below, without its other cases.
    const Four<V> d = solve_symmetric<V>({ridged * B.m00, B.m10, ridged * B.m11, B.m20, B.m21,
                                          ridged * B.m22, B.m30, B.m31, B.m32, ridged * B.m33},
                                         {{-e[0], -e[1], -e[2], -e[3]}});
    const Mask<V> pulls = ((z[0] + d[0] < zero) | (z[1] + d[1] < zero)) |
                          ((z[2] + d[2] < zero) | (z[3] + d[3] < zero));
    if (xsimd::none(pulls)) return unsigned_zeros(d);
  }
  Four<V> out{{zero, zero, zero, zero}};
  Mask<V> wrong = zero == zero;
  for (int iteration = 0; iteration < kMax; ++iteration) {
    // Unloaded points drop their impulses; the others respond to that.
    Four<V> dropped, r, share;
    for (std::size_t i = 0; i < 4; ++i) {
      dropped[i] = xsimd::select(loaded[i], zero, -z[i]);
      share[i] = xsimd::select(loaded[i], one, zero);
    }
    const Four<V> answer = B * dropped;
    for (std::size_t i = 0; i < 4; ++i) {
      r[i] = xsimd::select(loaded[i], -(e[i] + answer[i]), dropped[i]);
    }
    const auto diagonal = [&](const V& value, std::size_t i) {
      return xsimd::select(loaded[i], ridged * value, one);
    };
    const Four<V> d = solve_symmetric<V>(
        {diagonal(B.m00, 0), B.m10 * (share[1] * share[0]), diagonal(B.m11, 1),
         B.m20 * (share[2] * share[0]), B.m21 * (share[2] * share[1]), diagonal(B.m22, 2),
         B.m30 * (share[3] * share[0]), B.m31 * (share[3] * share[1]),
         B.m32 * (share[3] * share[2]), diagonal(B.m33, 3)},
        r);
    for (std::size_t i = 0; i < 4; ++i) out[i] = xsimd::select(wrong, d[i], out[i]);
    const Four<V> response = B * d;
    Mask<V> exchanged = zero != zero;
    for (std::size_t i = 4; i-- > 0;) {
      const Mask<V> sinks = e[i] + response[i] < slowest;
      const Mask<V> pulls = z[i] + d[i] < zero;
      Mask<V> exchange = there[i] & ((loaded[i] & pulls) | (~loaded[i] & sinks));
      if (iteration >= kAtOnce) exchange = exchange & ~exchanged;
      loaded[i] = loaded[i] ^ exchange;
      exchanged = exchanged | exchange;
    }
    wrong = wrong & exchanged;
    if (xsimd::none(wrong)) break;
  }
  for (std::size_t i = 0; i < 4; ++i) out[i] = most(out[i], -z[i]);
  return unsigned_zeros(out);
}

/// Rigid points in a plane leave one combination of their loads undetermined (two opposite corners
/// up, two down). It would drift until one point lets go, and a tall stack would rock itself over:
/// if all four carry, they share as evenly as they can. This moves nothing. Unevenness below 1e-6
/// is left: at rest that saves 2 % of a stack's instructions.
/// @param u  the combination, of unit length, or zero
template <class V>
void share_evenly(const Mask<V>& asked, const Four<V>& u, Four<V>& z) {
  const V zero(0.0), one(1.0), even(1e-6);
  const V uneven = dot(u, z);
  Mask<V> carry = asked & (xsimd::abs(uneven) > even * sum(z));
  for (std::size_t i = 0; i < 4; ++i) carry = carry & (z[i] > zero);
  if (xsimd::none(carry)) return;
  V share = one;
  for (std::size_t i = 0; i < 4; ++i) {
    const V less = uneven * u[i];
    share = xsimd::select(less > z[i], least(share, z[i] / less), share);
  }
  const V moved = xsimd::select(carry, share * uneven, zero);
  for (std::size_t i = 0; i < 4; ++i) {
    z[i] = xsimd::select(carry, most(z[i] - moved * u[i], zero), z[i]);
  }
}

}  // namespace tandem::pbd::kernel
