// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "free_rotation.h"

#include <array>
#include <cmath>
#include <utility>

#include "tandem/pbd/math.h"
#include "tandem/pbd/portable.h"

namespace tandem::pbd {
namespace {

/// Rates (1/(kg m^2)) at which a body turns about two of its principal axes, per unit of angular
/// momentum along them, in addition to turning about the momentum itself.
struct Rates {
  double top = 0.0;   ///< about z
  double rest = 0.0;  ///< about x; 0 if two moments are equal
};

/// Angular momentum in the principal frame, and the rotation of that frame so far.
struct Spin {
  Vec3 momentum = Vec3::Zero();
  Quat turned = Quat::Identity();

  /// Exact rotation about axis `i` under its part of the energy alone.
  void turn(int i, double rate_h) {
    const double angle = rate_h * momentum[i];
    const portable::SinCos half = portable::sin_cos(0.5 * angle);
    const double sine = 2.0 * half.sin * half.cos;
    const double cosine = 1.0 - 2.0 * half.sin * half.sin;
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    const double a = momentum[j], b = momentum[k];
    momentum[j] = cosine * a + sine * b;
    momentum[k] = cosine * b - sine * a;
    Vec3 axis = Vec3::Zero();
    axis[i] = half.sin;
    turned = turned * Quat(half.cos, axis.x(), axis.y(), axis.z());
  }
};

/// Fourth-order composition of a symmetric second-order step.
/// Source: [yoshida1990] Eq. 2.11.
constexpr double kOuter = 1.3512071919596578;  // 1 / (2 - cbrt(2))
constexpr double kInner = 1.0 - 2.0 * kOuter;

void turn_in_parts(Spin& spin, const Rates& rates, int parts, double part) {
  const double halves[] = {0.5 * kOuter, 0.5 * (kOuter + kInner), 0.5 * (kInner + kOuter)};
  const double wholes[] = {kOuter, kInner, kOuter};
  spin.turn(0, halves[0] * part * rates.rest);
  for (int i = 0; i < parts; ++i) {
    for (int k = 0; k < 3; ++k) {
      spin.turn(2, wholes[k] * part * rates.top);
      const bool ends = k == 2;
      const double after = !ends ? halves[k + 1] : i + 1 < parts ? kOuter : halves[0];
      spin.turn(0, after * part * rates.rest);
    }
  }
}

/// The momentum of equal length nearest to this one that has the energy (J, twice).
Vec3 with_energy(const Vec3& momentum, const Vec3& moments, double energy2) {
  constexpr int kIterations = 3;
  const double size2 = momentum.squaredNorm();
  Vec3 found = momentum;
  for (int i = 0; i < kIterations; ++i) {
    const Vec3 w = found.cwiseQuotient(moments);
    const double now = w.dot(found);
    const Vec3 uphill = w - (now / size2) * found;
    const double slope2 = uphill.squaredNorm();
    if (!(std::abs(now - energy2) > 1e-15 * energy2) || !(slope2 > 1e-24 * w.squaredNorm())) break;
    found += (0.5 * (energy2 - now) / slope2) * uphill;
    found *= std::sqrt(size2 / found.squaredNorm());
  }
  return found;
}

/// The smallest rotation that turns `from` into `to`, which have equal length and are not opposite.
Quat least_rotation(const Vec3& from, const Vec3& to) {
  const Vec3 axis = from.cross(to);
  const double sine = axis.norm();
  const double cosine = from.dot(to);
  if (!(cosine > 0.0) || sine < 1e-300) return Quat::Identity();
  return exp_map(axis * (portable::atan2(sine, cosine) / sine));
}

}  // namespace

/// Jacobi rotations. Axis z becomes the one whose moment differs most from the others, y the one
/// with the middle moment.
PrincipalAxes principal_axes(const Mat3& inertia) {
  constexpr int kSweeps = 12;
  Mat3 a = inertia;
  Mat3 axes = Mat3::Identity();
  const double size = inertia.trace();
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    for (int p = 0; p < 3; ++p) {
      const int q = (p + 1) % 3;
      if (!(std::abs(a(p, q)) > 1e-18 * size)) continue;
      const double theta = 0.5 * (a(q, q) - a(p, p)) / a(p, q);
      const double t = std::copysign(1.0, theta) / (std::abs(theta) + std::sqrt(theta * theta + 1));
      const double c = 1.0 / std::sqrt(t * t + 1.0);
      Mat3 turn = Mat3::Identity();
      turn(p, p) = turn(q, q) = c;
      turn(p, q) = t * c;
      turn(q, p) = -t * c;
      a = (turn.transpose() * a * turn).eval();
      axes = (axes * turn).eval();
    }
  }
  std::array<int, 3> by_size{0, 1, 2};
  for (const std::size_t k : {0u, 1u, 0u}) {  // neighbours only: equal moments stay in order
    const int i = by_size[k], j = by_size[k + 1];
    if (a(j, j) < a(i, i)) std::swap(by_size[k], by_size[k + 1]);
  }
  const auto [low, middle, high] = by_size;
  const double below = 1.0 / a(low, low) - 1.0 / a(middle, middle);
  const double above = 1.0 / a(middle, middle) - 1.0 / a(high, high);
  const int z = below > above ? low : high;
  const int x = below > above ? high : low;
  Mat3 frame;
  frame << axes.col(x), axes.col(middle), axes.col(z);
  if (frame.determinant() < 0.0) frame.col(0) = -frame.col(0);
  PrincipalAxes result{Quat(frame), Vec3(a(x, x), a(middle, middle), a(z, z))};
  result.frame.normalize();
  return result;
}

/// The energy is split into L^2 / (2 I_y), under which the body turns about L like a ball, and two
/// rotations about its own axes: about z, which makes it a top, and about x, which vanishes if two
/// moments are equal. Each part has a closed form and conserves L.
Quat free_rotation(const Quat& q, const PrincipalAxes& axes, Vec3& w_l, double h) {
  constexpr double kPart = 0.1;  // rad, of both parts together
  constexpr int kMaxParts = 1024;
  const Vec3& moments = axes.moments;
  const Vec3 w = rotate(axes.frame.conjugate(), w_l);
  Spin spin{w.cwiseProduct(moments)};
  const Vec3 momentum_w = rotate(q, rotate(axes.frame, spin.momentum));
  const double inverse = 1.0 / moments.y();
  const Rates rates{1.0 / moments.z() - inverse, 1.0 / moments.x() - inverse};
  if (rates.rest == 0.0) {
    spin.turn(2, h * rates.top);
  } else {
    const Vec3 before = spin.momentum;
    const double angle = h * before.norm() * std::sqrt(std::abs(rates.top * rates.rest));
    const double wanted = std::ceil(angle / kPart);
    // A non-finite spin takes one part: the step reports the body afterwards.
    int parts = 1;
    if (wanted > 1.0) parts = wanted < kMaxParts ? static_cast<int>(wanted) : kMaxParts;
    turn_in_parts(spin, rates, parts, h / parts);
    const Vec3 kept = with_energy(spin.momentum, moments, w.dot(before));
    spin.turned = spin.turned * least_rotation(kept, spin.momentum);
    spin.momentum = kept;
  }
  w_l = rotate(axes.frame, spin.momentum.cwiseQuotient(moments));
  const Quat result =
      exp_map(momentum_w * (h * inverse)) * q * axes.frame * spin.turned * axes.frame.conjugate();
  return result.normalized();
}

}  // namespace tandem::pbd
