// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Vectors of lanes, and bodies read into them. V is an xsimd batch of 2 or 4 numbers.
#pragma once

#include <concepts>
#include <xsimd/xsimd.hpp>

#include "contact_rows.h"

namespace tandem::pbd::kernel {

template <class V>
using Mask = typename V::batch_bool_type;

template <class V>
struct V3 {
  V x, y, z;
  friend V3 operator+(const V3& l, const V3& r) { return {l.x + r.x, l.y + r.y, l.z + r.z}; }
  friend V3 operator-(const V3& l, const V3& r) { return {l.x - r.x, l.y - r.y, l.z - r.z}; }
  friend V3 operator*(const V& s, const V3& v) { return {s * v.x, s * v.y, s * v.z}; }
};

template <class V>
V dot(const V3<V>& l, const V3<V>& r) {
  return l.x * r.x + l.y * r.y + l.z * r.z;
}

template <class V>
V3<V> cross(const V3<V>& l, const V3<V>& r) {
  return {l.y * r.z - l.z * r.y, l.z * r.x - l.x * r.z, l.x * r.y - l.y * r.x};
}

/// (xx, xy, xz, yy, yz, zz) of a symmetric matrix.
template <class V>
struct Sym3 {
  V xx, xy, xz, yy, yz, zz;
  friend V3<V> operator*(const Sym3& m, const V3<V>& v) {
    return {m.xx * v.x + m.xy * v.y + m.xz * v.z, m.xy * v.x + m.yy * v.y + m.yz * v.z,
            m.xz * v.x + m.yz * v.y + m.zz * v.z};
  }
};

template <class V>
V load(const Lanes& lanes, std::size_t at) {
  return V::load_aligned(lanes.data() + at);
}

template <class V>
V3<V> load(const LaneArray<3>& lanes, std::size_t at) {
  return {load<V>(lanes[0], at), load<V>(lanes[1], at), load<V>(lanes[2], at)};
}

template <class V>
void store(const V& value, Lanes& lanes, std::size_t at) {
  value.store_aligned(lanes.data() + at);
}

/// Same as x < y ? x : y, on every instruction set, also with NaN.
template <class V>
V least(const V& x, const V& y) {
  return xsimd::select(x < y, x, y);
}
template <class V>
V most(const V& x, const V& y) {
  return xsimd::select(x > y, x, y);
}

/// Pointers to the first number of each lane of a batch.
template <class A>
using From = std::array<const double*, xsimd::batch<double, A>::size>;

/// Four consecutive numbers of each lane, from number `n` on, transposed.
template <class A>
struct Columns {
  using V = xsimd::batch<double, A>;
  V c0, c1, c2, c3;

  [[gnu::always_inline]] static Columns read(const From<A>& from, std::size_t n) {
    static_assert(V::size == 2);
    const V p = V::load_unaligned(from[0] + n), q = V::load_unaligned(from[1] + n);
    const V r = V::load_unaligned(from[0] + n + 2), s = V::load_unaligned(from[1] + n + 2);
    return {zip_lo(p, q), zip_hi(p, q), zip_lo(r, s), zip_hi(r, s)};
  }
  /// Writes two numbers of lane i of this batch.
  static void write(const V& l, const V& r, std::size_t i, double* to) {
    (i == 0 ? zip_lo(l, r) : zip_hi(l, r)).store_unaligned(to);
  }
};

#if XSIMD_WITH_AVX2
template <std::derived_from<xsimd::avx2> A>
struct Columns<A> {
  using V = xsimd::batch<double, A>;
  V c0, c1, c2, c3;

  static V halves(const double* low, const double* high) {
    return _mm256_insertf128_pd(_mm256_castpd128_pd256(_mm_loadu_pd(low)), _mm_loadu_pd(high), 1);
  }
  [[gnu::always_inline]] static Columns read(const From<A>& from, std::size_t n) {
    const V p = halves(from[0] + n, from[2] + n), q = halves(from[1] + n, from[3] + n);
    const V r = halves(from[0] + n + 2, from[2] + n + 2);
    const V s = halves(from[1] + n + 2, from[3] + n + 2);
    return {_mm256_unpacklo_pd(p, q), _mm256_unpackhi_pd(p, q), _mm256_unpacklo_pd(r, s),
            _mm256_unpackhi_pd(r, s)};
  }
  static void write(const V& l, const V& r, std::size_t i, double* to) {
    const __m256d both = i % 2 == 0 ? _mm256_unpacklo_pd(l, r) : _mm256_unpackhi_pd(l, r);
    _mm_storeu_pd(to, i < 2 ? _mm256_castpd256_pd128(both) : _mm256_extractf128_pd(both, 1));
  }
};
#endif

/// One side of V::size rows: reads, changes and writes the velocities of its bodies.
template <class A, Velocities velocities>
class Side {
 public:
  using V = xsimd::batch<double, A>;

  Side(const std::array<std::uint32_t, kLanes>& index, std::size_t at, BodyNumbers bodies)
      : at_(at), first_(bodies.of_velocities(velocities)) {
    for (std::size_t i = 0; i < V::size; ++i) from_[i] = bodies.of(index[at + i]);
    linear_ = read(first_);
    angular_ = read(first_ + 4);
  }

  V3<V> v() const { return {linear_.c0, linear_.c1, linear_.c2}; }
  V3<V> w() const { return {linear_.c3, angular_.c0, angular_.c1}; }

  /// 1/kg
  V inv_mass() const { return properties().c2; }
  /// 1/(kg m^2), world
  Sym3<V> inv_inertia() const {
    const auto second = read(8);  // yx, zx, xy, yy
    const auto third = read(12);  // zy, xz, yz, zz
    return {properties().c3, second.c2, third.c1, second.c3, third.c2, third.c3};
  }

  /// m
  V3<V> x() const {
    const auto x = read(BodyNumbers::kX);
    return {x.c0, x.c1, x.c2};
  }
  /// A world vector in the frames of the bodies.
  V3<V> to_local(const V3<V>& v) const {
    const auto q = read(BodyNumbers::kQ);
    const V3<V> u{q.c0, q.c1, q.c2};
    const V3<V> t = V(2.0) * cross(v, u);
    return v + q.c3 * t + cross(t, u);
  }

  void add(const V3<V>& linear, const V3<V>& angular) {
    linear_.c0 += linear.x;
    linear_.c1 += linear.y;
    linear_.c2 += linear.z;
    linear_.c3 += angular.x;
    angular_.c0 += angular.y;
    angular_.c1 += angular.z;
  }
  /// Writes the bodies that move.
  void write(unsigned moves) const {
    for (std::size_t i = 0; i < V::size; ++i) {
      if ((moves >> (at_ + i) & 1u) == 0) continue;
      double* to = from_[i] + first_;
      Columns<A>::write(linear_.c0, linear_.c1, i, to);
      Columns<A>::write(linear_.c2, linear_.c3, i, to + 2);
      Columns<A>::write(angular_.c0, angular_.c1, i, to + 4);
    }
  }

 private:
  [[gnu::always_inline]] Columns<A> read(std::size_t n) const {
    From<A> from;
    for (std::size_t i = 0; i < V::size; ++i) from[i] = from_[i];
    return Columns<A>::read(from, n);
  }
  /// w_y, w_z, 1/m and the inertia's xx.
  Columns<A> properties() const {
    if constexpr (velocities == Velocities::Now) {
      return angular_;
    } else {
      return read(4);
    }
  }

  std::array<double*, V::size> from_;
  std::size_t at_;
  std::size_t first_;  ///< index of the first velocity number
  Columns<A> linear_;
  Columns<A> angular_;
};

}  // namespace tandem::pbd::kernel
