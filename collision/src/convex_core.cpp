// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "convex_core.h"

#include <algorithm>
#include <cmath>

namespace tandem::collision {
namespace {

/// Number of the box edge along `axis` where the other two coordinates have these signs.
std::uint32_t box_edge_id(int axis, bool next_positive, bool last_positive) {
  return static_cast<std::uint32_t>(axis * 4 + (next_positive ? 1 : 0) + (last_positive ? 2 : 0));
}

/// Corner of a box; bit i of `bits` is set where coordinate i is positive. The bits are its id.
Vec3 box_corner(const ConvexCore& core, std::uint32_t bits) {
  Vec3 p = core.centre;
  for (int i = 0; i < 3; ++i) {
    p += ((bits >> i & 1u) != 0 ? core.half[i] : -core.half[i]) * core.axes.col(i);
  }
  return p;
}

CoreFace box_face(const ConvexCore& core, const Vec3& direction) {
  const Vec3 local = core.axes.transpose() * direction;
  int axis = 0;
  local.cwiseAbs().maxCoeff(&axis);
  const bool positive = local[axis] >= 0.0;
  const int u = (axis + 1) % 3;
  const int v = (axis + 2) % 3;
  const std::uint32_t base = positive ? 1u << axis : 0u;
  // (u, v) signs, counter-clockwise about +axis.
  static constexpr std::array<std::array<bool, 2>, 4> kSigns{
      {{false, false}, {true, false}, {true, true}, {false, true}}};
  CoreFace face;
  face.count = 4;
  std::array<std::array<bool, 2>, 4> signs;
  for (int i = 0; i < 4; ++i) {
    signs[i] = kSigns[positive ? i : 3 - i];
    face.corner_ids[i] = base | (signs[i][0] ? 1u << u : 0u) | (signs[i][1] ? 1u << v : 0u);
    face.corners[i] = box_corner(core, face.corner_ids[i]);
  }
  for (int i = 0; i < 4; ++i) {
    const auto& from = signs[i];
    const auto& to = signs[(i + 1) % 4];
    // Along u the sign of v stays and vice versa; box_edge_id wants (axis + 1, axis + 2).
    face.edge_ids[i] =
        from[1] == to[1] ? box_edge_id(u, from[1], positive) : box_edge_id(v, positive, from[0]);
  }
  return face;
}

CoreEdge box_edge(const ConvexCore& core, const Vec3& direction) {
  const Vec3 local = core.axes.transpose() * direction;
  int axis = 0;
  local.cwiseAbs().minCoeff(&axis);
  const int u = (axis + 1) % 3;
  const int v = (axis + 2) % 3;
  const std::uint32_t base = (local[u] >= 0.0 ? 1u << u : 0u) | (local[v] >= 0.0 ? 1u << v : 0u);
  const std::uint32_t to = base | 1u << axis;
  return {box_corner(core, base), box_corner(core, to),
          box_edge_id(axis, local[u] >= 0.0, local[v] >= 0.0), base, to};
}

CoreEdge triangle_edge(const ConvexCore& core, const Vec3& direction) {
  int best = 0;
  double furthest = 0.0;
  for (int k = 0; k < 3; ++k) {
    const double d = direction.dot(core.corners[k] + core.corners[(k + 1) % 3]);
    if (k == 0 || d > furthest) {
      furthest = d;
      best = k;
    }
  }
  const int next = (best + 1) % 3;
  return {core.corners[best], core.corners[next], core.edge_ids[best], core.corner_ids[best],
          core.corner_ids[next]};
}

}  // namespace

double ConvexCore::reach(const Vec3& direction) const {
  switch (kind) {
    case CoreKind::Point:
      return direction.dot(centre);
    case CoreKind::Segment:
      return direction.dot(centre) + half[2] * std::abs(direction.dot(axes.col(2)));
    case CoreKind::Box:
      return direction.dot(centre) + half[0] * std::abs(direction.dot(axes.col(0))) +
             half[1] * std::abs(direction.dot(axes.col(1))) +
             half[2] * std::abs(direction.dot(axes.col(2)));
    case CoreKind::Triangle:
      return std::max(
          {direction.dot(corners[0]), direction.dot(corners[1]), direction.dot(corners[2])});
  }
  return 0.0;
}

Vec3 ConvexCore::support(const Vec3& direction) const {
  if (kind == CoreKind::Triangle) {
    int best = 0;
    for (int k = 1; k < 3; ++k) {
      if (direction.dot(corners[k]) > direction.dot(corners[best])) best = k;
    }
    return corners[best];
  }
  Vec3 p = centre;
  for (int i = 0; i < 3; ++i) {
    p += (direction.dot(axes.col(i)) >= 0.0 ? half[i] : -half[i]) * axes.col(i);
  }
  return p;
}

CoreFace face_towards(const ConvexCore& core, const Vec3& direction) {
  if (core.kind == CoreKind::Box) return box_face(core, direction);
  CoreFace face;
  if (core.kind == CoreKind::Triangle) {
    face.count = 3;
    for (int k = 0; k < 3; ++k) {
      face.corners[k] = core.corners[k];
      face.corner_ids[k] = core.corner_ids[k];
      face.edge_ids[k] = core.edge_ids[k];
    }
    return face;
  }
  const CoreEdge edge = edge_towards(core, direction);
  face.count = 2;
  face.corners[0] = edge.from;
  face.corners[1] = edge.to;
  face.corner_ids[0] = edge.from_id;
  face.corner_ids[1] = edge.to_id;
  face.edge_ids[0] = edge.id;
  face.edge_ids[1] = edge.id;
  return face;
}

CoreEdge edge_towards(const ConvexCore& core, const Vec3& direction) {
  if (core.kind == CoreKind::Box) return box_edge(core, direction);
  if (core.kind == CoreKind::Triangle) return triangle_edge(core, direction);
  const Vec3 arm = core.half[2] * core.axes.col(2);
  return {core.centre - arm, core.centre + arm, 0, 0, core.kind == CoreKind::Point ? 0u : 1u};
}

}  // namespace tandem::collision
