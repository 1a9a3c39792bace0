// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "gjk.h"

#include <algorithm>
#include <cmath>

#include "convex_manifold.h"

namespace tandem::collision {
namespace {

constexpr int kMaxIterations = 64;
/// Share of the size of the Minkowski difference below which two cores touch.
constexpr double kTouching = 1e-12;
/// Relative size below which the sign of a triple product is uncertain.
constexpr double kSign = 1e-13;
/// Relative difference of upper and lower bound at which the distance has converged.
constexpr double kConverged = 1e-12;
/// m, and share of the sizes: a gap that counts as closed while casting.
constexpr double kContact = 1e-9;

/// Up to four points of the difference a - b and the weights of the point nearest to the origin.
struct Simplex {
  int count = 0;
  std::array<Vec3, 4> w, on_a, on_b;
  std::array<double, 4> weight{};

  void add(const Vec3& a, const Vec3& b) {
    w[count] = a - b;
    on_a[count] = a;
    on_b[count] = b;
    ++count;
  }
  bool holds(const Vec3& point) const {
    return std::any_of(w.begin(), w.begin() + count, [&](const Vec3& p) { return p == point; });
  }
  Vec3 blend(const std::array<Vec3, 4>& points) const {
    Vec3 sum = Vec3::Zero();
    for (int i = 0; i < count; ++i) sum += weight[i] * points[i];
    return sum;
  }
};

/// Weights of the nearest point to the origin; zero for corners that are not needed.
using Weights = std::array<double, 4>;

Weights weights_on_segment(const Simplex& s, int i, int j) {
  const Vec3 d = s.w[j] - s.w[i];
  const double length2 = d.squaredNorm();
  const double t = length2 > 0.0 ? std::clamp(-s.w[i].dot(d) / length2, 0.0, 1.0) : 0.0;
  Weights out{};
  out[i] = 1.0 - t;
  out[j] = t;
  return out;
}

double norm2(const Simplex& s, const Weights& weights) {
  Vec3 v = Vec3::Zero();
  for (int i = 0; i < s.count; ++i) v += weights[i] * s.w[i];
  return v.squaredNorm();
}

/// Weights in the triangle if the origin projects into it, else on its nearest edge.
Weights weights_on_triangle(const Simplex& s, int i, int j, int k) {
  const Vec3 n = (s.w[j] - s.w[i]).cross(s.w[k] - s.w[i]);
  const double n2 = n.squaredNorm();
  const std::array<int, 3> corner{i, j, k};
  Weights out{};
  bool inside = n2 > 0.0;
  for (int c = 0; c < 3 && inside; ++c) {
    const Vec3& p = s.w[corner[(c + 1) % 3]];
    const Vec3& q = s.w[corner[(c + 2) % 3]];
    out[corner[c]] = n.dot(p.cross(q)) / n2;
    inside = out[corner[c]] > 0.0;
  }
  if (inside) {
    const double sum = out[i] + out[j] + out[k];
    for (const int c : corner) out[c] /= sum;
    return out;
  }
  out = weights_on_segment(s, i, j);
  for (const auto& [p, q] : {std::pair(j, k), std::pair(i, k)}) {
    const Weights other = weights_on_segment(s, p, q);
    if (norm2(s, other) < norm2(s, out)) out = other;
  }
  return out;
}

/// @return false if the tetrahedron contains the origin
bool nearest_on_tetrahedron(const Simplex& s, Weights& out) {
  static constexpr std::array<std::array<int, 4>, 4> kFaces{
      {{0, 1, 2, 3}, {0, 1, 3, 2}, {0, 2, 3, 1}, {1, 2, 3, 0}}};
  double best = HUGE_VAL;
  for (const auto& [i, j, k, opposite] : kFaces) {
    const Vec3 u = s.w[j] - s.w[i];
    const Vec3 v = s.w[k] - s.w[i];
    const Vec3 up = s.w[opposite] - s.w[i];
    const Vec3 n = u.cross(v);
    const double side = n.dot(up);
    const double origin = -n.dot(s.w[i]);
    // If rounding may have flipped a sign, the face may be the nearest: a flat tetrahedron contains
    // nothing.
    const double doubt = kSign * u.norm() * v.norm();
    const bool known =
        std::abs(side) > doubt * up.norm() && std::abs(origin) > doubt * s.w[i].norm();
    if (known && side * origin > 0.0) continue;
    const Weights weights = weights_on_triangle(s, i, j, k);
    const double distance2 = norm2(s, weights);
    if (distance2 >= best) continue;
    best = distance2;
    out = weights;
  }
  return best < HUGE_VAL;
}

/// Keeps the corners that the nearest point needs. @return false if the origin is inside
bool reduce(Simplex& s) {
  Weights weights{};
  switch (s.count) {
    case 1:
      weights[0] = 1.0;
      break;
    case 2:
      weights = weights_on_segment(s, 0, 1);
      break;
    case 3:
      weights = weights_on_triangle(s, 0, 1, 2);
      break;
    default:
      if (!nearest_on_tetrahedron(s, weights)) return false;
  }
  int kept = 0;
  for (int i = 0; i < s.count; ++i) {
    if (!(weights[i] > 0.0)) continue;
    s.w[kept] = s.w[i];
    s.on_a[kept] = s.on_a[i];
    s.on_b[kept] = s.on_b[i];
    s.weight[kept] = weights[i];
    ++kept;
  }
  s.count = kept;
  return true;
}

/// The nearest point. Not the weighted sum, which loses its direction if it is short and the
/// simplex long and thin: it is the remainder perpendicular to an edge or face.
Vec3 nearest_point(const Simplex& s) {
  int closest = 0;
  for (int i = 1; i < s.count; ++i) {
    if (s.w[i].squaredNorm() < s.w[closest].squaredNorm()) closest = i;
  }
  const Vec3& w = s.w[closest];
  if (s.count == 2) {
    const Vec3 d = (s.w[1] - s.w[0]).normalized();
    const Vec3 across = w - w.dot(d) * d;
    return across - across.dot(d) * d;
  }
  if (s.count == 3) {
    const Vec3 n = (s.w[1] - s.w[0]).cross(s.w[2] - s.w[0]).normalized();
    return n.dot(w) * n;
  }
  return s.blend(s.w);
}

/// For overlapping cores: the direction that leads out.
Proximity way_out(const ConvexCore& a, const ConvexCore& b) {
  const bool swapped = b.kind < a.kind;
  const ConvexCore& first = swapped ? b : a;
  const ConvexCore& second = swapped ? a : b;
  ContactAxis axis = choose_axis(first, second, {Direction::Status::Unknown, Vec3::UnitZ()});
  if (second.kind == CoreKind::Triangle) {
    // For contacts a triangle has a front only; here either side may be the way out.
    const double back = separation(first, second, second.front);
    if (back > axis.separation) axis = {second.front, back, FaceOwner::B};
  }
  const Vec3& n = axis.normal;
  Vec3 on_first;
  Vec3 on_second;
  if (axis.owner == FaceOwner::B) {
    on_first = first.support(n);
    on_second = on_first + axis.separation * n;
  } else {
    on_second = second.support(-n);
    on_first = on_second - axis.separation * n;
  }
  Proximity out;
  out.normal = swapped ? Vec3(-n) : n;
  out.gap = axis.separation - a.radius - b.radius;
  out.on_a = (swapped ? on_second : on_first) + a.radius * out.normal;
  out.on_b = (swapped ? on_first : on_second) - b.radius * out.normal;
  return out;
}

Proximity with_radii(const CoreDistance& d, const ConvexCore& a, const ConvexCore& b) {
  return {d.distance - a.radius - b.radius, d.normal, d.on_a + a.radius * d.normal,
          d.on_b - b.radius * d.normal};
}

}  // namespace

CoreDistance core_distance(const ConvexCore& a, const ConvexCore& b) {
  Simplex simplex;
  Vec3 v = a.centre - b.centre;
  if (v.isZero(0.0)) v = Vec3::UnitX();
  double size = 0.0;
  double nearest = HUGE_VAL;
  CoreDistance out;
  for (int i = 0; i < kMaxIterations; ++i) {
    const Vec3 on_a = a.support(-v);
    const Vec3 on_b = b.support(v);
    const Vec3 w = on_a - on_b;
    size = std::max(size, w.norm());
    const double length = v.norm();
    if (i > 0) {
      const double least = v.dot(w) / length;
      out.least = std::max(out.least, least);
      if (length - least <= kConverged * length + 1e-15 * size || simplex.holds(w)) break;
    }
    simplex.add(on_a, on_b);
    const Simplex grown = simplex;
    if (!reduce(simplex)) return {};
    const Vec3 next = nearest_point(simplex);
    const double distance = next.norm();
    if (!(distance > kTouching * size)) return {};
    if (distance >= nearest) {  // rounding: the last result was the best
      simplex = grown;
      --simplex.count;
      break;
    }
    nearest = distance;
    v = next;
  }
  out.apart = true;
  out.size = size;
  out.distance = v.norm();
  out.normal = -v / out.distance;
  out.least = std::min(out.least, out.distance);
  out.on_a = simplex.blend(simplex.on_a);
  out.on_b = simplex.blend(simplex.on_b);
  return out;
}

Proximity proximity(const ConvexCore& a, const ConvexCore& b) {
  const CoreDistance d = core_distance(a, b);
  return d.apart ? with_radii(d, a, b) : way_out(a, b);
}

ConvexCore point_core(const Vec3& position) {
  ConvexCore core;
  core.centre = position;
  return core;
}

bool cast_core(ConvexCore a, const ConvexCore& b, const Vec3& direction, double limit,
               double& travel, Proximity& at) {
  const Vec3 start = a.centre;
  const double radii = a.radius + b.radius;
  travel = 0.0;
  for (int i = 0; i < kMaxIterations; ++i) {
    const CoreDistance d = core_distance(a, b);
    if (!d.apart) {
      if (i == 0) at = way_out(a, b);
      return true;  // otherwise the result of the previous iteration, just before
    }
    at = with_radii(d, a, b);
    const double contact = kContact * (1.0 + d.size + radii);
    if (i == 0 && at.gap < -contact) return true;
    const double closing = direction.dot(d.normal);
    if (closing <= 0.0) return false;
    const double room = std::max(0.0, d.least - radii);
    const bool arrived = at.gap <= contact;
    // Stop within the tolerance, where the direction is still defined.
    travel += (arrived ? room : std::max(0.0, room - 0.5 * contact)) / closing;
    if (travel > limit) return false;
    if (arrived) return true;
    a.centre = start + travel * direction;
  }
  return true;  // grazing contact, within rounding
}

}  // namespace tandem::collision
