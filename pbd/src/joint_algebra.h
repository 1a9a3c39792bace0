// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <utility>

/// Small dense blocks of the joint solver, row-major in plain memory.
namespace tandem::pbd::block {

using Block3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
using Map3 = Eigen::Map<Block3>;
using ConstMap3 = Eigen::Map<const Block3>;
inline constexpr int kMaxRows = 10;
/// A pivot that elimination has reduced below this share marks a dependent row.
inline constexpr double kPivotTolerance = 1e-13;

/// In-place inverse of a symmetric positive definite n x n block, whose lower triangle is read;
/// rows without a pivot become 0.
template <int n>
void invert(double* a) {
  // a = L D L^T, then a^-1 = L^-T D^-1 L^-1.
  double l[n * n]{};
  double d[n];  // inverse pivots
  for (int i = 0; i < n; ++i) {
    double pivot = a[i * n + i];
    for (int j = 0; j < i; ++j) {
      double sum = a[i * n + j];
      for (int k = 0; k < j; ++k) sum -= l[j * n + k] * a[i * n + k];
      a[i * n + j] = sum;  // L_ij d_j
    }
    for (int j = 0; j < i; ++j) {
      l[i * n + j] = a[i * n + j] * d[j];
      pivot -= l[i * n + j] * a[i * n + j];
    }
    d[i] = pivot > kPivotTolerance * a[i * n + i] ? 1.0 / pivot : 0.0;
  }
  // Now L^-1 in place of L, lower triangular with ones.
  for (int i = 1; i < n; ++i) {
    for (int j = 0; j < i; ++j) {
      double sum = l[i * n + j];
      for (int k = j + 1; k < i; ++k) sum += l[i * n + k] * l[k * n + j];
      l[i * n + j] = -sum;
    }
  }
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j <= i; ++j) {
      double sum = j < i ? d[i] * l[i * n + j] : d[i];
      for (int k = i + 1; k < n; ++k) sum += l[k * n + i] * d[k] * l[k * n + j];
      a[i * n + j] = a[j * n + i] = sum;
    }
  }
}

/// Calls visit() with n, 1 to kMaxRows, as a constant; not at all for 0.
void with_size(int n, auto&& visit) {
  [&]<int... i>(std::integer_sequence<int, i...>) {
    (void)((n == i + 1 && (visit(std::integral_constant<int, i + 1>{}), true)) || ...);
  }
  (std::make_integer_sequence<int, kMaxRows>{});
}

inline void invert(double* a, int n) {
  with_size(n, [a](auto size) { invert<size>(a); });
}

/// Inverse for n = 3, by cofactors where that is safe.
[[gnu::always_inline]] inline void invert3(double* a) {
  const double c00 = a[4] * a[8] - a[7] * a[7];
  const double c01 = a[6] * a[7] - a[3] * a[8];
  const double c02 = a[3] * a[7] - a[6] * a[4];
  const double determinant = a[0] * c00 + a[3] * c01 + a[6] * c02;
  if (!(determinant > 1e-9 * a[0] * a[4] * a[8]) || !(c00 > 0.0)) {
    invert<3>(a);
    return;
  }
  const double s = 1.0 / determinant;
  const double c11 = a[0] * a[8] - a[6] * a[6];
  const double c12 = a[3] * a[6] - a[0] * a[7];
  const double c22 = a[0] * a[4] - a[3] * a[3];
  a[0] = s * c00;
  a[4] = s * c11;
  a[8] = s * c22;
  a[1] = a[3] = s * c01;
  a[2] = a[6] = s * c02;
  a[5] = a[7] = s * c12;
}

/// Inverts inertia or inverse inertia on the free axes. In place: a returned matrix would be read
/// in pairs of numbers that were just written singly, and that stall takes as long as the
/// inversion.
[[gnu::always_inline]] inline void invert(Eigen::Matrix3d& symmetric) { invert3(symmetric.data()); }

/// m v, inlined.
[[gnu::always_inline]] inline Eigen::Vector3d times(const Eigen::Matrix3d& m,
                                                    const Eigen::Vector3d& v) {
  return {m(0, 0) * v[0] + m(0, 1) * v[1] + m(0, 2) * v[2],
          m(1, 0) * v[0] + m(1, 1) * v[1] + m(1, 2) * v[2],
          m(2, 0) * v[0] + m(2, 1) * v[1] + m(2, 2) * v[2]};
}

inline void negate(double* a, int count) {
  for (int e = 0; e < count; ++e) a[e] = -a[e];
}

/// Dot product of two rows, in two sums that do not wait for each other.
template <int n>
[[gnu::always_inline]] inline double dot(const double* a, const double* b) {
  double even = a[0] * b[0];
  double odd = n > 1 ? a[1] * b[1] : 0.0;
  for (int i = 2; i + 1 < n; i += 2) {
    even += a[i] * b[i];
    odd += a[i + 1] * b[i + 1];
  }
  if (n > 2 && n % 2 == 1) even += a[n - 1] * b[n - 1];
  return even + odd;
}

/// out = sign a b^T, a: rows x n, b: n x n.
template <int n>
void multiply(const double* a, const double* b, auto rows, double sign, double* out) {
  for (int i = 0; i < rows; ++i) {
    for (int j = 0; j < n; ++j) out[i * n + j] = sign * dot<n>(a + i * n, b + j * n);
  }
}

/// out -= a b^T, a: rows x n, b: columns x n.
template <int n>
void subtract_product(const double* a, const double* b, auto rows, auto columns, double* out) {
  if constexpr (n == 3) {
    if (rows == 3 && columns == 3) {  // in vector instructions
      Map3{out}.noalias() -= ConstMap3(a).lazyProduct(ConstMap3(b).transpose());
      return;
    }
  }
  for (int i = 0; i < rows; ++i) {
    for (int j = 0; j < columns; ++j) out[i * columns + j] -= dot<n>(a + i * n, b + j * n);
  }
}

/// Lower triangle of out -= a b^T, where the result is symmetric.
template <int n>
void subtract_symmetric(const double* a, const double* b, auto rows, double* out) {
  for (int i = 0; i < rows; ++i) {
    for (int j = 0; j <= i; ++j) out[i * rows + j] -= dot<n>(a + i * n, b + j * n);
  }
}

/// y = sign a x, a: n x n.
template <int n>
void times(const double* a, const double* x, double sign, double* y) {
  for (int i = 0; i < n; ++i) y[i] = sign * dot<n>(a + i * n, x);
}

/// y -= a x, a: rows x n.
template <int n>
void subtract(const double* a, const double* x, auto rows, double* y) {
  for (int i = 0; i < rows; ++i) y[i] -= dot<n>(a + i * n, x);
}

/// y -= a^T x, a: rows x n.
template <int n>
void subtract_transposed(const double* a, const double* x, auto rows, double* y) {
  for (int i = 0; i < rows; ++i) {
    for (int j = 0; j < n; ++j) y[j] -= a[i * n + j] * x[i];
  }
}

}  // namespace tandem::pbd::block
