// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Rows on displacements: opening of overlaps, and holding of target displacements against contacts.
#pragma once

#include "contact_pair.h"

namespace tandem::pbd::kernel {

/// @tparam holds  holds displacements; else opens overlaps
template <class A, bool faces, bool holds>
[[gnu::flatten]] LaneMask push(const ContactRows& rows, std::size_t at, LaneMask asked,
                               BodyNumbers bodies) {
  using V = xsimd::batch<double, A>;
  const V zero(0.0), one(1.0);
  Pair<A, Velocities::Push> pair(rows, at, bodies);
  const V3<V> velocity = pair.velocity();
  const V vn = dot(pair.n, velocity);
  Mask<V> active = zero != zero;
  Four<V> e{{vn, zero, zero, zero}};
  if constexpr (faces) {
    const Face<V> face(rows, at);
    const V3<V> spin = pair.spin();
    const V w1 = dot(pair.t1, spin), w2 = dot(pair.t2, spin);
    for (std::size_t i = 1; i < 4; ++i) e[i] = vn;
    for (std::size_t i = 0; i < 4; ++i) e[i] += w1 * face.s[i] + w2 * face.r[i];
  }
  if constexpr (holds) {
    // The displacement may use the part of a gap that the bodies' own motion leaves.
    const Pair<A, Velocities::Applied> own(rows, at, bodies);
    const V own_n = dot(pair.n, own.velocity());
    V own_1 = zero, own_2 = zero;
    if constexpr (faces) {
      own_1 = dot(pair.t1, own.spin());
      own_2 = dot(pair.t2, own.spin());
    }
    const Mask<V> penetrating = lanes_of<V>(rows.penetrating, at);
    for (std::size_t i = 0; i < (faces ? 4 : 1); ++i) {
      const V bias = load<V>(rows.bias[i], at);
      V room = bias + own_n;
      if constexpr (faces) {
        room += own_1 * load<V>(rows.s[i], at) + own_2 * load<V>(rows.r[i], at);
      }
      e[i] += xsimd::select(bias > zero, most(room, zero), xsimd::select(penetrating, bias, zero));
    }
  } else {
    for (std::size_t i = 0; i < (faces ? 4 : 1); ++i) e[i] += load<V>(rows.bias[i], at);
  }
  if constexpr (faces) {
    const Face<V> face(rows, at);
    for (std::size_t i = 0; i < 4; ++i) e[i] = xsimd::select(face.there[i], e[i], zero);
    active = (e[0] < zero) | (e[1] < zero) | (e[2] < zero) | (e[3] < zero);
  } else {
    active = e[0] < zero;
  }
  active = active & lanes_of<V>(asked, at);
  if (xsimd::none(active)) return 0;
  const unsigned bits = bits_of<V>(active, at);
  Responses<V> m = responses<V, faces>(rows, at);
  const V mass_a = pair.a.inv_mass(), mass_b = pair.b.inv_mass();
  const LaneMask a_below = holds ? LaneMask{0} : rows.a_below;
  const LaneMask b_below = holds ? LaneMask{0} : rows.b_below;
  const Mask<V> a_lighter = lanes_of<V>(a_below, at) & (mass_a > mass_b) & (mass_b > zero);
  const Mask<V> b_lighter = lanes_of<V>(b_below, at) & (mass_b > mass_a) & (mass_a > zero);
  const Mask<V> scaled = a_lighter | b_lighter;
  const V share_a = xsimd::select(a_lighter, mass_b / mass_a, one);
  const V share_b = xsimd::select(b_lighter, mass_a / mass_b, one);
  if (xsimd::any(scaled)) {
    Responses<V> s{};
    s.add(share_a, pair.a, pair.arm_a, pair.n, pair.t1, pair.t2);
    s.add(share_b, pair.b, pair.arm_b, pair.n, pair.t1, pair.t2);
    m.k_nn = xsimd::select(scaled, s.k_nn, m.k_nn);
    if constexpr (faces) {
      m.n1 = xsimd::select(scaled, s.n1, m.n1);
      m.n2 = xsimd::select(scaled, s.n2, m.n2);
      m.w11 = xsimd::select(scaled, s.w11, m.w11);
      m.w12 = xsimd::select(scaled, s.w12, m.w12);
      m.w22 = xsimd::select(scaled, s.w22, m.w22);
    }
  }
  if constexpr (faces) {
    const Face<V> face(rows, at);
    const Four<V> none{{zero, zero, zero, zero}};
    for (V& each : e.p) each = xsimd::select(active, each, zero);
    const Four<V> dz = solve_lcp<V>(face.there, face.mobility(m), none, e);
    pair.template apply<true>(rows, bits, sum(dz) * pair.n,
                              dot(face.s, dz) * pair.t1 + dot(face.r, dz) * pair.t2, share_a,
                              share_b);
  } else {
    const V3<V> force = solve_point(m.k_nn, zero, xsimd::select(active, e[0], zero)) * pair.n;
    pair.template apply<false>(rows, bits, force, force, share_a, share_b);
  }
  return static_cast<LaneMask>(bits);
}

}  // namespace tandem::pbd::kernel
