// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "inner_core.h"

#include <algorithm>

#include "tandem/pbd/math.h"
#include "tandem/pbd/portable.h"

namespace tandem::collision {
namespace {

/// Share of the depth of a solid.
constexpr double kDeep = 0.5;

/// Each corner of the hull is the intersection of inward-moved faces there, then moved to the
/// middle until it is behind all moved faces.
void shrink_hull(const ConvexHull& hull, double layer, std::vector<Vec3>& arms) {
  const auto depth = [&](const ConvexHull::Face& face) {
    return std::min(layer, kDeep * face.offset);
  };
  const std::size_t count = hull.arms().size();
  std::vector<Vec3>& out = arms;
  out.assign(hull.arms().begin(), hull.arms().end());
  for (std::uint32_t v = 0; v < count; ++v) {
    Mat3 normals = 1e-9 * Mat3::Identity();
    Vec3 inwards = Vec3::Zero();
    for (const std::uint32_t e : hull.star(v)) {
      for (const std::uint32_t f : hull.edges()[e].faces) {  // each face appears twice
        const ConvexHull::Face& face = hull.faces()[f];
        normals += face.normal * face.normal.transpose();
        inwards += depth(face) * face.normal;
      }
    }
    // Cramer's rule: Eigen's inverse is not evaluated in the same order everywhere.
    const Vec3 p = normals.col(0);
    const Vec3 q = normals.col(1);
    const Vec3 r = normals.col(2);
    const Vec3 pq = p.cross(q);
    const Vec3 solved(q.cross(r).dot(inwards), r.cross(p).dot(inwards), pq.dot(inwards));
    const Vec3 moved = hull.arms()[v] - solved / pq.dot(r);
    double share = 1.0;
    for (const ConvexHull::Face& face : hull.faces()) {
      const double height = face.normal.dot(moved);
      const double most = face.offset - depth(face);
      if (height > most) share = std::min(share, most / height);
    }
    out[v] = share * moved;
  }
}

}  // namespace

ConvexCore body_core(const Collider& c) {
  ConvexCore core = c.core(c.body.position);
  const pbd::Quat turn = c.body.orientation.conjugate();
  core.centre = pbd::rotate(turn, core.centre);
  core.axes = turn.toRotationMatrix() * core.axes;
  return core;
}

ConvexCore inner_core(const Collider& c, std::vector<Vec3>& arms) {
  ConvexCore core = body_core(c);
  const double layer = inner_layer(c);
  switch (core.kind) {
    case CoreKind::Box:
    case CoreKind::Cylinder:
      core.half -= Vec3::Constant(layer);
      break;
    case CoreKind::Cone: {
      // About the centre of the inscribed ball.
      const double radius = core.half[0];
      const double height = 2.0 * core.half[2];
      const double ball = radius * height / (radius + pbd::portable::hypot(radius, height));
      const double middle = ball - core.half[2];
      core.centre += kDeep * middle * core.axes.col(2);
      core.half *= kDeep;
      break;
    }
    case CoreKind::Polytope:
      shrink_hull(*core.hull, layer, arms);
      core.arms = arms.data();
      break;
    default:
      core.radius *= kDeep;
  }
  return core;
}

}  // namespace tandem::collision
