// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "tandem/pbd/export.h"
#include "tandem/pbd/types.h"

namespace tandem::collision {

/// Axis-aligned box.
struct TANDEM_API Aabb {
  pbd::Vec3 min = pbd::Vec3::Zero();  ///< m
  pbd::Vec3 max = pbd::Vec3::Zero();  ///< m

  bool overlaps(const Aabb& other) const {
    // Early exit: most boxes are apart along x.
    return min.x() <= other.max.x() && other.min.x() <= max.x() && min.y() <= other.max.y() &&
           other.min.y() <= max.y() && min.z() <= other.max.z() && other.min.z() <= max.z();
  }
  bool contains(const Aabb& other) const {
    return min.x() <= other.min.x() && other.max.x() <= max.x() && min.y() <= other.min.y() &&
           other.max.y() <= max.y() && min.z() <= other.min.z() && other.max.z() <= max.z();
  }
  Aabb merged(const Aabb& other) const {
    return {min.cwiseMin(other.min), max.cwiseMax(other.max)};
  }
  Aabb expanded(double margin) const {
    return {min - pbd::Vec3::Constant(margin), max + pbd::Vec3::Constant(margin)};
  }
  double half_area() const {
    const pbd::Vec3 d = max - min;
    return d.x() * d.y() + d.y() * d.z() + d.z() * d.x();
  }
};

/// A surface of triangles, solid behind it. The front of a triangle is the side from which its
/// corners run counter-clockwise; only fronts make contacts. The mesh need not be closed. Corners
/// at equal positions are welded, so that neighbours are known whatever the indexing. Immutable
/// once made, and shared by many colliders.
/// @par Thread safety  Safe, all methods are const.
class TANDEM_API TriangleMesh {
 public:
  using Triangle = std::array<std::uint32_t, 3>;
  static constexpr std::uint32_t kNone = 0xffffffffu;

  /// Whether make() accepts a triangle: finite, and at least 1e-9 of its longest edge high.
  static bool has_area(const pbd::Vec3& a, const pbd::Vec3& b, const pbd::Vec3& c);

  /// Validates the input, welds equal corners, finds neighbours and builds the search tree.
  /// @param vertices  m, in the mesh frame     @param triangles  indices into `vertices`
  /// @throws std::invalid_argument  naming the vertex or triangle: a coordinate is not finite, an
  ///   index is out of range, a triangle has no area, there is no triangle, or an edge has more
  ///   than one triangle on the same side
  static std::shared_ptr<const TriangleMesh> make(std::span<const pbd::Vec3> vertices,
                                                  std::span<const Triangle> triangles);

  /// Welded corners; triangles index into these.
  std::span<const pbd::Vec3> vertices() const { return vertices_; }
  std::span<const Triangle> triangles() const { return triangles_; }
  const pbd::Vec3& vertex(std::uint32_t v) const { return vertices_[v]; }
  const Triangle& corners(std::uint32_t triangle) const { return triangles_[triangle]; }
  std::uint32_t vertex_count() const { return static_cast<std::uint32_t>(vertices_.size()); }
  /// Unit normal of the front.
  const pbd::Vec3& normal(std::uint32_t triangle) const { return normals_[triangle]; }
  /// The triangle across edge k (from corner k to corner k + 1), or kNone at a border. At
  /// T-junctions, where borders run along each other with different corners: the one that shares
  /// most of the edge.
  std::uint32_t neighbour(std::uint32_t triangle, int k) const { return neighbours_[triangle][k]; }
  /// Index of edge k, the same from both sides.
  std::uint32_t edge_id(std::uint32_t triangle, int k) const { return edge_ids_[triangle][k]; }
  /// Corners that share an edge with corner `vertex`, or a triangle whose border it lies on.
  std::span<const std::uint32_t> ring(std::uint32_t vertex) const {
    return std::span(ring_).subspan(ring_start_[vertex],
                                    ring_start_[vertex + 1] - ring_start_[vertex]);
  }
  /// Whether it has no border: it then has an inside, a volume and so a mass.
  bool closed() const { return closed_; }
  const Aabb& bounds() const { return bounds_; }

  /// Appends to `out`, ascending, the triangles whose bounds meet `box` (mesh frame).
  void query(const Aabb& box, std::vector<std::uint32_t>& out) const;

  /// Calls visit(triangle) for the triangles in leaves of the search tree whose boxes (mesh frame)
  /// have a finite rank(box), lower ranks first where they are known. The rank may change during
  /// the walk. Allocates nothing.
  template <class Rank, class Visit>
  void walk(Rank&& rank, Visit&& visit) const;

 private:
  struct Node {
    Aabb box;
    std::uint32_t begin = 0;  ///< leaf: first of `count` entries of order_; else the left child
    std::uint32_t count = 0;  ///< 0 for an inner node; its children are begin and begin + 1
  };

  TriangleMesh() = default;
  void weld(std::span<const pbd::Vec3> vertices, std::span<const Triangle> triangles);
  /// A corner and another corner in its ring.
  using Link = std::array<std::uint32_t, 2>;
  std::vector<Link> find_neighbours();
  void build_tree();
  /// Makes triangles neighbours if their borders run along each other with different corners.
  void join_borders(std::vector<Link>& links);
  std::optional<std::array<double, 2>> common_border(std::uint32_t triangle, int k,
                                                     std::uint32_t other, int j) const;
  void find_rings(std::span<const Link> links);

  std::vector<pbd::Vec3> vertices_;
  std::vector<Triangle> triangles_;
  std::vector<pbd::Vec3> normals_;
  std::vector<Triangle> neighbours_;
  std::vector<Triangle> edge_ids_;
  std::vector<std::uint32_t> ring_;
  std::vector<std::uint32_t> ring_start_;
  std::vector<Node> nodes_;
  std::vector<std::uint32_t> order_;
  Aabb bounds_;
  bool closed_ = false;
};

template <class Rank, class Visit>
void TriangleMesh::walk(Rank&& rank, Visit&& visit) const {
  std::array<std::uint32_t, 128> stack;  // the tree is balanced: depth below 32
  std::size_t top = 0;
  stack[top++] = 0;
  while (top > 0) {
    const Node& node = nodes_[stack[--top]];
    if (!std::isfinite(rank(node.box))) continue;
    if (node.count == 0) {
      const bool second_first = rank(nodes_[node.begin + 1].box) < rank(nodes_[node.begin].box);
      stack[top++] = node.begin + (second_first ? 0 : 1);
      stack[top++] = node.begin + (second_first ? 1 : 0);
      continue;
    }
    for (std::uint32_t j = node.begin; j < node.begin + node.count; ++j) visit(order_[j]);
  }
}

}  // namespace tandem::collision
