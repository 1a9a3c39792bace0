// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "cells.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "tandem/pbd/validate.h"

namespace tandem::partition_bench {

using pbd::Vec3;

namespace {

/// The next axis that may be cut.
int next_axis(int axis, const std::array<bool, 3>& axes) {
  do {
    axis = (axis + 1) % 3;
  } while (!axes[static_cast<std::size_t>(axis)]);
  return axis;
}

void split(const Cell& cell, std::span<Vec3> points, std::size_t count, int axis,
           const std::array<bool, 3>& axes, std::vector<Cell>& out) {
  if (count == 1) {
    out.push_back(cell);
    return;
  }
  const std::size_t below = count / 2;
  const std::size_t cut = points.size() * below / count;
  double at = std::clamp(0.0, std::max(cell.min[axis], -1e9), std::min(cell.max[axis], 1e9));
  if (!points.empty()) {
    std::sort(points.begin(), points.end(),
              [axis](const Vec3& l, const Vec3& r) { return l[axis] < r[axis]; });
    at = cut == 0 ? points.front()[axis] : 0.5 * (points[cut - 1][axis] + points[cut][axis]);
  }
  Cell low = cell;
  Cell high = cell;
  low.max[axis] = at;
  high.min[axis] = at;
  split(low, points.first(cut), below, next_axis(axis, axes), axes, out);
  split(high, points.subspan(cut), count - below, next_axis(axis, axes), axes, out);
}

}  // namespace

double depth_in(const Cell& cell, const Vec3& point) {
  double inside = std::numeric_limits<double>::infinity();
  double outside2 = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double depth = std::min(point[axis] - cell.min[axis], cell.max[axis] - point[axis]);
    inside = std::min(inside, depth);
    if (depth < 0.0) outside2 += depth * depth;
  }
  return outside2 > 0.0 ? -std::sqrt(outside2) : inside;
}

std::vector<Cell> split_cells(std::span<const Vec3> points, std::size_t count,
                              std::array<bool, 3> axes) {
  pbd::detail::require(count >= 1, "split_cells", "count", static_cast<double>(count),
                       "at least 1");
  if (count > 1 && !axes[0] && !axes[1] && !axes[2]) {
    pbd::detail::refuse("split_cells: axes", "at least one that may be cut", "none");
  }
  for (const Vec3& point : points) pbd::detail::require_finite(point, "split_cells", "points");
  std::vector<Vec3> sorted(points.begin(), points.end());
  std::vector<Cell> cells;
  if (count == 1) return {Cell{}};
  split({}, sorted, count, next_axis(2, axes), axes, cells);
  return cells;
}

}  // namespace tandem::partition_bench
