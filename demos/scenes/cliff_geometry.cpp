// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "demos/scenes/cliff_geometry.h"

#include <algorithm>
#include <cmath>

#include "tandem/pbd/portable.h"

namespace tandem::demos {

namespace {

/// m, coordinate of a line of the grid.
double line(std::uint32_t i) { return -kCliffHalf + 2.0 * kCliffHalf * i / kCliffCells; }

}  // namespace

double cliff_height(double x, double y) {
  double base = 0.0;
  if (x < 0.0) {
    base = 6.0;
  } else if (x < 2.0) {
    const double s = 0.5 * x;
    base = 6.0 * (1.0 - s * s * (3.0 - 2.0 * s));
  }
  return base + 0.3 * pbd::portable::sin_cos(1.7 * x).sin * pbd::portable::sin_cos(1.3 * y).cos;
}

double cliff_surface(double x, double y) {
  const auto cell = [](double value) {
    const double cells = (value + kCliffHalf) * kCliffCells / (2.0 * kCliffHalf);
    return static_cast<std::uint32_t>(std::clamp(cells, 0.0, kCliffCells - 1.0));
  };
  const std::uint32_t i = cell(x);
  const std::uint32_t j = cell(y);
  const double width = 2.0 * kCliffHalf / kCliffCells;
  const double u = (x - line(i)) / width;
  const double v = (y - line(j)) / width;
  const double a = cliff_height(line(i), line(j));
  const double d = cliff_height(line(i + 1), line(j + 1));
  // The diagonal of the cell runs from a to d.
  if (u >= v) {
    const double b = cliff_height(line(i + 1), line(j));
    return a + u * (b - a) + v * (d - b);
  }
  const double c = cliff_height(line(i), line(j + 1));
  return a + v * (c - a) + u * (d - c);
}

CliffMesh cliff_mesh() {
  CliffMesh mesh;
  for (std::uint32_t j = 0; j <= kCliffCells; ++j) {
    for (std::uint32_t i = 0; i <= kCliffCells; ++i) {
      mesh.vertices.emplace_back(line(i), line(j), cliff_height(line(i), line(j)));
    }
  }
  for (std::uint32_t j = 0; j < kCliffCells; ++j) {
    for (std::uint32_t i = 0; i < kCliffCells; ++i) {
      const std::uint32_t a = j * (kCliffCells + 1) + i;
      const std::uint32_t b = a + 1;
      const std::uint32_t c = a + kCliffCells + 1;
      const std::uint32_t d = c + 1;
      mesh.triangles.push_back({a, b, d});
      mesh.triangles.push_back({a, d, c});
    }
  }
  return mesh;
}

std::vector<pbd::Vec3> cliff_balls(const std::function<double()>& uniform) {
  std::vector<pbd::Vec3> balls;
  for (int k = 0; k < 10; ++k) {
    for (int j = 0; j < 10; ++j) {
      for (int i = 0; i < 10; ++i) {
        const double x = (i - 4.5) * 0.45 + 0.04 * (uniform() - 0.5);
        const double y = (j - 4.5) * 0.45 + 0.04 * (uniform() - 0.5);
        balls.emplace_back(x, y, 7.0 + 0.45 * k);
      }
    }
  }
  return balls;
}

}  // namespace tandem::demos
