// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Impacts after the sweeps: rows that still approach have been hit, and bounce.
#pragma once

#include "contact_pair.h"

namespace tandem::pbd::kernel {

/// Normal velocities of the points of rows; without faces all have the first point's.
template <class A, bool faces>
Four<xsimd::batch<double, A>> normal_velocities(const ContactRows& rows, std::size_t at,
                                                const Pair<A, Velocities::Push>& pair) {
  using V = xsimd::batch<double, A>;
  const V vn = dot(pair.n, pair.velocity());
  Four<V> out{{vn, vn, vn, vn}};
  if constexpr (faces) {
    const V3<V> spin = pair.spin();
    const V w1 = dot(pair.t1, spin), w2 = dot(pair.t2, spin);
    for (std::size_t i = 0; i < 4; ++i) {
      out[i] += w1 * load<V>(rows.s[i], at) + w2 * load<V>(rows.r[i], at);
    }
  }
  return out;
}

template <class A, bool faces>
unsigned meet(const ContactRows& rows, Blow& blow, std::size_t at, double slow, bool first,
              BodyNumbers bodies) {
  using V = xsimd::batch<double, A>;
  const V zero(0.0);
  const auto vn =
      normal_velocities<A, faces>(rows, at, Pair<A, Velocities::Push>(rows, at, bodies));
  const V points = load<V>(rows.points, at), restitution = load<V>(rows.restitution, at);
  Mask<V> carries = zero != zero, hit = zero != zero;
  V fastest = zero;
  for (std::size_t i = 0; i < (faces ? 4 : 1); ++i) {
    const Mask<V> there = points > V(static_cast<double>(i));
    const Mask<V> touches = load<V>(rows.impulse[i], at) > zero;
    // As in solve_faces(): an unloaded point may close its gap.
    const V closing = xsimd::select(touches, zero, most(load<V>(rows.bias[i], at), zero));
    const V approach = zero - (vn[i] + closing);
    const Mask<V> fast = there & (approach > V(slow));
    const V bounce = first ? load<V>(rows.bounce[i], at)
                           : xsimd::select(fast, restitution * (zero - vn[i]), zero);
    carries = carries | touches;
    hit = hit | (first ? fast & (bounce > zero) : fast);
    fastest = most(fastest, xsimd::select(fast, approach, zero));
    store(bounce - closing, blow.target[i], at);
    store(zero, blow.given[i], at);
  }
  store(fastest, blow.change, at);
  return bits_of<V>(hit & carries, at);
}

template <class A, bool faces>
void strike(const ContactRows& rows, Blow& blow, std::size_t at, LaneMask asked,
            BodyNumbers bodies) {
  using V = xsimd::batch<double, A>;
  constexpr std::size_t points = faces ? 4 : 1;
  const V zero(0.0);
  Pair<A, Velocities::Push> pair(rows, at, bodies);
  const Mask<V> meant = lanes_of<V>(asked, at);
  const Responses<V> m = responses<V, faces>(rows, at);
  Four<V> e = normal_velocities<A, faces>(rows, at, pair), z, dz, alone;
  for (std::size_t i = 0; i < points; ++i) {
    z[i] = load<V>(blow.given[i], at);
    e[i] -= load<V>(blow.target[i], at);
  }
  const auto apply = [&](const V& force, const V& c1, const V& c2) {
    pair.template apply<faces>(rows, bits_of<V>(meant, at), force * pair.n,
                               c1 * pair.t1 + c2 * pair.t2);
  };
  if constexpr (faces) {
    const Face<V> face(rows, at);
    const Sym4<V> B = face.mobility(m);
    for (std::size_t i = 0; i < 4; ++i) e[i] = xsimd::select(meant & face.there[i], e[i], zero);
    alone = {{B.m00 * z[0], B.m11 * z[1], B.m22 * z[2], B.m33 * z[3]}};
    dz = solve_lcp<V>(face.there, B, z, e);
    apply(sum(dz), dot(face.s, dz), dot(face.r, dz));
  } else {
    e[0] = xsimd::select(meant, e[0], zero);
    alone[0] = m.k_nn * z[0];
    dz[0] = solve_point(m.k_nn, z[0], e[0]);
    apply(dz[0], zero, zero);
  }
  V change = zero;
  for (std::size_t i = 0; i < points; ++i) {
    change = most(change, xsimd::abs(least(e[i], alone[i])));
    const V d = xsimd::select(meant, dz[i], zero);
    store(z[i] + d, blow.given[i], at);
    store(load<V>(blow.impulse[i], at) + d, blow.impulse[i], at);
  }
  store(xsimd::select(meant, change, zero), blow.change, at);
}

template <class A, bool faces>
void settle(ContactRows& rows, const Blow& blow, std::size_t at, BodyNumbers bodies) {
  using V = xsimd::batch<double, A>;
  const V zero(0.0);
  const Mask<V> meant = lanes_of<V>(blow.struck, at);
  const auto vn =
      normal_velocities<A, faces>(rows, at, Pair<A, Velocities::Push>(rows, at, bodies));
  V fn = zero, c1 = zero, c2 = zero;
  for (std::size_t i = 0; i < (faces ? 4 : 1); ++i) {
    const V z = load<V>(rows.impulse[i], at);
    const V next = xsimd::select(meant, load<V>(blow.impulse[i], at), z);
    const V bounce = load<V>(rows.bounce[i], at);
    store(next, rows.impulse[i], at);
    store(xsimd::select(meant, most(vn[i], zero), bounce), rows.bounce[i], at);
    fn += next - z;
    if constexpr (faces) {
      c1 += (next - z) * load<V>(rows.s[i], at);
      c2 += (next - z) * load<V>(rows.r[i], at);
    }
  }
  Pair<A> pair(rows, at, bodies);
  pair.template apply<faces>(rows, bits_of<V>(meant, at), fn * pair.n, c1 * pair.t1 + c2 * pair.t2);
}

}  // namespace tandem::pbd::kernel
