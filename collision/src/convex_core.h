// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cstdint>

#include "tandem/collision/convex_hull.h"
#include "tandem/pbd/types.h"

namespace tandem::collision {

using pbd::Mat3;
using pbd::Vec3;

/// Convex core of a shape, which extends by `radius` around it: sphere = point, capsule = segment;
/// others have radius 0. The order is the one in which a query takes a pair.
enum class CoreKind : std::uint8_t { Point, Segment, Box, Cylinder, Cone, Polytope, Triangle };

struct ConvexCore {
  CoreKind kind = CoreKind::Point;
  Vec3 centre = Vec3::Zero();    ///< m, inside; origin of a hull's arms()
  Mat3 axes = Mat3::Identity();  ///< columns: local axes; a segment lies along the third
  Vec3 half = Vec3::Zero();      ///< m, half extents along the axes; (0, 0, h) for a segment,
                                 ///< (r, r, h) for a cylinder and a cone
  const ConvexHull* hull = nullptr;
  const Vec3* arms = nullptr;  ///< m: replaces the hull's corners in reach() and support()
  double radius = 0.0;         ///< m
  double size = 0.0;           ///< m, least extent of the whole shape
  std::array<Vec3, 3> corners{Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};  ///< of a triangle
  Vec3 front = Vec3::UnitZ();                 ///< unit normal of a triangle
  std::array<std::uint32_t, 3> corner_ids{};  ///< of a triangle, in its mesh
  std::array<std::uint32_t, 3> edge_ids{};

  /// Support value: largest `direction . x` over the core (without the radius).
  double reach(const Vec3& direction) const;
  /// Support point: a point of the core with the support value.
  Vec3 support(const Vec3& direction) const;
  bool curved() const { return kind == CoreKind::Cylinder || kind == CoreKind::Cone; }
};

/// Outward normals of flat faces: their number, and the i-th one. Not for triangles, where only the
/// front counts.
int face_count(const ConvexCore& core);
Vec3 face_normal(const ConvexCore& core, int i);
/// Directions of edges (a box: its axes): their number, and the i-th one.
int edge_count(const ConvexCore& core);
Vec3 edge_direction(const ConvexCore& core, int i);

/// Depth of a cylinder's axis below its surface where it touches along a line, m. It is taken off
/// the anchors, so that they are on the axis and rolling does not move them. 0 if it touches with a
/// cap.
double rolling_radius(const ConvexCore& core, const Vec3& direction);

/// Face with corners counter-clockwise seen from outside; a segment is a face of two corners.
struct CoreFace {
  static constexpr int kMaxCorners = 12;
  int count = 0;
  std::array<Vec3, kMaxCorners> corners;
  std::array<std::uint32_t, kMaxCorners> corner_ids;
  std::array<std::uint32_t, kMaxCorners> edge_ids;  ///< edge i runs from corner i to corner i + 1
};

struct CoreEdge {
  Vec3 from = Vec3::Zero();
  Vec3 to = Vec3::Zero();
  std::uint32_t id = 0;
  std::uint32_t from_id = 0;
  std::uint32_t to_id = 0;
};

/// The face whose outward normal is nearest to `direction` (a segment: itself; a cylinder on its
/// side: the line there). Twelve corners represent a round cap. Not for points.
CoreFace face_towards(const ConvexCore& core, const Vec3& direction);
/// Cosine to a contact's direction above which a face of a hull may carry load before the contact
/// is found again: 0.06 rad, above CollisionOptions::recycle_angle.
inline constexpr double kBearingCosine = 0.9982;

/// The face towards a direction, neighbouring faces of a hull that a small tilt brings into
/// contact, and a face at its foremost corner, which need not be a corner of the first: a stone
/// that fell at 1.9 m/s was stopped by another corner, while the foremost sank by 8 % of its size.
class BearingFaces {
 public:
  BearingFaces(const ConvexCore& core, const Vec3& direction);
  /// Gets the next face, if any.
  bool next(CoreFace& face);

 private:
  const ConvexCore& core_;
  Vec3 direction_;
  std::size_t first_ = 0;
  std::size_t foremost_ = 0;  ///< the face at the foremost corner nearest to the direction
  std::size_t at_ = 0;
  std::size_t beside_ = 0;
  bool done_ = false;
};

/// The edge furthest along `direction`; of several the most perpendicular one. A point gives an
/// edge without length.
CoreEdge edge_towards(const ConvexCore& core, const Vec3& direction);

/// Gap between the cores along the unit direction n from a to b, m; negative where they overlap.
inline double separation(const ConvexCore& a, const ConvexCore& b, const Vec3& n) {
  return -b.reach(-n) - a.reach(n);
}

// Feature ids: the features of the two cores that a contact point comes from, the same whichever
// core was the reference.
inline std::uint32_t corner_feature(bool of_b, std::uint32_t id) {
  return (of_b ? 0x40000000u : 0u) | (id & 0x3fffffffu);
}
inline std::uint32_t crossing_feature(std::uint32_t edge_a, std::uint32_t edge_b) {
  return 0x80000000u | ((edge_b * 512u + edge_a) & 0x7fffffffu);
}

}  // namespace tandem::collision
