// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/collision/height_field.h"

#include <algorithm>
#include <cmath>

#include "tandem/pbd/validate.h"

namespace tandem::collision {
namespace {

using pbd::Vec3;

constexpr std::uint32_t kMaxSide = 16384;

}  // namespace

std::shared_ptr<const HeightField> HeightField::make(std::uint32_t columns, std::uint32_t rows,
                                                     double spacing_x, double spacing_y,
                                                     std::span<const double> heights) {
  if (columns < 2 || columns > kMaxSide)
    pbd::detail::refuse("HeightField: columns", "from 2 to 16384", columns);
  if (rows < 2 || rows > kMaxSide)
    pbd::detail::refuse("HeightField: rows", "from 2 to 16384", rows);
  for (const double spacing : {spacing_x, spacing_y}) {
    if (!(spacing > 0.0 && spacing < 1e6)) {
      pbd::detail::refuse("HeightField: spacing", "> 0 and below 1e6 m", spacing);
    }
  }
  const std::size_t count = std::size_t{columns} * rows;
  if (heights.size() != count) {
    pbd::detail::refuse("HeightField: heights.size", "columns * rows",
                        static_cast<double>(heights.size()));
  }
  const std::shared_ptr<HeightField> field(new HeightField);
  double low = HUGE_VAL;
  double high = -HUGE_VAL;
  for (std::size_t i = 0; i < count; ++i) {
    if (!(std::abs(heights[i]) < 1e6)) {
      pbd::detail::refuse("HeightField: heights[" + std::to_string(i) + "]",
                          "finite and within 1e6 m", heights[i]);
    }
    low = std::min(low, heights[i]);
    high = std::max(high, heights[i]);
  }
  field->columns_ = columns;
  field->rows_ = rows;
  field->spacing_x_ = spacing_x;
  field->spacing_y_ = spacing_y;
  field->heights_.assign(heights.begin(), heights.end());
  field->bounds_ = {Vec3(0, 0, low), Vec3(spacing_x * (columns - 1), spacing_y * (rows - 1), high)};
  return field;
}

HeightField::Triangle HeightField::corners(std::uint32_t triangle) const {
  const std::uint32_t cell = triangle / 2;
  const std::uint32_t a = cell / (columns_ - 1) * columns_ + cell % (columns_ - 1);
  const std::uint32_t d = a + columns_ + 1;
  return triangle % 2 == 0 ? Triangle{a, a + 1, d} : Triangle{a, d, a + columns_};
}

pbd::Vec3 HeightField::normal(std::uint32_t triangle) const {
  const Triangle t = corners(triangle);
  // Slopes along x and y: the first triangle has its corner b beside a, the second has c above it.
  const double x =
      triangle % 2 == 0 ? heights_[t[1]] - heights_[t[0]] : heights_[t[1]] - heights_[t[2]];
  const double y =
      triangle % 2 == 0 ? heights_[t[2]] - heights_[t[1]] : heights_[t[2]] - heights_[t[0]];
  return Vec3(-x / spacing_x_, -y / spacing_y_, 1.0).normalized();
}

std::uint32_t HeightField::neighbour(std::uint32_t triangle, int k) const {
  const std::uint32_t across = columns_ - 1;
  const std::uint32_t cell = triangle / 2;
  const std::uint32_t i = cell % across;
  const std::uint32_t j = cell / across;
  if (triangle % 2 == 0) {
    if (k == 0) return j == 0 ? kNone : 2 * (cell - across) + 1;
    if (k == 1) return i + 1 == across ? kNone : 2 * (cell + 1) + 1;
    return triangle + 1;
  }
  if (k == 0) return triangle - 1;
  if (k == 1) return j + 2 == rows_ ? kNone : 2 * (cell + across);
  return i == 0 ? kNone : 2 * (cell - 1);
}

std::uint32_t HeightField::edge_id(std::uint32_t triangle, int k) const {
  // Each vertex owns the edges along x and y and the diagonal that start there.
  const Triangle t = corners(triangle);
  if (triangle % 2 == 0) return k == 0 ? 3 * t[0] : k == 1 ? 3 * t[1] + 1 : 3 * t[0] + 2;
  return k == 0 ? 3 * t[0] + 2 : k == 1 ? 3 * t[2] : 3 * t[0] + 1;
}

HeightField::Ring HeightField::ring(std::uint32_t vertex) const {
  Ring ring;
  const std::uint32_t i = vertex % columns_;
  const std::uint32_t j = vertex / columns_;
  const bool left = i > 0;
  const bool right = i + 1 < columns_;
  const bool below = j > 0;
  const bool above = j + 1 < rows_;
  if (left && below) ring.at[ring.count++] = vertex - columns_ - 1;
  if (below) ring.at[ring.count++] = vertex - columns_;
  if (left) ring.at[ring.count++] = vertex - 1;
  if (right) ring.at[ring.count++] = vertex + 1;
  if (above) ring.at[ring.count++] = vertex + columns_;
  if (right && above) ring.at[ring.count++] = vertex + columns_ + 1;
  return ring;
}

Aabb HeightField::block_box(const Block& block) const {
  Aabb box = bounds_;
  box.min.x() = spacing_x_ * block.i0;
  box.max.x() = spacing_x_ * block.i1;
  box.min.y() = spacing_y_ * block.j0;
  box.max.y() = spacing_y_ * block.j1;
  if (block.i1 == block.i0 + 1 && block.j1 == block.j0 + 1) {
    const std::uint32_t v = block.j0 * columns_ + block.i0;
    const auto [low, high] = std::minmax(
        {heights_[v], heights_[v + 1], heights_[v + columns_], heights_[v + columns_ + 1]});
    box.min.z() = low;
    box.max.z() = high;
  }
  return box;
}

void HeightField::query(const Aabb& box, std::vector<std::uint32_t>& out) const {
  if (!bounds_.overlaps(box)) return;
  const auto cells = [](double low, double high, double spacing, std::uint32_t count) {
    const double last = count - 1.0;
    return std::pair(static_cast<std::uint32_t>(std::clamp(low / spacing, 0.0, last)),
                     static_cast<std::uint32_t>(std::clamp(high / spacing, 0.0, last)));
  };
  const auto [i0, i1] = cells(box.min.x(), box.max.x(), spacing_x_, columns_ - 1);
  const auto [j0, j1] = cells(box.min.y(), box.max.y(), spacing_y_, rows_ - 1);
  for (std::uint32_t j = j0; j <= j1; ++j) {
    for (std::uint32_t i = i0; i <= i1; ++i) {
      const std::uint32_t t = 2 * (j * (columns_ - 1) + i);
      for (const std::uint32_t triangle : {t, t + 1}) {
        const Triangle c = corners(triangle);
        const double low = std::min({heights_[c[0]], heights_[c[1]], heights_[c[2]]});
        const double high = std::max({heights_[c[0]], heights_[c[1]], heights_[c[2]]});
        if (low <= box.max.z() && high >= box.min.z()) out.push_back(triangle);
      }
    }
  }
}

}  // namespace tandem::collision
