// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// What is done with rows, for A::size of them at once. This is most of a sweep.
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

/// The bodies of rows, read at once, in the rows' frames.
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

  /// m/s, of b against a at the centre of pressure, world.
  V3<V> velocity() const { return b.v() - a.v() + cross(b.w(), arm_b) - cross(a.w(), arm_a); }
  V3<V> spin() const { return b.w() - a.w(); }

  /// Change both bodies' velocities by a force (N s) and a couple (N m s) on b at the centre of
  /// pressure, world, and their opposites on a.
  /// @tparam couples  else there is none
  /// @param lanes  the rows that do so: even adding 0 could change a bit
  /// @param share_a  of the inverse mass and inertia of a that counts
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
  V press_n = V(0.0), n1 = V(0.0), n2 = V(0.0);  ///< of V_n, W_1, W_2 to F_n, T_1, T_2; symmetric
  V w11 = V(0.0), w12 = V(0.0), w22 = V(0.0);
  Grip<V> grip;
  V slip_1n = V(0.0), slip_11 = V(0.0), slip_12 = V(0.0);  ///< of V_1 to F_n, T_1, T_2
  V slip_2n = V(0.0), slip_21 = V(0.0), slip_22 = V(0.0);
  V slip_nn = V(0.0), slip_n1 = V(0.0), slip_n2 = V(0.0);  ///< of W_n

  /// Add those of a body, of whose inverse mass and inertia a share counts.
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
    press_n += inv_mass + (s1n * l2 - s2n * l1);
    slip_1n += s2n * ln - snn * l2;
    slip_2n += snn * l1 - s1n * ln;
    grip.m11 += inv_mass + (s21 * ln - sn1 * l2);
    grip.m12 += sn1 * l1 - s11 * ln;
    grip.m22 += inv_mass + (sn2 * l1 - s12 * ln);
    n1 += s1n;
    n2 += s2n;
    w11 += i11;
    w12 += i12;
    w22 += i22;
    slip_11 += s11;
    slip_12 += s21;
    slip_21 += s12;
    slip_22 += s22;
    slip_nn += snn;
    slip_n1 += in1;
    slip_n2 += in2;
    grip.m1n += sn1;
    grip.m2n += sn2;
    grip.mnn += inn;
  }
};

/// The normals of faces: what the points of a manifold have in common.
template <class V>
struct Face {
  std::array<Mask<V>, 4> there;
  Four<V> s, r, idle;

  Face(const ContactRows& rows, std::size_t at) {
    const V points = load<V>(rows.points, at);
    for (std::size_t i = 0; i < 4; ++i) {
      there[i] = points > V(static_cast<double>(i));
      s[i] = load<V>(rows.s[i], at);
      r[i] = load<V>(rows.r[i], at);
      idle[i] = load<V>(rows.idle[i], at);
    }
  }

  /// Response of the points' normal velocities to their impulses, idle combination included, 1/kg.
  Sym4<V> mobility(const Responses<V>& m) const {
    // Responses of V_n, W_1 and W_2 to a unit impulse at each point.
    Four<V> v, w1, w2;
    for (std::size_t i = 0; i < 4; ++i) {
      v[i] = m.press_n + m.n1 * s[i] + m.n2 * r[i];
      w1[i] = m.n1 + m.w11 * s[i] + m.w12 * r[i];
      w2[i] = m.n2 + m.w12 * s[i] + m.w22 * r[i];
    }
    const auto of = [&](std::size_t i, std::size_t j) {
      return v[j] + s[i] * w1[j] + r[i] * w2[j] + idle[i] * idle[j];
    };
    return {of(0, 0), of(1, 0), of(1, 1), of(2, 0), of(2, 1),
            of(2, 2), of(3, 0), of(3, 1), of(3, 2), of(3, 3)};
  }
};

/// The responses as they were prepared.
template <class V, bool faces>
[[gnu::always_inline]] inline Responses<V> responses(const ContactRows& rows, std::size_t at) {
  Responses<V> m;
  m.press_n = load<V>(rows.press_n, at);
  m.grip.m11 = load<V>(rows.grip[0], at);
  m.grip.m12 = load<V>(rows.grip[1], at);
  m.grip.m22 = load<V>(rows.grip[2], at);
  m.slip_1n = load<V>(rows.slip_n[0], at);
  m.slip_2n = load<V>(rows.slip_n[1], at);
  if constexpr (faces) {
    m.n1 = load<V>(rows.press_w[0], at);
    m.n2 = load<V>(rows.press_w[1], at);
    m.w11 = load<V>(rows.press_w[2], at);
    m.w12 = load<V>(rows.press_w[3], at);
    m.w22 = load<V>(rows.press_w[4], at);
    m.grip.m1n = load<V>(rows.grip_w[0], at);
    m.grip.m2n = load<V>(rows.grip_w[1], at);
    m.grip.mnn = load<V>(rows.grip_w[2], at);
    m.slip_11 = load<V>(rows.slip_w[0], at);
    m.slip_12 = load<V>(rows.slip_w[1], at);
    m.slip_21 = load<V>(rows.slip_w[2], at);
    m.slip_22 = load<V>(rows.slip_w[3], at);
    m.slip_nn = load<V>(rows.slip_w[4], at);
    m.slip_n1 = load<V>(rows.slip_w[5], at);
    m.slip_n2 = load<V>(rows.slip_w[6], at);
  }
  return m;
}

template <class A, bool faces>
[[gnu::flatten]] void prepare(ContactRows& rows, std::size_t at, double evenness,
                              BodyNumbers bodies) {
  using V = xsimd::batch<double, A>;
  const Pair<A> pair(rows, at, bodies);
  Responses<V> m{};
  m.add(V(1.0), pair.a, pair.arm_a, pair.n, pair.t1, pair.t2);
  m.add(V(1.0), pair.b, pair.arm_b, pair.n, pair.t1, pair.t2);
  store(m.press_n, rows.press_n, at);
  store(m.grip.m11, rows.grip[0], at);
  store(m.grip.m12, rows.grip[1], at);
  store(m.grip.m22, rows.grip[2], at);
  store(m.slip_1n, rows.slip_n[0], at);
  store(m.slip_2n, rows.slip_n[1], at);
  if constexpr (faces) {
    const std::array<V, 5> press{m.n1, m.n2, m.w11, m.w12, m.w22};
    for (std::size_t i = 0; i < press.size(); ++i) store(press[i], rows.press_w[i], at);
    const std::array<V, 3> grip{m.grip.m1n, m.grip.m2n, m.grip.mnn};
    for (std::size_t i = 0; i < grip.size(); ++i) store(grip[i], rows.grip_w[i], at);
    const std::array<V, 7> slip{m.slip_11, m.slip_12, m.slip_21, m.slip_22,
                                m.slip_nn, m.slip_n1, m.slip_n2};
    for (std::size_t i = 0; i < slip.size(); ++i) store(slip[i], rows.slip_w[i], at);
    const Face<V> face(rows, at);
    Face<V> plain = face;
    for (V& idle : plain.idle.p) idle = V(0.0);
    const Sym4<V> B = plain.mobility(m);
    const V scale = xsimd::sqrt(V(evenness) * ((B.m00 + B.m11) + (B.m22 + B.m33)));
    for (std::size_t i = 0; i < 4; ++i) store(scale * face.idle[i], rows.idle[i], at);
  }
}

/// What begin() finds, as bits.
struct Begun {
  unsigned sunk = 0;
  bool bounces = false;
};

template <class A, bool faces>
[[gnu::flatten]] Begun begin(ContactRows& rows, std::size_t at, const SubstepRule& rule,
                             BodyNumbers bodies) {
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
  // What still closes where it carries has not been stopped: see kGrowth.
  V closing = zero - vn;
  if constexpr (faces) {
    for (std::size_t i = 0; i < 4; ++i) {
      const V e = vn + w1 * load<V>(rows.s[i], at) + w2 * load<V>(rows.r[i], at);
      closing = xsimd::select(impulse[i] > zero, most(closing, zero - e), closing);
    }
  }
  const V limit = rule.first ? carried * pressed
                             : V(kGrowth) * carried + V(rule.growth) / load<V>(rows.press_n, at);
  const Mask<V> over = (pressed > limit) & (closing <= V(rule.growth));
  const V share = xsimd::select(over, limit / pressed, one);

  const V count = load<V>(rows.points, at);
  const V restitution = load<V>(rows.restitution, at);
  const bool elastic = xsimd::any(restitution > zero);
  V fastest = zero;
  Mask<V> sunk = zero != zero, bounces = zero != zero;
  for (std::size_t i = 0; i < points; ++i) {
    const Mask<V> there = count > V(static_cast<double>(i));
    const V gap =
        apart + dot(n_b, load<V>(rows.anchor_b[i], at)) - dot(n_a, load<V>(rows.anchor_a[i], at));
    const V opened = most(V(rule.push_gain) * gap / h, V(-rule.push_speed));
    store(xsimd::select(gap > zero, gap / h, opened), rows.bias[i], at);
    sunk = sunk | (there & (gap < V(-rule.push_slop)));
    impulse[i] = xsimd::select(gap < V(rule.warm_start_gap), share * impulse[i], zero);
    store(impulse[i], rows.impulse[i], at);
    V approach = zero - vn;
    if constexpr (faces) {
      approach -= w1 * load<V>(rows.s[i], at) + w2 * load<V>(rows.r[i], at);
    }
    fastest = most(fastest, xsimd::select(there, approach, zero));
    V bounce = zero;
    if (elastic) {
      // Restitution e is the ratio of energies, e^2, of what semi-implicit Euler conserves in free
      // fall, v^2 / 2 + a x - a h v / 2, so that the height of a bounce does not depend on h.
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
  const V friction = xsimd::select(now > zero, share, zero);
  store(friction * load<V>(rows.slide[0], at), rows.slide[0], at);
  store(friction * load<V>(rows.slide[1], at), rows.slide[1], at);
  if constexpr (faces) store(friction * load<V>(rows.twist, at), rows.twist, at);
  return {bits_of<V>(sunk, at), xsimd::any(bounces)};
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

/// The lanes from `at` on whose bit is set.
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

/// Change of the multiplier z of a point alone, whose velocity is e and its mobility m.
template <class V>
V solve_point(const V& m, const V& z, const V& e) {
  return most(-z, xsimd::select(m > V(0.0), -e / m, V(0.0)));
}

template <class A>
[[gnu::flatten]] void solve_points(ContactRows& rows, std::size_t at, ContactPass pass, int turns,
                                   LaneMask asked, BodyNumbers bodies) {
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
  const V change = xsimd::abs(least(e, m.press_n * z));
  store(xsimd::select(meant, change, before), rows.change, at);
  const V friction = load<V>(rows.friction, at);
  const Mask<V> rubs = active & (friction > zero);
  const V slip_1 = dot(pair.t1, velocity), slip_2 = dot(pair.t2, velocity);
  const V scale = V(1.0) / (m.grip.m11 * m.grip.m22 - m.grip.m12 * m.grip.m12);
  V f1 = load<V>(rows.slide[0], at), f2 = load<V>(rows.slide[1], at);
  V pressed = zero, rubbed_1 = zero, rubbed_2 = zero;  // N s, changes so far
  for (int turn = 0; turn < turns; ++turn) {
    V dz = solve_point(m.press_n, z, e);
    if (turn > 0) dz = xsimd::select(rubs, dz, zero);
    z += dz;
    pressed += dz;
    if (xsimd::none(rubs)) break;
    // Friction sees what the normal has just done, and the normal what it does.
    const V v1 = slip_1 + m.slip_1n * pressed + (m.grip.m11 * rubbed_1 + m.grip.m12 * rubbed_2);
    const V v2 = slip_2 + m.slip_2n * pressed + (m.grip.m12 * rubbed_1 + m.grip.m22 * rubbed_2);
    V s1 = f1 - scale * (m.grip.m22 * v1 - m.grip.m12 * v2);
    V s2 = f2 - scale * (m.grip.m11 * v2 - m.grip.m12 * v1);
    const V limit = friction * z;
    const V length = xsimd::sqrt(s1 * s1 + s2 * s2);
    const V share = xsimd::select(length > limit, limit / length, V(1.0));
    s1 = xsimd::select(rubs, xsimd::select(limit > zero, share * s1, zero), f1);
    s2 = xsimd::select(rubs, xsimd::select(limit > zero, share * s2, zero), f2);
    const V d1 = s1 - f1, d2 = s2 - f2;
    f1 = s1;
    f2 = s2;
    rubbed_1 += d1;
    rubbed_2 += d2;
    if (turn + 1 < turns) e += m.press_n * dz + (m.slip_1n * d1 + m.slip_2n * d2);
  }
  store(z, rows.impulse[0], at);
  store(f1, rows.slide[0], at);
  store(f2, rows.slide[1], at);
  const V3<V> force = pressed * pair.n + rubbed_1 * pair.t1 + rubbed_2 * pair.t2;
  pair.template apply<false>(rows, bits_of<V>(active, at), force, force);
}

template <class A>
[[gnu::flatten]] void solve_faces(ContactRows& rows, std::size_t at, ContactPass pass, int turns,
                                  LaneMask asked, BodyNumbers bodies) {
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
      // A point that carries nothing may still close what is left of its gap. A row that carries
      // nothing at all has no say.
      e[i] += xsimd::select(z[i] > zero, zero, closing);
      if (rows.bounces) e[i] -= load<V>(rows.bounce[i], at);
    }
  }
  const Mask<V> meant = lanes_of<V>(asked, at);
  active = active & meant;
  const V before = load<V>(rows.change, at);
  if (xsimd::none(active)) return store(xsimd::select(meant, zero, before), rows.change, at);
  const V idle = dot(face.idle, z);
  for (std::size_t i = 0; i < 4; ++i) {
    e[i] = xsimd::select(active & face.there[i], e[i] + idle * face.idle[i], zero);
  }
  const Responses<V> m = responses<V, true>(rows, at);
  const Sym4<V> B = face.mobility(m);
  // How far the points are from 0 <= z _|_ e >= 0.
  const Four<V> alone{{B.m00 * z[0], B.m11 * z[1], B.m22 * z[2], B.m33 * z[3]}};
  V change = zero;
  for (std::size_t i = 0; i < 4; ++i) {
    change = most(change, xsimd::abs(least(e[i], alone[i])));
  }
  store(xsimd::select(meant, change, before), rows.change, at);

  const V friction = load<V>(rows.friction, at);
  const Mask<V> rubs = active & (friction > zero);
  const V slip_1 = dot(pair.t1, velocity), slip_2 = dot(pair.t2, velocity);
  const V slip_n = dot(pair.n, spin);
  const Grip<V>& grip = m.grip;
  const V determinant = grip.m11 * grip.m22 - grip.m12 * grip.m12;
  const V scale = V(1.0) / determinant;
  const V inverse_twist = xsimd::select(grip.mnn > zero, V(1.0) / grip.mnn, zero);
  const Four<V> reach{{load<V>(rows.reach[0], at), load<V>(rows.reach[1], at),
                       load<V>(rows.reach[2], at), load<V>(rows.reach[3], at)}};
  Slide<V> slide{load<V>(rows.slide[0], at), load<V>(rows.slide[1], at), load<V>(rows.twist, at)};
  V fn = zero, c1 = zero, c2 = zero;  // N s, N m s: what the normals did so far
  Slide<V> rubbed{zero, zero, zero};
  for (int turn = 0; turn < turns; ++turn) {
    Four<V> dz = solve_lcp<V>(face.there, B, z, e);
    for (std::size_t i = 0; i < 4; ++i) {
      if (turn > 0) dz[i] = xsimd::select(rubs, dz[i], zero);
      z[i] += dz[i];
    }
    fn += sum(dz);
    c1 += dot(face.s, dz);
    c2 += dot(face.r, dz);
    if (xsimd::none(rubs)) break;
    // Friction sees what the normals have just done, and they what it does.
    const V v1 = slip_1 + (m.slip_1n * fn + m.slip_11 * c1 + m.slip_12 * c2) +
                 (grip.m11 * rubbed.f1 + grip.m12 * rubbed.f2 + grip.m1n * rubbed.tn);
    const V v2 = slip_2 + (m.slip_2n * fn + m.slip_21 * c1 + m.slip_22 * c2) +
                 (grip.m12 * rubbed.f1 + grip.m22 * rubbed.f2 + grip.m2n * rubbed.tn);
    const V wn = slip_n + (m.slip_nn * fn + m.slip_n1 * c1 + m.slip_n2 * c2) +
                 (grip.m1n * rubbed.f1 + grip.m2n * rubbed.f2 + grip.mnn * rubbed.tn);
    Slide<V> next{slide.f1 - scale * (grip.m22 * v1 - grip.m12 * v2),
                  slide.f2 - scale * (grip.m11 * v2 - grip.m12 * v1),
                  slide.tn - inverse_twist * wn};
    keep_within<V>(grip, determinant, {friction * sum(z), friction * dot(z, reach)}, next);
    next = {xsimd::select(rubs, next.f1, slide.f1), xsimd::select(rubs, next.f2, slide.f2),
            xsimd::select(rubs, next.tn, slide.tn)};
    const Slide<V> d{next.f1 - slide.f1, next.f2 - slide.f2, next.tn - slide.tn};
    slide = next;
    rubbed = {rubbed.f1 + d.f1, rubbed.f2 + d.f2, rubbed.tn + d.tn};
    if (turn + 1 == turns) break;
    const V back_n = m.slip_1n * d.f1 + m.slip_2n * d.f2 + m.slip_nn * d.tn;
    const V back_1 = m.slip_11 * d.f1 + m.slip_21 * d.f2 + m.slip_n1 * d.tn;
    const V back_2 = m.slip_12 * d.f1 + m.slip_22 * d.f2 + m.slip_n2 * d.tn;
    const Four<V> response = B * dz;
    for (std::size_t i = 0; i < 4; ++i) {
      e[i] += response[i] + (back_n + back_1 * face.s[i] + back_2 * face.r[i]);
    }
  }
  for (std::size_t i = 0; i < 4; ++i) store(z[i], rows.impulse[i], at);
  store(slide.f1, rows.slide[0], at);
  store(slide.f2, rows.slide[1], at);
  store(slide.tn, rows.twist, at);
  pair.template apply<true>(rows, bits_of<V>(active, at),
                            fn * pair.n + rubbed.f1 * pair.t1 + rubbed.f2 * pair.t2,
                            rubbed.tn * pair.n + c1 * pair.t1 + c2 * pair.t2);
}

/// @tparam holds  against targets; else overlaps are opened
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
    // Of a gap they may have what the bodies' own motion leaves.
    const Pair<A, Velocities::Applied> own(rows, at, bodies);
    const V own_n = dot(pair.n, own.velocity());
    V own_1 = zero, own_2 = zero;
    if constexpr (faces) {
      own_1 = dot(pair.t1, own.spin());
      own_2 = dot(pair.t2, own.spin());
    }
    const Mask<V> sunk = lanes_of<V>(rows.sunk, at);
    for (std::size_t i = 0; i < (faces ? 4 : 1); ++i) {
      const V bias = load<V>(rows.bias[i], at);
      V room = bias + own_n;
      if constexpr (faces) {
        room += own_1 * load<V>(rows.s[i], at) + own_2 * load<V>(rows.r[i], at);
      }
      e[i] += xsimd::select(bias > zero, most(room, zero), xsimd::select(sunk, bias, zero));
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
    m.press_n = xsimd::select(scaled, s.press_n, m.press_n);
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
    const V3<V> force = solve_point(m.press_n, zero, xsimd::select(active, e[0], zero)) * pair.n;
    pair.template apply<false>(rows, bits, force, force, share_a, share_b);
  }
  return static_cast<LaneMask>(bits);
}

/// Normal velocities of the points of rows; where there are no faces, all are that of the first.
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
    // As in solve_faces(): a point that carries nothing may close its gap.
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
    const V idle = dot(face.idle, z);
    for (std::size_t i = 0; i < 4; ++i) {
      e[i] = xsimd::select(meant & face.there[i], e[i] + idle * face.idle[i], zero);
    }
    alone = {{B.m00 * z[0], B.m11 * z[1], B.m22 * z[2], B.m33 * z[3]}};
    dz = solve_lcp<V>(face.there, B, z, e);
    apply(sum(dz), dot(face.s, dz), dot(face.r, dz));
  } else {
    e[0] = xsimd::select(meant, e[0], zero);
    alone[0] = m.press_n * z[0];
    dz[0] = solve_point(m.press_n, z[0], e[0]);
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

/// Call `visit.operator()<B>(at)` for the batches that these lanes lie in.
/// @tparam Half  for lanes that lie in one half of the others' batch
template <class A, class Half, class Visit>
void for_batches(LaneMask lanes, Visit&& visit) {
  constexpr std::size_t half = kLanes / 2;
  constexpr LaneMask low = (1u << half) - 1u;
  const bool first = (lanes & low) != 0;
  const bool second = (lanes & ~low) != 0;
  if (xsimd::batch<double, A>::size == kLanes && first && second) {
    visit.template operator()<A>(std::size_t{0});
    return;
  }
  if (first) visit.template operator()<Half>(std::size_t{0});
  if (second) visit.template operator()<Half>(half);
}

template <class A, class Half, bool holds>
LaneMask push_all(const ContactRows& rows, LaneMask asked, BodyNumbers bodies) {
  unsigned acted = 0;
  for_batches<A, Half>(asked & lanes_in_use(rows), [&]<class B>(std::size_t at) {
    acted |= rows.faces ? push<B, true, holds>(rows, at, asked, bodies)
                        : push<B, false, holds>(rows, at, asked, bodies);
  });
  return static_cast<LaneMask>(acted);
}

template <class A, class Half>
constexpr ContactKernels kernels() {
  static_assert(xsimd::batch<double, Half>::size == kLanes / 2);
  ContactKernels out;
  out.prepare = [](ContactRows& rows, double evenness, BodyNumbers bodies) {
    for_batches<A, Half>(lanes_in_use(rows), [&]<class B>(std::size_t at) {
      rows.faces ? prepare<B, true>(rows, at, evenness, bodies)
                 : prepare<B, false>(rows, at, evenness, bodies);
    });
  };
  out.begin = [](ContactRows& rows, const SubstepRule& rule, BodyNumbers bodies) {
    rows.sunk = 0;
    rows.bounces = false;
    for_batches<A, Half>(lanes_in_use(rows), [&]<class B>(std::size_t at) {
      const Begun begun = rows.faces ? begin<B, true>(rows, at, rule, bodies)
                                     : begin<B, false>(rows, at, rule, bodies);
      rows.sunk = static_cast<LaneMask>(rows.sunk | begun.sunk);
      rows.bounces = rows.bounces || begun.bounces;
    });
  };
  out.warm_start = [](const ContactRows& rows, BodyNumbers bodies) {
    for_batches<A, Half>(lanes_in_use(rows), [&]<class B>(std::size_t at) {
      rows.faces ? warm_start<B, true>(rows, at, bodies) : warm_start<B, false>(rows, at, bodies);
    });
  };
  out.solve = [](ContactRows& rows, ContactPass pass, int turns, LaneMask asked,
                 BodyNumbers bodies) {
    for_batches<A, Half>(asked & lanes_in_use(rows), [&]<class B>(std::size_t at) {
      rows.faces ? solve_faces<B>(rows, at, pass, turns, asked, bodies)
                 : solve_points<B>(rows, at, pass, turns, asked, bodies);
    });
  };
  out.push = push_all<A, Half, false>;
  out.hold = push_all<A, Half, true>;
  out.meet = [](const ContactRows& rows, Blow& blow, double slow, bool first, BodyNumbers bodies) {
    unsigned hit = 0;
    for_batches<A, Half>(lanes_in_use(rows), [&]<class B>(std::size_t at) {
      hit |= rows.faces ? meet<B, true>(rows, blow, at, slow, first, bodies)
                        : meet<B, false>(rows, blow, at, slow, first, bodies);
    });
    return static_cast<LaneMask>(hit & lanes_in_use(rows));
  };
  out.strike = [](const ContactRows& rows, Blow& blow, LaneMask asked, BodyNumbers bodies) {
    blow.change = {};
    for_batches<A, Half>(asked, [&]<class B>(std::size_t at) {
      rows.faces ? strike<B, true>(rows, blow, at, asked, bodies)
                 : strike<B, false>(rows, blow, at, asked, bodies);
    });
  };
  out.settle = [](ContactRows& rows, const Blow& blow, BodyNumbers bodies) {
    for_batches<A, Half>(blow.struck, [&]<class B>(std::size_t at) {
      rows.faces ? settle<B, true>(rows, blow, at, bodies)
                 : settle<B, false>(rows, blow, at, bodies);
    });
    rows.bounces = true;
  };
  return out;
}

}  // namespace tandem::pbd::kernel
