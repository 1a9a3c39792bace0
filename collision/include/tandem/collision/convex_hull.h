// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "tandem/collision/triangle_mesh.h"
#include "tandem/pbd/export.h"
#include "tandem/pbd/types.h"

namespace tandem::collision {

/// The convex hull of points, with flat faces of any number of corners. Immutable once made, and
/// shared by many colliders.
/// @par Thread safety  Safe, all methods are const.
class TANDEM_API ConvexHull {
 public:
  static constexpr std::uint32_t kMaxVertices = 128;
  /// Tolerance as a share of the thickness: flat faces from a scanner or a decomposition have less
  /// noise. Without it they would be cut into facets, and the hull refused or slow.
  static constexpr double kTolerance = 1e-3;

  /// A run of corners in face_corners(), counter-clockwise seen from outside.
  struct Face {
    std::uint32_t begin = 0;
    std::uint32_t count = 0;
    pbd::Vec3 normal = pbd::Vec3::UnitZ();  ///< unit, outwards
    double offset = 0.0;                    ///< m: normal . x on the face, x relative to centre()
  };
  struct Edge {
    std::uint32_t from = 0;
    std::uint32_t to = 0;
    std::array<std::uint32_t, 2> faces{};  ///< left and right of the edge, seen from outside
  };

  /// Makes the hull. Points inside it are left out, and so are points outside by less than the
  /// tolerance or 1e-6 of the extent, the noise of single precision.
  /// @param points  m, in the shape's frame
  /// @param tolerance  0 to 0.1: share of the thickness, which is the height of the large
  ///   tetrahedron that the hull starts with
  /// @throws std::invalid_argument  naming the point or count: a coordinate is not finite, fewer
  ///   than four points, points that lie (within 1e-4 of their extent) in a plane, on a line or in
  ///   one place, or more than kMaxVertices corners
  static std::shared_ptr<const ConvexHull> make(std::span<const pbd::Vec3> points,
                                                double tolerance = kTolerance);

  struct Simplified {
    std::shared_ptr<const ConvexHull> hull = {};
    /// m: largest height of a point above a face, or of a face above the points.
    double error = 0.0;
  };
  /// Also accepts points that make() refuses for their shape: the hull keeps at most kMaxVertices
  /// corners, the farthest first; points in a plane become a plate of 1e-3 of their extent.
  /// @throws std::invalid_argument  as make() does for other reasons; three points are enough
  static Simplified simplify(std::span<const pbd::Vec3> points, double tolerance = kTolerance);

  /// m, centre of mass, in the shape's frame.
  const pbd::Vec3& centre() const { return centre_; }
  /// The tolerance given to make().
  double tolerance() const { return tolerance_; }
  /// The given points that are corners, m, in the shape's frame and in their order: make() of these
  /// with the same tolerance gives the same bits.
  std::span<const pbd::Vec3> points() const { return points_; }
  /// Corners relative to centre(), m, axes of the shape's frame.
  std::span<const pbd::Vec3> arms() const { return arms_; }
  std::span<const Face> faces() const { return faces_; }
  std::span<const std::uint32_t> face_corners(const Face& face) const {
    return std::span(corners_).subspan(face.begin, face.count);
  }
  /// Indices of the edges from each corner of the face to the next one.
  std::span<const std::uint32_t> face_edges(const Face& face) const {
    return std::span(edge_ids_).subspan(face.begin, face.count);
  }
  std::span<const Edge> edges() const { return edges_; }
  /// Indices of the edges that meet in a corner.
  std::span<const std::uint32_t> star(std::uint32_t vertex) const {
    return std::span(star_).subspan(star_start_[vertex],
                                    star_start_[vertex + 1] - star_start_[vertex]);
  }
  const Aabb& bounds() const { return bounds_; }
  double reach() const { return reach_; }    ///< m, distance of the farthest corner from centre()
  double extent() const { return extent_; }  ///< m, least distance of enclosing parallel planes
  double volume() const { return volume_; }  ///< m^3
  /// m^5, integral of x x^T over the solid, x from centre().
  const pbd::Mat3& second_moment() const { return second_; }

 private:
  ConvexHull() = default;
  static Simplified settled(std::vector<pbd::Vec3> corners, double tolerance, bool cut);
  double build(std::span<const pbd::Vec3> points, bool cut);
  void merge_faces(const std::vector<std::array<std::uint32_t, 3>>& triangles, double tolerance);
  void find_edges();
  void weigh();

  pbd::Vec3 centre_ = pbd::Vec3::Zero();
  std::vector<pbd::Vec3> points_;
  std::vector<pbd::Vec3> arms_;
  std::vector<Face> faces_;
  std::vector<std::uint32_t> corners_;
  std::vector<std::uint32_t> edge_ids_;
  std::vector<Edge> edges_;
  std::vector<std::uint32_t> star_;
  std::vector<std::uint32_t> star_start_;
  Aabb bounds_;
  double reach_ = 0.0;
  double extent_ = 0.0;
  double volume_ = 0.0;
  double tolerance_ = kTolerance;
  pbd::Mat3 second_ = pbd::Mat3::Zero();
};

}  // namespace tandem::collision
