// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Common parts of the kernels: bodies, responses and faces of rows.
#pragma once

#include "contact_friction.h"

namespace tandem::pbd::kernel {

/// The lanes of a batch from `at` on, as bits.
template <class V>
unsigned bits_of(const Mask<V>& mask, std::size_t at) {
  Lanes set{};
  store(xsimd::select(mask, V(1.0), V(0.0)), set, at);
  unsigned out = 0;
  for (std::size_t i = at; i < at + V::size; ++i) out |= unsigned{set[i] > 0.0} << i;
  return out;
}

/// The bodies of several rows, in the rows' frames.
template <class A, Velocities velocities = Velocities::Now>
struct Pair {
  using V = xsimd::batch<double, A>;
  V3<V> n, t1, t2, arm_a, arm_b;
  Side<A, velocities> a, b;

  [[gnu::always_inline]] Pair(const ContactRows& rows, std::size_t at, BodyNumbers bodies)
      : n(load<V>(rows.normal, at)),
        t1(load<V>(rows.t1, at)),
        t2(cross(n, t1)),
        arm_a(load<V>(rows.arm_a, at)),
        arm_b(load<V>(rows.arm_b, at)),
        a(rows.a, at, bodies),
        b(rows.b, at, bodies) {}

  /// m/s, of b relative to a at the centre of pressure, world.
  V3<V> velocity() const { return b.v() - a.v() + cross(b.w(), arm_b) - cross(a.w(), arm_a); }
  V3<V> spin() const { return b.w() - a.w(); }

  /// Changes both bodies' velocities by a force (N s) and a couple (N m s) on b at the centre of
  /// pressure, world, and their opposites on a.
  /// @tparam couples  whether there is a couple
  /// @param lanes  the rows concerned: adding 0 to the others could change bits
  /// @param share_a  effective share of a's inverse mass and inertia
  template <bool couples>
  [[gnu::always_inline]] void apply(const ContactRows& rows, unsigned lanes, const V3<V>& force,
                                    const V3<V>& couple, const V& share_a = V(1.0),
                                    const V& share_b = V(1.0)) {
    const auto moment = [&](const V3<V>& arm) {
      if constexpr (couples) {
        return cross(arm, force) + couple;
      } else {
        return cross(arm, force);
      }
    };
    a.add((-share_a * a.inv_mass()) * force, -share_a * (a.inv_inertia() * moment(arm_a)));
    b.add((share_b * b.inv_mass()) * force, share_b * (b.inv_inertia() * moment(arm_b)));
    a.write(rows.a_moves & lanes);
    b.write(rows.b_moves & lanes);
  }
};

/// Responses of a row at the centre of pressure, in its axes; see ContactRows.
template <class V>
struct Responses {
  V k_nn = V(0.0), n1 = V(0.0), n2 = V(0.0);  ///< of V_n, W_1, W_2 to F_n, T_1, T_2; symmetric
  V w11 = V(0.0), w12 = V(0.0), w22 = V(0.0);
  TangentBlock<V> k_tt;
  V tn_1n = V(0.0), tn_11 = V(0.0), tn_12 = V(0.0);  ///< of V_1 to F_n, T_1, T_2
  V tn_2n = V(0.0), tn_21 = V(0.0), tn_22 = V(0.0);
  V tn_nn = V(0.0), tn_n1 = V(0.0), tn_n2 = V(0.0);  ///< of W_n

  /// Adds the response of a body; a share of its inverse mass and inertia counts.
  template <class Body>
  void add(const V& share, const Body& body, const V3<V>& arm, const V3<V>& n, const V3<V>& t1,
           const V3<V>& t2) {
    const V inv_mass = share * body.inv_mass();
    const Sym3<V> inertia = body.inv_inertia();
    const V3<V> in = share * (inertia * n), i1 = share * (inertia * t1),
                i2 = share * (inertia * t2);
    const V inn = dot(n, in), in1 = dot(n, i1), in2 = dot(n, i2);
    const V i11 = dot(t1, i1), i12 = dot(t1, i2), i22 = dot(t2, i2);
    const V ln = dot(n, arm), l1 = dot(t1, arm), l2 = dot(t2, arm);
    // W per force: inertia * (arm x F), by rows (n, 1, 2) and columns (F_n, F_1, F_2).
    const V snn = in1 * l2 - in2 * l1, sn1 = in2 * ln - inn * l2, sn2 = inn * l1 - in1 * ln;
    const V s1n = i11 * l2 - i12 * l1, s11 = i12 * ln - in1 * l2, s12 = in1 * l1 - i11 * ln;
    const V s2n = i12 * l2 - i22 * l1, s21 = i22 * ln - in2 * l2, s22 = in2 * l1 - i12 * ln;
    // V per force, beside 1/m: W x arm.
    k_nn += inv_mass + (s1n * l2 - s2n * l1);
    tn_1n += s2n * ln - snn * l2;
    tn_2n += snn * l1 - s1n * ln;
    k_tt.m11 += inv_mass + (s21 * ln - sn1 * l2);
    k_tt.m12 += sn1 * l1 - s11 * ln;
    k_tt.m22 += inv_mass + (sn2 * l1 - s12 * ln);
    n1 += s1n;
    n2 += s2n;
    w11 += i11;
    w12 += i12;
    w22 += i22;
    tn_11 += s11;
    tn_12 += s21;
    tn_21 += s12;
    tn_22 += s22;
    tn_nn += snn;
    tn_n1 += in1;
    tn_n2 += in2;
    k_tt.m1n += sn1;
    k_tt.m2n += sn2;
    k_tt.mnn += inn;
  }
};

/// The normals of faces: data common to the points of a manifold.
template <class V>
struct Face {
  std::array<Mask<V>, 4> there;
  Four<V> s, r, self_stress;

  Face(const ContactRows& rows, std::size_t at) {
    const V points = load<V>(rows.points, at);
    for (std::size_t i = 0; i < 4; ++i) {
      there[i] = points > V(static_cast<double>(i));
      s[i] = load<V>(rows.s[i], at);
      r[i] = load<V>(rows.r[i], at);
      self_stress[i] = load<V>(rows.self_stress[i], at);
    }
  }

  /// Response of the points' normal velocities to their impulses, 1/kg.
  Sym4<V> mobility(const Responses<V>& m) const {
    // Responses of V_n, W_1 and W_2 to a unit impulse at each point.
    Four<V> v, w1, w2;
    for (std::size_t i = 0; i < 4; ++i) {
      v[i] = m.k_nn + m.n1 * s[i] + m.n2 * r[i];
      w1[i] = m.n1 + m.w11 * s[i] + m.w12 * r[i];
      w2[i] = m.n2 + m.w12 * s[i] + m.w22 * r[i];
    }
    const auto of = [&](std::size_t i, std::size_t j) {
      return v[j] + s[i] * w1[j] + r[i] * w2[j];
    };
    return {of(0, 0), of(1, 0), of(1, 1), of(2, 0), of(2, 1),
            of(2, 2), of(3, 0), of(3, 1), of(3, 2), of(3, 3)};
  }
};

/// The responses that prepare() stored.
template <class V, bool faces>
[[gnu::always_inline]] inline Responses<V> responses(const ContactRows& rows, std::size_t at) {
  Responses<V> m;
  m.k_nn = load<V>(rows.k_nn, at);
  m.k_tt.m11 = load<V>(rows.k_tt[0], at);
  m.k_tt.m12 = load<V>(rows.k_tt[1], at);
  m.k_tt.m22 = load<V>(rows.k_tt[2], at);
  m.tn_1n = load<V>(rows.k_tn[0], at);
  m.tn_2n = load<V>(rows.k_tn[1], at);
  if constexpr (faces) {
    m.n1 = load<V>(rows.k_nn_face[0], at);
    m.n2 = load<V>(rows.k_nn_face[1], at);
    m.w11 = load<V>(rows.k_nn_face[2], at);
    m.w12 = load<V>(rows.k_nn_face[3], at);
    m.w22 = load<V>(rows.k_nn_face[4], at);
    m.k_tt.m1n = load<V>(rows.k_tt_face[0], at);
    m.k_tt.m2n = load<V>(rows.k_tt_face[1], at);
    m.k_tt.mnn = load<V>(rows.k_tt_face[2], at);
    m.tn_11 = load<V>(rows.k_tn_face[0], at);
    m.tn_12 = load<V>(rows.k_tn_face[1], at);
    m.tn_21 = load<V>(rows.k_tn_face[2], at);
    m.tn_22 = load<V>(rows.k_tn_face[3], at);
    m.tn_nn = load<V>(rows.k_tn_face[4], at);
    m.tn_n1 = load<V>(rows.k_tn_face[5], at);
    m.tn_n2 = load<V>(rows.k_tn_face[6], at);
  }
  return m;
}

/// Mask of the lanes from `at` on whose bit is set.
template <class V>
Mask<V> lanes_of(LaneMask mask, std::size_t at) {
  static constexpr auto kSets = [] {
    std::array<Lanes, 1u << kLanes> sets{};
    for (std::size_t m = 0; m < sets.size(); ++m) {
      for (std::size_t i = 0; i < kLanes; ++i) sets[m][i] = m >> i & 1u ? 1.0 : 0.0;
    }
    return sets;
  }();
  return load<V>(kSets[mask & kAllLanes], at) > V(0.0);
}

/// Change of the multiplier z of a single point with velocity e and mobility m.
template <class V>
V solve_point(const V& m, const V& z, const V& e) {
  return most(-z, xsimd::select(m > V(0.0), -e / m, V(0.0)));
}

}  // namespace tandem::pbd::kernel
