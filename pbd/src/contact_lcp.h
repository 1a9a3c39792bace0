// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// The normals of one manifold, solved together.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>

namespace tandem::pbd {

using Four = Eigen::Array<double, 4, 1>;
using FourByFour = Eigen::Array<double, 4, 4>;

/// The sum, in an order that does not depend on the width of a machine's vectors.
inline double sum(const Four& x) { return (x[0] + x[1]) + (x[2] + x[3]); }

/// x with B x = r, B symmetric and positive definite: L D L^T, written out.
inline Four solve_symmetric(const FourByFour& B, const Four& r) {
  const double i0 = 1.0 / B(0, 0);
  const double l10 = B(1, 0) * i0, l20 = B(2, 0) * i0, l30 = B(3, 0) * i0;
  const double i1 = 1.0 / (B(1, 1) - l10 * B(1, 0));
  const double c21 = B(2, 1) - l20 * B(1, 0), c31 = B(3, 1) - l30 * B(1, 0);
  const double l21 = c21 * i1, l31 = c31 * i1;
  const double i2 = 1.0 / (B(2, 2) - l20 * B(2, 0) - l21 * c21);
  const double c32 = B(3, 2) - l30 * B(2, 0) - l31 * c21;
  const double l32 = c32 * i2;
  const double i3 = 1.0 / (B(3, 3) - l30 * B(3, 0) - l31 * c31 - l32 * c32);
  const double y1 = r[1] - l10 * r[0];
  const double y2 = r[2] - l20 * r[0] - l21 * y1;
  const double y3 = r[3] - l30 * r[0] - l31 * y1 - l32 * y2;
  Four x;
  x[3] = y3 * i3;
  x[2] = y2 * i2 - l32 * x[3];
  x[1] = y1 * i1 - l21 * x[2] - l31 * x[3];
  x[0] = r[0] * i0 - l10 * x[1] - l20 * x[2] - l30 * x[3];
  return x;
}

/// The same of the first two or three unknowns alone, whose diagonal is larger by the share
/// `ridge`; the rest of x is 0.
inline Four solve_leading(int count, const FourByFour& B, const Four& r, double ridge) {
  const double b00 = B(0, 0) + ridge * B(0, 0);
  const double b11 = B(1, 1) + ridge * B(1, 1);
  const double i0 = 1.0 / b00;
  const double l10 = B(1, 0) * i0;
  const double i1 = 1.0 / (b11 - l10 * B(1, 0));
  const double y1 = r[1] - l10 * r[0];
  Four x = Four::Zero();
  if (count == 2) {
    x[1] = y1 * i1;
    x[0] = r[0] * i0 - l10 * x[1];
    return x;
  }
  const double b22 = B(2, 2) + ridge * B(2, 2);
  const double l20 = B(2, 0) * i0;
  const double c21 = B(2, 1) - l20 * B(1, 0);
  const double l21 = c21 * i1;
  const double i2 = 1.0 / (b22 - l20 * B(2, 0) - l21 * c21);
  x[2] = (r[2] - l20 * r[0] - l21 * y1) * i2;
  x[1] = y1 * i1 - l21 * x[2];
  x[0] = r[0] * i0 - l10 * x[1] - l20 * x[2];
  return x;
}

/// B d, column by column.
inline Four times(const FourByFour& B, const Four& d) {
  return B.col(0) * d[0] + B.col(1) * d[1] + B.col(2) * d[2] + B.col(3) * d[3];
}

/// Solve  0 <= z + d  _|_  e + B d >= 0  for d, the change of the multipliers z (N s) of `count`
/// points with velocities e (m/s) and the mobility B (1/kg, symmetric, positive semi-definite).
/// Principal pivoting: guess which points carry a load, solve, exchange those on the wrong side;
/// all at once at first, one at a time later, which cannot cycle.
/// Source: [murty1974] for one at a time.
inline Four solve_lcp(int count, const FourByFour& B, const Four& z, const Four& e) {
  if (count == 1) {
    Four d = Four::Zero();
    if (B(0, 0) > 0.0) d[0] = std::max(-z[0], -e[0] / B(0, 0));
    return d;
  }
  // Added to the diagonal as a share of it: three points on a line, or bodies that cannot turn,
  // leave B singular. It acts on the change only, so repeated solves converge to the rigid answer.
  constexpr double kRidge = 1e-6;
  constexpr int kAtOnce = 3;
  constexpr int kMost = 16;
  Four active;  // 1 where a point carries a load, else 0
  double fastest = 0.0;
  for (int i = 0; i < 4; ++i) {
    active[i] = i < count && (z[i] > 0.0 || e[i] < 0.0) ? 1.0 : 0.0;
    if (i < count) fastest = std::max(fastest, std::abs(e[i]));
  }
  const double tolerance = 1e-9 * fastest;
  Four d = Four::Zero();
  for (int iteration = 0; iteration < kMost; ++iteration) {
    if (count < 4 && sum(active) == count) {  // all of them: most often so, and then it is less
      d = solve_leading(count, B, -e, kRidge);
      bool pulls = false;
      for (int i = count - 1; i >= 0; --i) {
        if (!(z[i] + d[i] < 0.0)) continue;
        active[i] = 0.0;
        pulls = true;
        if (iteration >= kAtOnce) break;
      }
      if (!pulls) break;
      continue;
    }
    // Points without a load drop theirs; the others answer for that.
    const Four dropped = (active - 1.0) * z;
    const Four r = dropped - active * (e + times(B, dropped));
    FourByFour M;
    for (int j = 0; j < 4; ++j) {
      M.col(j) = B.col(j) * active * active[j];
      M(j, j) += active[j] > 0.0 ? kRidge * M(j, j) : 1.0;
    }
    d = solve_symmetric(M, r);
    const Four velocity = e + times(B, d);
    bool wrong = false;
    for (int i = count - 1; i >= 0; --i) {
      const bool loaded = active[i] > 0.0;
      const bool exchange = loaded ? z[i] + d[i] < 0.0 : velocity[i] < -tolerance;
      if (!exchange) continue;
      active[i] = loaded ? 0.0 : 1.0;
      wrong = true;
      if (iteration >= kAtOnce) break;
    }
    if (!wrong) break;
  }
  return d.max(-z);
}

}  // namespace tandem::pbd
