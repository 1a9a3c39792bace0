// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

/// Small dense blocks of the joint solver, row-major in plain memory. The 3 x 3 blocks of ball
/// joints have special code.
namespace tandem::pbd::block {

using Block3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
using Map3 = Eigen::Map<Block3>;
using ConstMap3 = Eigen::Map<const Block3>;
inline constexpr int kMaxRows = 10;
/// A pivot that elimination has reduced below this share marks a dependent row.
inline constexpr double kPivotTolerance = 1e-13;

/// In-place inverse of a symmetric positive definite n x n block; rows without a pivot become 0.
inline void invert(double* a, int n) {
  // a = L D L^T, then a^-1 = L^-T D^-1 L^-1.
  double l[kMaxRows * kMaxRows];
  double d[kMaxRows];
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < i; ++j) {
      double sum = a[i * n + j];
      for (int k = 0; k < j; ++k)
        sum -= l[i * n + k] * l[j * n + k] * (d[k] > 0.0 ? 1.0 / d[k] : 0.0);
      l[i * n + j] = sum;  // L_ij d_j
    }
    double pivot = a[i * n + i];
    for (int k = 0; k < i; ++k) {
      if (d[k] > 0.0) pivot -= l[i * n + k] * l[i * n + k] / d[k];
    }
    d[i] = pivot > kPivotTolerance * a[i * n + i] ? pivot : 0.0;
  }
  for (int j = 0; j < n; ++j) d[j] = d[j] > 0.0 ? 1.0 / d[j] : 0.0;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < i; ++j) l[i * n + j] *= d[j];
    l[i * n + i] = 1.0;
  }
  // m = L^-1, lower triangular with ones.
  double m[kMaxRows * kMaxRows];
  for (int j = 0; j < n; ++j) {
    m[j * n + j] = 1.0;
    for (int i = j + 1; i < n; ++i) {
      double sum = 0.0;
      for (int k = j; k < i; ++k) sum -= l[i * n + k] * m[k * n + j];
      m[i * n + j] = sum;
    }
  }
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j <= i; ++j) {
      double sum = 0.0;
      for (int k = i; k < n; ++k) sum += m[k * n + i] * d[k] * m[k * n + j];
      a[i * n + j] = sum;
      a[j * n + i] = sum;
    }
  }
}

/// Inverse for n = 3, by cofactors where that is safe.
[[gnu::always_inline]] inline void invert3(double* a) {
  const double c00 = a[4] * a[8] - a[5] * a[5];
  const double c01 = a[2] * a[5] - a[1] * a[8];
  const double c02 = a[1] * a[5] - a[2] * a[4];
  const double determinant = a[0] * c00 + a[1] * c01 + a[2] * c02;
  if (!(determinant > 1e-9 * a[0] * a[4] * a[8]) || !(c00 > 0.0)) {
    invert(a, 3);
    return;
  }
  const double s = 1.0 / determinant;
  const double c11 = a[0] * a[8] - a[2] * a[2];
  const double c12 = a[1] * a[2] - a[0] * a[5];
  const double c22 = a[0] * a[4] - a[1] * a[1];
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

/// out = a b, a: n x k, b: k x m.
inline void multiply(const double* a, const double* b, int n, int k, int m, double* out) {
  if (n == 3 && k == 3 && m == 3) {
    // In the order of Eigen's product. Scalar, as `b` has just been written singly.
    for (int i = 0; i < 3; ++i) {
      const double x = a[3 * i], y = a[3 * i + 1], z = a[3 * i + 2];
      out[3 * i] = (x * b[0] + y * b[3]) + z * b[6];
      out[3 * i + 1] = (x * b[1] + y * b[4]) + z * b[7];
      out[3 * i + 2] = x * b[2] + (y * b[5] + z * b[8]);
    }
    return;
  }
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < m; ++j) {
      double sum = 0.0;
      for (int l = 0; l < k; ++l) sum += a[i * k + l] * b[l * m + j];
      out[i * m + j] = sum;
    }
  }
}

/// out -= a b^T, a: n x k, b: m x k, out: n x m.
inline void subtract_product(const double* a, const double* b, int n, int k, int m, double* out) {
  if (n == 3 && k == 3 && m == 3) {
    Map3{out}.noalias() -= ConstMap3(a).lazyProduct(ConstMap3(b).transpose());
    return;
  }
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < m; ++j) {
      double sum = 0.0;
      for (int l = 0; l < k; ++l) sum += a[i * k + l] * b[j * k + l];
      out[i * m + j] -= sum;
    }
  }
}

/// y = sign a x, a: n x n.
inline void times(const double* a, const double* x, int n, double sign, double* y) {
  if (n == 3) {
    const double x0 = sign * x[0];
    const double x1 = sign * x[1];
    const double x2 = sign * x[2];
    y[0] = a[0] * x0 + a[1] * x1 + a[2] * x2;
    y[1] = a[3] * x0 + a[4] * x1 + a[5] * x2;
    y[2] = a[6] * x0 + a[7] * x1 + a[8] * x2;
    return;
  }
  for (int i = 0; i < n; ++i) {
    double sum = 0.0;
    for (int j = 0; j < n; ++j) sum += a[i * n + j] * x[j];
    y[i] = sign * sum;
  }
}

/// y -= a x, a: n x m.
inline void subtract(const double* a, const double* x, int n, int m, double* y) {
  if (n == 3 && m == 3) {
    y[0] -= a[0] * x[0] + a[1] * x[1] + a[2] * x[2];
    y[1] -= a[3] * x[0] + a[4] * x[1] + a[5] * x[2];
    y[2] -= a[6] * x[0] + a[7] * x[1] + a[8] * x[2];
    return;
  }
  for (int i = 0; i < n; ++i) {
    double sum = 0.0;
    for (int j = 0; j < m; ++j) sum += a[i * m + j] * x[j];
    y[i] -= sum;
  }
}

/// y -= a^T x, a: n x m.
inline void subtract_transposed(const double* a, const double* x, int n, int m, double* y) {
  if (n == 3 && m == 3) {
    y[0] -= a[0] * x[0] + a[3] * x[1] + a[6] * x[2];
    y[1] -= a[1] * x[0] + a[4] * x[1] + a[7] * x[2];
    y[2] -= a[2] * x[0] + a[5] * x[1] + a[8] * x[2];
    return;
  }
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < m; ++j) y[j] -= a[i * m + j] * x[i];
  }
}

}  // namespace tandem::pbd::block
