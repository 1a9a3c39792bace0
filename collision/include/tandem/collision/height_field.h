// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "tandem/collision/triangle_mesh.h"
#include "tandem/pbd/export.h"

namespace tandem::collision {

/// Heights on a regular grid: a surface of triangles, solid below, that stores heights only. Vertex
/// (i, j) is at (i * spacing_x, j * spacing_y, height). The diagonal of a cell runs from its lower
/// to its upper corner and gives triangles (a, b, d) and (a, d, c) with a = (i, j), b = (i + 1, j),
/// c = (i, j + 1), d = (i + 1, j + 1). Contacts are those of the TriangleMesh of these triangles.
/// Immutable once made, and shared.
/// @par Thread safety  Safe, all methods are const.
class TANDEM_API HeightField {
 public:
  using Triangle = TriangleMesh::Triangle;
  static constexpr std::uint32_t kNone = TriangleMesh::kNone;

  /// @param columns, rows  vertices along x and y, 2 to 16384 each
  /// @param spacing_x, spacing_y  m, > 0     @param heights  m, finite; row by row
  /// @throws std::invalid_argument  naming field, value and rule
  static std::shared_ptr<const HeightField> make(std::uint32_t columns, std::uint32_t rows,
                                                 double spacing_x, double spacing_y,
                                                 std::span<const double> heights);

  std::uint32_t columns() const { return columns_; }
  std::uint32_t rows() const { return rows_; }
  double spacing_x() const { return spacing_x_; }
  double spacing_y() const { return spacing_y_; }
  std::uint32_t vertex_count() const { return columns_ * rows_; }
  std::uint32_t triangle_count() const { return 2 * (columns_ - 1) * (rows_ - 1); }

  // Mesh interface, see TriangleMesh.
  pbd::Vec3 vertex(std::uint32_t v) const {
    const std::uint32_t row = v / columns_;
    return {spacing_x_ * (v % columns_), spacing_y_ * row, heights_[v]};
  }
  Triangle corners(std::uint32_t triangle) const;
  pbd::Vec3 normal(std::uint32_t triangle) const;
  std::uint32_t neighbour(std::uint32_t triangle, int k) const;
  std::uint32_t edge_id(std::uint32_t triangle, int k) const;
  /// Corners that share an edge with corner `vertex`.
  struct Ring {
    std::array<std::uint32_t, 6> at{};
    std::size_t count = 0;
    const std::uint32_t* begin() const { return at.data(); }
    const std::uint32_t* end() const { return at.data() + count; }
  };
  Ring ring(std::uint32_t vertex) const;
  const Aabb& bounds() const { return bounds_; }
  /// Appends to `out`, ascending, the triangles whose bounds meet `box`.
  void query(const Aabb& box, std::vector<std::uint32_t>& out) const;
  /// Calls visit(triangle) for the triangles of cells whose boxes have a finite rank(box), as
  /// TriangleMesh::walk().
  template <class Rank, class Visit>
  void walk(Rank&& rank, Visit&& visit) const;

 private:
  /// Cells from (i0, j0) up to, not including, (i1, j1).
  struct Block {
    std::uint32_t i0 = 0, i1 = 0, j0 = 0, j1 = 0;
  };
  /// Exact bounds of one cell; a larger block gets the height range of the whole field.
  Aabb block_box(const Block& block) const;

  HeightField() = default;

  std::uint32_t columns_ = 2;
  std::uint32_t rows_ = 2;
  double spacing_x_ = 1.0;
  double spacing_y_ = 1.0;
  std::vector<double> heights_;
  Aabb bounds_;
};

template <class Rank, class Visit>
void HeightField::walk(Rank&& rank, Visit&& visit) const {
  std::array<Block, 64> stack;  // halves of at most 16384 x 16384 cells: depth below 30
  std::size_t top = 0;
  stack[top++] = {0, columns_ - 1, 0, rows_ - 1};
  while (top > 0) {
    const Block block = stack[--top];
    if (!std::isfinite(rank(block_box(block)))) continue;
    const std::uint32_t width = block.i1 - block.i0;
    const std::uint32_t depth = block.j1 - block.j0;
    if (width == 1 && depth == 1) {
      const std::uint32_t t = 2 * (block.j0 * (columns_ - 1) + block.i0);
      visit(t);
      visit(t + 1);
      continue;
    }
    Block first = block;
    Block second = block;
    if (width >= depth) {
      first.i1 = second.i0 = block.i0 + width / 2;
    } else {
      first.j1 = second.j0 = block.j0 + depth / 2;
    }
    const bool second_first = rank(block_box(second)) < rank(block_box(first));
    stack[top++] = second_first ? first : second;
    stack[top++] = second_first ? second : first;
  }
}

}  // namespace tandem::collision
