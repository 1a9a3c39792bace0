// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Rows on velocities: preparation per step and per substep, and a row of a sweep. Most of a sweep's
// time is spent here.
#pragma once

#include "contact_pair.h"

namespace tandem::pbd::kernel {

/// @tparam all  whether all rows are prepared
template <class A, bool faces, bool all>
[[gnu::flatten]] void prepare(ContactRows& rows, std::size_t at, LaneMask asked,
                              BodyNumbers bodies) {
  using V = xsimd::batch<double, A>;
  const Mask<V> meant = lanes_of<V>(asked, at);
  const auto put = [&](const V& value, Lanes& lanes) {
    store(all ? value : xsimd::select(meant, value, load<V>(lanes, at)), lanes, at);
  };
  const Pair<A> pair(rows, at, bodies);
  Responses<V> m{};
  m.add(V(1.0), pair.a, pair.arm_a, pair.n, pair.t1, pair.t2);
  m.add(V(1.0), pair.b, pair.arm_b, pair.n, pair.t1, pair.t2);
  put(m.k_nn, rows.k_nn);
  put(m.k_tt.m11, rows.k_tt[0]);
  put(m.k_tt.m12, rows.k_tt[1]);
  put(m.k_tt.m22, rows.k_tt[2]);
  put(m.tn_1n, rows.k_tn[0]);
  put(m.tn_2n, rows.k_tn[1]);
  if constexpr (faces) {
    const std::array<V, 5> normal{m.n1, m.n2, m.w11, m.w12, m.w22};
    for (std::size_t i = 0; i < normal.size(); ++i) put(normal[i], rows.k_nn_face[i]);
    const std::array<V, 3> tangent{m.k_tt.m1n, m.k_tt.m2n, m.k_tt.mnn};
    for (std::size_t i = 0; i < tangent.size(); ++i) put(tangent[i], rows.k_tt_face[i]);
    const std::array<V, 7> coupling{m.tn_11, m.tn_12, m.tn_21, m.tn_22, m.tn_nn, m.tn_n1, m.tn_n2};
    for (std::size_t i = 0; i < coupling.size(); ++i) put(coupling[i], rows.k_tn_face[i]);
  }
}

/// Results of begin(), as bits.
struct Begun {
  unsigned penetrating = 0;
  bool bounces = false;
};

template <class A, bool faces>
[[gnu::flatten]] Begun begin(ContactRows& rows, std::size_t at, const SubstepRule& rule,
                             BodyNumbers bodies, AnchorNumbers anchors) {
  using V = xsimd::batch<double, A>;
  constexpr std::size_t points = faces ? 4 : 1;
  const V zero(0.0), one(1.0), h(rule.h);
  const Pair<A> pair(rows, at, bodies);
  const V3<V> velocity = pair.velocity(), spin = pair.spin();
  const V vn = dot(pair.n, velocity), w1 = dot(pair.t1, spin), w2 = dot(pair.t2, spin);
  // One rotation of the normal serves all points.
  const V3<V> n_a = pair.a.to_local(pair.n), n_b = pair.b.to_local(pair.n);
  const V apart = dot(pair.n, pair.b.x() - pair.a.x()) - load<V>(rows.radii, at);

  V impulse[points];
  for (std::size_t i = 0; i < points; ++i) {
    impulse[i] = load<V>(rows.impulse[i], at);
    if (rule.first) impulse[i] *= h;
  }
  const auto total = [&] {
    if constexpr (faces) {
      return (impulse[0] + impulse[1]) + (impulse[2] + impulse[3]);
    } else {
      return impulse[0];
    }
  };
  const V pressed = total();
  const V carried = load<V>(rows.carried, at);
  if (rule.first) {
    store(zero, rows.pressed, at);
    store(zero, rows.fastest, at);
  } else {
    const V stopped = xsimd::select(pressed > zero, load<V>(rows.approach, at), zero);
    store(load<V>(rows.pressed, at) + pressed, rows.pressed, at);
    store(most(load<V>(rows.fastest, at), stopped), rows.fastest, at);
  }
  // A loaded point that still closes has not been stopped: see kGrowth.
  V closing = zero - vn;
  if constexpr (faces) {
    for (std::size_t i = 0; i < 4; ++i) {
      const V e = vn + w1 * load<V>(rows.s[i], at) + w2 * load<V>(rows.r[i], at);
      closing = xsimd::select(impulse[i] > zero, most(closing, zero - e), closing);
    }
  }
  const V limit = rule.first ? carried * pressed
                             : V(kGrowth) * carried + V(rule.growth) / load<V>(rows.k_nn, at);
  const Mask<V> over = (pressed > limit) & (closing <= V(rule.growth));
  const V share = xsimd::select(over, limit / pressed, one);

  const V count = load<V>(rows.points, at);
  const V restitution = load<V>(rows.restitution, at);
  const bool elastic = xsimd::any(restitution > zero);
  V fastest = zero;
  Mask<V> penetrating = zero != zero, bounces = zero != zero;
  From<A> from;
  for (std::size_t lane = 0; lane < V::size; ++lane)
    from[lane] = anchors.of(rows.contact[at + lane]);
  for (std::size_t i = 0; i < points; ++i) {
    const Mask<V> there = count > V(static_cast<double>(i));
    const std::size_t point = i * AnchorNumbers::kPoint;
    const auto first = Columns<A>::read(from, point);  // anchor in a, and x of that in b
    const auto second = Columns<A>::read(from, point + 4);
    const V3<V> anchor_a{first.c0, first.c1, first.c2}, anchor_b{first.c3, second.c0, second.c1};
    const V gap = apart + dot(n_b, anchor_b) - dot(n_a, anchor_a);
    const V opened = most(V(kPushGain) * gap / h, V(-rule.push_speed));
    const V closes = gap / h;
    const V asked = xsimd::select(closes > V(rule.resting), closes, zero);
    store(xsimd::select(gap > zero, asked, opened), rows.bias[i], at);
    penetrating = penetrating | (there & (gap < V(-rule.push_slop)));
    impulse[i] = xsimd::select(gap < V(rule.warm_start_gap), share * impulse[i], zero);
    store(impulse[i], rows.impulse[i], at);
    V approach = zero - vn;
    if constexpr (faces) {
      approach -= w1 * load<V>(rows.s[i], at) + w2 * load<V>(rows.r[i], at);
    }
    fastest = most(fastest, xsimd::select(there, approach, zero));
    V bounce = zero;
    if (elastic) {
      // Restitution e is the ratio e^2 of energies. The energy is the one that semi-implicit Euler
      // conserves in free fall, v^2 / 2 + a x - a h v / 2, so that the height of a bounce does not
      // depend on h.
      const Mask<V> back = there & (restitution > zero) & (approach > V(rule.bounce_speed));
      const V a = load<V>(rows.fall, at);
      const V twice = approach * approach + (a + a) * most(gap, zero) + a * h * approach;
      const V half = V(0.5) * a * h;
      const V speed = half + xsimd::sqrt(half * half + restitution * restitution * twice);
      bounce = xsimd::select(back, speed, zero);
      bounces = bounces | back;
    }
    store(bounce, rows.bounce[i], at);
  }
  store(fastest, rows.approach, at);
  const V now = total();
  store(now, rows.carried, at);
  const V scale = rule.first ? h * share : share;
  const V friction = xsimd::select(now > zero, scale, zero);
  store(friction * load<V>(rows.slide[0], at), rows.slide[0], at);
  store(friction * load<V>(rows.slide[1], at), rows.slide[1], at);
  if constexpr (faces) store(friction * load<V>(rows.twist, at), rows.twist, at);
  return {bits_of<V>(penetrating, at), xsimd::any(bounces)};
}

template <class A, bool faces>
[[gnu::flatten]] void warm_start(const ContactRows& rows, std::size_t at, BodyNumbers bodies) {
  using V = xsimd::batch<double, A>;
  Pair<A> pair(rows, at, bodies);
  V press = load<V>(rows.impulse[0], at);
  V3<V> couple{press, press, press};
  if constexpr (faces) {
    V p1(0.0), p2(0.0);
    p1 = press * load<V>(rows.s[0], at);
    p2 = press * load<V>(rows.r[0], at);
    for (std::size_t i = 1; i < 4; ++i) {
      const V z = load<V>(rows.impulse[i], at);
      press += z;
      p1 += z * load<V>(rows.s[i], at);
      p2 += z * load<V>(rows.r[i], at);
    }
    couple = load<V>(rows.twist, at) * pair.n + p1 * pair.t1 + p2 * pair.t2;
  }
  const V3<V> force =
      press * pair.n + load<V>(rows.slide[0], at) * pair.t1 + load<V>(rows.slide[1], at) * pair.t2;
  pair.template apply<faces>(rows, kAllLanes, force, couple);
}

template <class A>
[[gnu::flatten]] void solve_points(ContactRows& rows, std::size_t at, ContactPass pass,
                                   int iterations, LaneMask asked, BodyNumbers bodies) {
  using V = xsimd::batch<double, A>;
  const V zero(0.0);
  Pair<A> pair(rows, at, bodies);
  const V3<V> velocity = pair.velocity();
  V z = load<V>(rows.impulse[0], at);
  V e = dot(pair.n, velocity);
  // See solve_faces().
  const V closing = most(load<V>(rows.bias[0], at), zero);
  Mask<V> active = z > zero;
  if (pass == ContactPass::Motion) {
    e += closing;
    active = active | (e < zero);
  } else {
    if (rows.bounces) e -= load<V>(rows.bounce[0], at);
  }
  const Mask<V> meant = lanes_of<V>(asked, at);
  active = active & meant;
  const V before = load<V>(rows.change, at);
  if (xsimd::none(active)) return store(xsimd::select(meant, zero, before), rows.change, at);
  e = xsimd::select(active, e, zero);
  const Responses<V> m = responses<V, false>(rows, at);
  const V change = xsimd::abs(least(e, m.k_nn * z));
  store(xsimd::select(meant, change, before), rows.change, at);
  const V friction = load<V>(rows.friction, at);
  const Mask<V> has_friction = active & (friction > zero);
  const V slip_1 = dot(pair.t1, velocity), slip_2 = dot(pair.t2, velocity);
  const V scale = V(1.0) / (m.k_tt.m11 * m.k_tt.m22 - m.k_tt.m12 * m.k_tt.m12);
  V f1 = load<V>(rows.slide[0], at), f2 = load<V>(rows.slide[1], at);
  V pressed = zero, friction_1 = zero, friction_2 = zero;  // N s, changes so far
  for (int k = 0; k < iterations; ++k) {
    V dz = solve_point(m.k_nn, z, e);
    if (k > 0) dz = xsimd::select(has_friction, dz, zero);
    z += dz;
    pressed += dz;
    if (xsimd::none(has_friction)) break;
    // Friction uses the latest normal impulse, and the normal the latest friction.
    const V v1 = slip_1 + m.tn_1n * pressed + (m.k_tt.m11 * friction_1 + m.k_tt.m12 * friction_2);
    const V v2 = slip_2 + m.tn_2n * pressed + (m.k_tt.m12 * friction_1 + m.k_tt.m22 * friction_2);
    V s1 = f1 - scale * (m.k_tt.m22 * v1 - m.k_tt.m12 * v2);
    V s2 = f2 - scale * (m.k_tt.m11 * v2 - m.k_tt.m12 * v1);
    const V limit = friction * z;
    const Mask<V> slips = s1 * s1 + s2 * s2 > limit * limit;
    if (xsimd::any(slips)) {
      const V m_slide = mean_response(m.k_tt);
      s1 = xsimd::select(slips, f1 - v1 / m_slide, s1);
      s2 = xsimd::select(slips, f2 - v2 / m_slide, s2);
    }
    const V length = xsimd::sqrt(s1 * s1 + s2 * s2);
    const V share = xsimd::select(length > limit, limit / length, V(1.0));
    s1 = xsimd::select(has_friction, xsimd::select(limit > zero, share * s1, zero), f1);
    s2 = xsimd::select(has_friction, xsimd::select(limit > zero, share * s2, zero), f2);
    const V d1 = s1 - f1, d2 = s2 - f2;
    f1 = s1;
    f2 = s2;
    friction_1 += d1;
    friction_2 += d2;
    if (k + 1 < iterations) e += m.k_nn * dz + (m.tn_1n * d1 + m.tn_2n * d2);
  }
  store(z, rows.impulse[0], at);
  store(f1, rows.slide[0], at);
  store(f2, rows.slide[1], at);
  const V3<V> force = pressed * pair.n + friction_1 * pair.t1 + friction_2 * pair.t2;
  pair.template apply<false>(rows, bits_of<V>(active, at), force, force);
}

template <class A>
[[gnu::flatten]] void solve_faces(ContactRows& rows, std::size_t at, ContactPass pass,
                                  int iterations, LaneMask asked, BodyNumbers bodies) {
  using V = xsimd::batch<double, A>;
  const V zero(0.0);
  Pair<A> pair(rows, at, bodies);
  const V3<V> velocity = pair.velocity(), spin = pair.spin();
  const Face<V> face(rows, at);
  const V vn = dot(pair.n, velocity), w1 = dot(pair.t1, spin), w2 = dot(pair.t2, spin);
  Four<V> z, e;
  Mask<V> active = zero != zero;
  for (std::size_t i = 0; i < 4; ++i) {
    z[i] = load<V>(rows.impulse[i], at);
    active = active | (z[i] > zero);
  }
  for (std::size_t i = 0; i < 4; ++i) {
    const V closing = most(load<V>(rows.bias[i], at), zero);
    e[i] = vn + w1 * face.s[i] + w2 * face.r[i];
    if (pass == ContactPass::Motion) {
      e[i] += closing;
      active = active | (face.there[i] & (e[i] < zero));
    } else {
      // An unloaded point may still close the rest of its gap. A row without any load is skipped.
      e[i] += xsimd::select(z[i] > zero, zero, closing);
      if (rows.bounces) e[i] -= load<V>(rows.bounce[i], at);
    }
  }
  const Mask<V> meant = lanes_of<V>(asked, at);
  active = active & meant;
  const V before = load<V>(rows.change, at);
  if (xsimd::none(active)) return store(xsimd::select(meant, zero, before), rows.change, at);
  for (std::size_t i = 0; i < 4; ++i) e[i] = xsimd::select(active & face.there[i], e[i], zero);
  const Responses<V> m = responses<V, true>(rows, at);
  const Sym4<V> B = face.mobility(m);
  // Violation of 0 <= z _|_ e >= 0.
  const Four<V> alone{{B.m00 * z[0], B.m11 * z[1], B.m22 * z[2], B.m33 * z[3]}};
  V change = zero;
  for (std::size_t i = 0; i < 4; ++i) {
    change = most(change, xsimd::abs(least(e[i], alone[i])));
  }
  store(xsimd::select(meant, change, before), rows.change, at);

  const V friction = load<V>(rows.friction, at);
  const Mask<V> has_friction = active & (friction > zero);
  const V slip_1 = dot(pair.t1, velocity), slip_2 = dot(pair.t2, velocity);
  const V spin_n = dot(pair.n, spin);
  const TangentBlock<V>& k_tt = m.k_tt;
  const V scale = V(1.0) / (k_tt.m11 * k_tt.m22 - k_tt.m12 * k_tt.m12);
  const V inverse_twist = xsimd::select(k_tt.mnn > zero, V(1.0) / k_tt.mnn, zero);
  const Four<V> reach{{load<V>(rows.reach[0], at), load<V>(rows.reach[1], at),
                       load<V>(rows.reach[2], at), load<V>(rows.reach[3], at)}};
  Slide<V> slide{load<V>(rows.slide[0], at), load<V>(rows.slide[1], at), load<V>(rows.twist, at)};
  V fn = zero, c1 = zero, c2 = zero;  // N s, N m s: what the normals did so far
  Slide<V> friction_change{zero, zero, zero};
  for (int k = 0; k < iterations; ++k) {
    Four<V> dz = solve_lcp<V>(face.there, B, z, e);
    for (std::size_t i = 0; i < 4; ++i) {
      if (k > 0) dz[i] = xsimd::select(has_friction, dz[i], zero);
      z[i] += dz[i];
    }
    fn += sum(dz);
    c1 += dot(face.s, dz);
    c2 += dot(face.r, dz);
    if (xsimd::none(has_friction)) break;
    // Friction uses the latest normal impulses, and they the latest friction.
    const V v1 = slip_1 + (m.tn_1n * fn + m.tn_11 * c1 + m.tn_12 * c2) +
                 (k_tt.m11 * friction_change.f1 + k_tt.m12 * friction_change.f2 +
                  k_tt.m1n * friction_change.tn);
    const V v2 = slip_2 + (m.tn_2n * fn + m.tn_21 * c1 + m.tn_22 * c2) +
                 (k_tt.m12 * friction_change.f1 + k_tt.m22 * friction_change.f2 +
                  k_tt.m2n * friction_change.tn);
    const V wn = spin_n + (m.tn_nn * fn + m.tn_n1 * c1 + m.tn_n2 * c2) +
                 (k_tt.m1n * friction_change.f1 + k_tt.m2n * friction_change.f2 +
                  k_tt.mnn * friction_change.tn);
    Slide<V> next{slide.f1 - scale * (k_tt.m22 * v1 - k_tt.m12 * v2),
                  slide.f2 - scale * (k_tt.m11 * v2 - k_tt.m12 * v1),
                  slide.tn - inverse_twist * wn};
    keep_within<V>(k_tt, slide, {v1, v2}, {friction * sum(z), friction * dot(z, reach)}, next);
    next = {xsimd::select(has_friction, next.f1, slide.f1),
            xsimd::select(has_friction, next.f2, slide.f2),
            xsimd::select(has_friction, next.tn, slide.tn)};
    const Slide<V> d{next.f1 - slide.f1, next.f2 - slide.f2, next.tn - slide.tn};
    slide = next;
    friction_change = {friction_change.f1 + d.f1, friction_change.f2 + d.f2,
                       friction_change.tn + d.tn};
    if (k + 1 == iterations) break;
    const V back_n = m.tn_1n * d.f1 + m.tn_2n * d.f2 + m.tn_nn * d.tn;
    const V back_1 = m.tn_11 * d.f1 + m.tn_21 * d.f2 + m.tn_n1 * d.tn;
    const V back_2 = m.tn_12 * d.f1 + m.tn_22 * d.f2 + m.tn_n2 * d.tn;
    const Four<V> response = B * dz;
    for (std::size_t i = 0; i < 4; ++i) {
      e[i] += response[i] + (back_n + back_1 * face.s[i] + back_2 * face.r[i]);
    }
  }
  share_evenly(active, face.self_stress, z);
  for (std::size_t i = 0; i < 4; ++i) store(z[i], rows.impulse[i], at);
  store(slide.f1, rows.slide[0], at);
  store(slide.f2, rows.slide[1], at);
  store(slide.tn, rows.twist, at);
  pair.template apply<true>(
      rows, bits_of<V>(active, at),
      fn * pair.n + friction_change.f1 * pair.t1 + friction_change.f2 * pair.t2,
      friction_change.tn * pair.n + c1 * pair.t1 + c2 * pair.t2);
}

}  // namespace tandem::pbd::kernel
