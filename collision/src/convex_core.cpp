// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "convex_core.h"

#include <algorithm>
#include <cmath>
#include <span>

namespace tandem::collision {
namespace {

/// Index of the box edge along `axis` where the other two coordinates have these signs.
std::uint32_t box_edge_id(int axis, bool next_positive, bool last_positive) {
  return static_cast<std::uint32_t>(axis * 4 + (next_positive ? 1 : 0) + (last_positive ? 2 : 0));
}

/// Corner of a box; bit i of `bits` is set if coordinate i is positive. The bits are its id.
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
  const Vec3 middle =
      core.centre + (positive ? core.half[axis] : -core.half[axis]) * core.axes.col(axis);
  const Vec3 along_u = core.half[u] * core.axes.col(u);
  const Vec3 along_v = core.half[v] * core.axes.col(v);
  const std::array<Vec3, 2> sides{middle - along_u, middle + along_u};
  for (int i = 0; i < 4; ++i) {
    signs[i] = kSigns[positive ? i : 3 - i];
    face.corner_ids[i] = base | (signs[i][0] ? 1u << u : 0u) | (signs[i][1] ? 1u << v : 0u);
    const Vec3& side = sides[signs[i][0] ? 1 : 0];
    face.corners[i] = signs[i][1] ? Vec3(side + along_v) : Vec3(side - along_v);
  }
  for (int i = 0; i < 4; ++i) {
    const auto& from = signs[i];
    const auto& to = signs[(i + 1) % 4];
    // Along u the sign of v is constant and vice versa; box_edge_id needs (axis + 1, axis + 2).
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

/// Cosine to its axis above which a cylinder touches with a cap.
constexpr double kCap = 0.7;

/// Unit vector perpendicular to the axis of a cylinder or cone, furthest along `direction`; a fixed
/// one if the direction is parallel to the axis.
Vec3 radial(const ConvexCore& core, const Vec3& direction) {
  const Vec3 axis = core.axes.col(2);
  const Vec3 across = direction - direction.dot(axis) * axis;
  const double length = across.norm();
  return length > 1e-12 * direction.norm() ? Vec3(across / length) : Vec3(core.axes.col(0));
}

/// Cosine to the axis above which a cone touches with its base (below minus that) or side.
bool on_base(const ConvexCore& core, const Vec3& direction) {
  const double cosine = direction.dot(core.axes.col(2));
  if (core.kind == CoreKind::Cylinder) return std::abs(cosine) > kCap;
  return cosine < -kCap;
}

/// Sine of the tilt above which the corners of a cap start at the one furthest along the direction.
constexpr double kTilted = 0.02;

CoreFace cap(const ConvexCore& core, bool upper, const Vec3& direction) {
  CoreFace face;
  face.count = CoreFace::kMaxCorners;
  // Twelve directions like a clock's; the same corners in either orientation.
  static constexpr double kH = 0.86602540378443864676;  // sqrt(3) / 2
  static constexpr std::array<std::array<double, 2>, CoreFace::kMaxCorners> kClock{{{1, 0},
                                                                                    {kH, 0.5},
                                                                                    {0.5, kH},
                                                                                    {0, 1},
                                                                                    {-0.5, kH},
                                                                                    {-kH, 0.5},
                                                                                    {-1, 0},
                                                                                    {-kH, -0.5},
                                                                                    {-0.5, -kH},
                                                                                    {0, -1},
                                                                                    {0.5, -kH},
                                                                                    {kH, -0.5}}};
  const Vec3 middle = core.centre + (upper ? core.half[2] : -core.half[2]) * core.axes.col(2);
  auto base = static_cast<std::uint32_t>(upper ? CoreFace::kMaxCorners : 0);
  Vec3 x = core.axes.col(0);
  Vec3 y = core.axes.col(1);
  const double cosine = direction.dot(core.axes.col(2)) / direction.norm();
  if (1.0 - cosine * cosine > kTilted * kTilted) {
    x = radial(core, direction);
    y = core.axes.col(2).cross(x);
    base += 32;
  }
  for (int i = 0; i < face.count; ++i) {
    const int k = upper ? i : face.count - 1 - i;
    face.corners[i] = middle + core.half[0] * (kClock[k][0] * x + kClock[k][1] * y);
    face.corner_ids[i] = base + static_cast<std::uint32_t>(k);
    const int edge = upper ? k : (k + face.count - 1) % face.count;
    face.edge_ids[i] = base + static_cast<std::uint32_t>(edge);
  }
  return face;
}

/// The line on the side of a cylinder or cone that is furthest along the direction, or a point (an
/// edge without length) if it touches with its rim or apex.
CoreEdge side_edge(const ConvexCore& core, const Vec3& direction) {
  const Vec3 out = core.half[0] * radial(core, direction);
  const Vec3 arm = core.half[2] * core.axes.col(2);
  const bool cone = core.kind == CoreKind::Cone;
  const Vec3 low = core.centre - arm + out;
  const Vec3 high = cone ? Vec3(core.centre + arm) : Vec3(core.centre + arm + out);
  // Ids after those of the caps: the line, and its two ends.
  CoreEdge edge{low, high, 24, 24, 25};
  const Vec3 line = high - low;
  const double slope = direction.dot(line) / (direction.norm() * line.norm());
  if (slope > kCap) return {high, high, 24, 25, 25};
  if (slope < -kCap) return {low, low, 24, 24, 24};
  return edge;
}

std::size_t hull_face_towards(const ConvexCore& core, const Vec3& direction) {
  const Vec3 local = core.axes.transpose() * direction;
  const auto faces = core.hull->faces();
  std::size_t best = 0;
  double most = -HUGE_VAL;
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const double value = faces[f].normal.dot(local);
    if (value <= most) continue;
    most = value;
    best = f;
  }
  return best;
}

/// If a face has too many corners, an even selection that includes the foremost along the
/// direction.
CoreFace hull_face(const ConvexCore& core, std::size_t number, const Vec3& direction) {
  const ConvexHull::Face& chosen = core.hull->faces()[number];
  const auto corners = core.hull->face_corners(chosen);
  const auto edges = core.hull->face_edges(chosen);
  CoreFace face;
  const std::size_t size = corners.size();
  const std::size_t count = std::min<std::size_t>(size, CoreFace::kMaxCorners);
  face.count = static_cast<int>(count);
  std::size_t first = 0;
  if (size > count) {
    const Vec3 local = core.axes.transpose() * direction;
    const auto ahead = [&](std::uint32_t v) { return core.hull->arms()[v].dot(local); };
    for (std::size_t k = 1; k < size; ++k) {
      if (ahead(corners[k]) > ahead(corners[first])) first = k;
    }
  }
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t k = (first + i * size / count) % size;
    face.corners[i] = core.centre + core.axes * core.hull->arms()[corners[k]];
    face.corner_ids[i] = corners[k];
    face.edge_ids[i] = edges[k];
  }
  return face;
}

std::span<const Vec3> arms_of(const ConvexCore& core) {
  const std::span<const Vec3> own = core.hull->arms();
  return core.arms != nullptr ? std::span(core.arms, own.size()) : own;
}

std::uint32_t hull_corner(const ConvexCore& core, const Vec3& local) {
  const auto arms = arms_of(core);
  std::uint32_t best = 0;
  double most = -HUGE_VAL;
  for (std::uint32_t v = 0; v < arms.size(); ++v) {
    const double value = arms[v].dot(local);
    if (value <= most) continue;
    most = value;
    best = v;
  }
  return best;
}

/// The face at the foremost corner nearest to the direction; `first` if it is one of them.
std::size_t hull_face_at_corner(const ConvexCore& core, const Vec3& direction, std::size_t first) {
  const Vec3 local = core.axes.transpose() * direction;
  const auto faces = core.hull->faces();
  std::size_t best = first;
  double most = -HUGE_VAL;
  for (const std::uint32_t e : core.hull->star(hull_corner(core, local))) {
    for (const std::uint32_t f : core.hull->edges()[e].faces) {
      if (f == first) return first;
      const double value = faces[f].normal.dot(local);
      if (value <= most) continue;
      most = value;
      best = f;
    }
  }
  return best;
}

CoreEdge hull_edge(const ConvexCore& core, const Vec3& direction) {
  const Vec3 local = core.axes.transpose() * direction;
  const auto arms = core.hull->arms();
  // The edge at the foremost corner that falls off least.
  double least = HUGE_VAL;
  std::uint32_t best = 0;
  for (const std::uint32_t e : core.hull->star(hull_corner(core, local))) {
    const ConvexHull::Edge& edge = core.hull->edges()[e];
    const Vec3 along = arms[edge.to] - arms[edge.from];
    const double slope = std::abs(local.dot(along)) / along.norm();
    if (slope >= least) continue;
    least = slope;
    best = e;
  }
  const ConvexHull::Edge& edge = core.hull->edges()[best];
  return {core.centre + core.axes * arms[edge.from], core.centre + core.axes * arms[edge.to], best,
          edge.from, edge.to};
}

}  // namespace

int face_count(const ConvexCore& core) {
  switch (core.kind) {
    case CoreKind::Box:
      return 6;
    case CoreKind::Cylinder:
      return 2;
    case CoreKind::Cone:
      return 1;
    case CoreKind::Polytope:
      return static_cast<int>(core.hull->faces().size());
    default:
      return 0;
  }
}

Vec3 face_normal(const ConvexCore& core, int i) {
  if (core.kind == CoreKind::Polytope) return core.axes * core.hull->faces()[i].normal;
  if (core.kind == CoreKind::Box) return (i % 2 == 0 ? 1.0 : -1.0) * core.axes.col(i / 2);
  return (i == 0 ? -1.0 : 1.0) * core.axes.col(2);
}

int edge_count(const ConvexCore& core) {
  switch (core.kind) {
    case CoreKind::Point:
      return 0;
    case CoreKind::Segment:
    case CoreKind::Cylinder:
    case CoreKind::Cone:
      return 1;
    case CoreKind::Polytope:
      return static_cast<int>(core.hull->edges().size());
    default:
      return 3;
  }
}

Vec3 edge_direction(const ConvexCore& core, int i) {
  switch (core.kind) {
    case CoreKind::Box:
      return core.axes.col(i);
    case CoreKind::Triangle:
      return core.corners[(i + 1) % 3] - core.corners[i];
    case CoreKind::Polytope: {
      const ConvexHull::Edge& edge = core.hull->edges()[i];
      return core.axes * (core.hull->arms()[edge.to] - core.hull->arms()[edge.from]);
    }
    default:
      return core.axes.col(2);
  }
}

double rolling_radius(const ConvexCore& core, const Vec3& direction) {
  if (core.kind != CoreKind::Cylinder || on_base(core, direction)) return 0.0;
  const double cosine = direction.dot(core.axes.col(2));
  return core.half[0] * std::sqrt(std::max(0.0, 1.0 - cosine * cosine));
}

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
    case CoreKind::Cylinder:
    case CoreKind::Cone: {
      const double along = direction.dot(axes.col(2));
      const double across =
          half[0] * std::sqrt(std::max(0.0, direction.squaredNorm() - along * along));
      const double most = kind == CoreKind::Cylinder
                              ? half[2] * std::abs(along) + across
                              : std::max(half[2] * along, across - half[2] * along);
      return direction.dot(centre) + most;
    }
    case CoreKind::Polytope: {
      const Vec3 local = axes.transpose() * direction;
      double most = -HUGE_VAL;
      for (const Vec3& arm : arms_of(*this)) most = std::max(most, arm.dot(local));
      return direction.dot(centre) + most;
    }
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
  if (kind == CoreKind::Polytope) {
    return centre + axes * arms_of(*this)[hull_corner(*this, axes.transpose() * direction)];
  }
  if (curved()) {
    const double along = direction.dot(axes.col(2));
    const Vec3 out = radial(*this, direction);
    const Vec3 rim = half[0] * out;
    const Vec3 arm = half[2] * axes.col(2);
    if (kind == CoreKind::Cylinder) return centre + rim + (along < 0.0 ? Vec3(-arm) : arm);
    return half[2] * along > half[0] * out.dot(direction) - half[2] * along
               ? Vec3(centre + arm)
               : Vec3(centre + rim - arm);
  }
  Vec3 p = centre;
  for (int i = 0; i < 3; ++i) {
    p += (direction.dot(axes.col(i)) >= 0.0 ? half[i] : -half[i]) * axes.col(i);
  }
  return p;
}

CoreFace face_towards(const ConvexCore& core, const Vec3& direction) {
  if (core.kind == CoreKind::Box) return box_face(core, direction);
  if (core.kind == CoreKind::Polytope)
    return hull_face(core, hull_face_towards(core, direction), direction);
  if (core.curved() && on_base(core, direction)) {
    return cap(core, core.kind == CoreKind::Cylinder && direction.dot(core.axes.col(2)) > 0.0,
               direction);
  }
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

BearingFaces::BearingFaces(const ConvexCore& core, const Vec3& direction)
    : core_(core), direction_(direction) {
  if (core.kind != CoreKind::Polytope) return;
  at_ = hull_face_towards(core, direction);
  first_ = at_;
  foremost_ = hull_face_at_corner(core, direction, first_);
}

bool BearingFaces::next(CoreFace& face) {
  if (done_) return false;
  face = core_.kind == CoreKind::Polytope ? hull_face(core_, at_, direction_)
                                          : face_towards(core_, direction_);
  done_ = true;
  if (core_.kind != CoreKind::Polytope) return true;
  const Vec3 local = core_.axes.transpose() * direction_;
  const auto faces = core_.hull->faces();
  for (; beside_ < faces.size() && done_; ++beside_) {
    const bool bears = beside_ == foremost_ || faces[beside_].normal.dot(local) >= kBearingCosine;
    if (beside_ == first_ || !bears) continue;
    at_ = beside_;
    done_ = false;
  }
  return true;
}

CoreEdge edge_towards(const ConvexCore& core, const Vec3& direction) {
  if (core.kind == CoreKind::Box) return box_edge(core, direction);
  if (core.kind == CoreKind::Triangle) return triangle_edge(core, direction);
  if (core.kind == CoreKind::Polytope) return hull_edge(core, direction);
  if (core.curved()) return side_edge(core, direction);
  const Vec3 arm = core.half[2] * core.axes.col(2);
  return {core.centre - arm, core.centre + arm, 0, 0, core.kind == CoreKind::Point ? 0u : 1u};
}

}  // namespace tandem::collision
