// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cmath>

#include "tandem/pbd/portable.h"
#include "tandem/pbd/types.h"

namespace tandem::pbd {

/// a.dot(b) with the bits of Eigen's. Eigen reads pairs of numbers that were just written singly,
/// which stalls store forwarding.
inline double dot(const Vec3& a, const Vec3& b) {
  return a.x() * b.x() + a.y() * b.y() + a.z() * b.z();
}

/// Rotation by the rotation vector r (rad, axis times angle).
inline Quat exp_map(const Vec3& r) {
  const double angle2 = dot(r, r);
  double real = 0.0;
  double scale = 0.0;  // sin(angle / 2) / angle
  if (angle2 < 1e-6) {
    // Taylor series; the next terms are below 1e-22.
    scale = 0.5 - angle2 * (1.0 / 48.0 - angle2 / 3840.0);
    real = 1.0 - angle2 * (1.0 / 8.0 - angle2 / 384.0);
  } else {
    const double angle = std::sqrt(angle2);
    const portable::SinCos half = portable::sin_cos(0.5 * angle);
    scale = half.sin / angle;
    real = half.cos;
  }
  return Quat(real, r.x() * scale, r.y() * scale, r.z() * scale);
}

/// Rotation vector (rad) of q along the shorter arc: |result| <= pi.
inline Vec3 log_map(const Quat& q) {
  const double sign = q.w() < 0.0 ? -1.0 : 1.0;
  const Vec3 v = sign * q.vec();
  const double sine = v.norm();
  if (sine < 1e-10) return 2.0 * v;
  return v * (2.0 * portable::atan2(sine, sign * q.w()) / sine);
}

/// q turned by the world-frame rotation vector `r`, kept at unit length.
inline Quat rotated(const Quat& q, const Vec3& r) {
  Quat result = exp_map(r) * q;
  result.normalize();
  return result;
}

/// World-frame rotation vector that turns `from` into `to` along the shorter arc.
inline Vec3 rotation_between(const Quat& from, const Quat& to) {
  return log_map(to * from.conjugate());
}

/// Cross-product matrix: skew(a) b = a x b.
inline Mat3 skew(const Vec3& a) {
  Mat3 m;
  m << 0.0, -a.z(), a.y(), a.z(), 0.0, -a.x(), -a.y(), a.x(), 0.0;
  return m;
}

/// Tensor given in the local frame of q, expressed in the world: R T R^T. Scalar and in place, to
/// avoid stalled store forwarding; in the order of Eigen's products, so that the bits are the same.
inline void tensor_to_world(const Quat& q, const Mat3& tensor_l, Mat3& tensor_w) {
  const double x2 = 2.0 * q.x(), y2 = 2.0 * q.y(), z2 = 2.0 * q.z();
  const double wx = x2 * q.w(), wy = y2 * q.w(), wz = z2 * q.w();
  const double xx = x2 * q.x(), xy = y2 * q.x(), xz = z2 * q.x();
  const double yy = y2 * q.y(), yz = z2 * q.y(), zz = z2 * q.z();
  const double r[3][3] = {{1.0 - (yy + zz), xy - wz, xz + wy},
                          {xy + wz, 1.0 - (xx + zz), yz - wx},
                          {xz - wy, yz + wx, 1.0 - (xx + yy)}};
  const auto sum = [](int row, double a, double b, double c) {
    return row < 2 ? (a + b) + c : a + (b + c);
  };
  for (int i = 0; i < 3; ++i) {
    double rt[3];
    for (int j = 0; j < 3; ++j) {
      rt[j] = sum(i, r[i][0] * tensor_l(0, j), r[i][1] * tensor_l(1, j), r[i][2] * tensor_l(2, j));
    }
    for (int j = 0; j < 3; ++j) {
      tensor_w(i, j) = sum(i, rt[0] * r[j][0], rt[1] * r[j][1], rt[2] * r[j][2]);
    }
  }
}

inline Mat3 tensor_to_world(const Quat& q, const Mat3& tensor_l) {
  Mat3 tensor_w;
  tensor_to_world(q, tensor_l, tensor_w);
  return tensor_w;
}

/// Inverse of a symmetric tensor on its free axes. An axis is locked if its diagonal entry is 0:
/// its row and column are 0 in the tensor and in the result.
inline Mat3 inverse_where_free(const Mat3& tensor) {
  const Vec3 diagonal = tensor.diagonal();
  if ((diagonal.array() > 0.0).all()) return tensor.inverse();
  const double size = diagonal.maxCoeff();
  if (!(size > 0.0)) return Mat3::Zero();
  Mat3 result = tensor;
  for (int i = 0; i < 3; ++i) {
    if (diagonal[i] == 0.0) result(i, i) = size;
  }
  result = result.inverse().eval();
  for (int i = 0; i < 3; ++i) {
    if (diagonal[i] == 0.0) result(i, i) = 0.0;
  }
  return result;
}

/// Two unit vectors that complete the unit vector n to a right-handed frame (n, t1, t2). They
/// depend on n alone, and smoothly except at n = -z.
/// Source: [duff2017] Listing 3.
inline void tangent_frame(const Vec3& n, Vec3& t1, Vec3& t2) {
  const double sign = std::copysign(1.0, n.z());
  const double a = -1.0 / (sign + n.z());
  const double b = n.x() * n.y() * a;
  t1 = Vec3(1.0 + sign * n.x() * n.x() * a, sign * b, -sign * n.x());
  t2 = Vec3(b, sign + n.y() * n.y() * a, -n.y());
}

}  // namespace tandem::pbd
