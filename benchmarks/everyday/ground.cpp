// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "everyday/ground.h"

#include <algorithm>
#include <cstdio>
#include <vector>

namespace tandem::everyday {

std::string name_of(Ground ground) {
  switch (ground) {
    case Ground::HalfSpace:
      return "half-space";
    case Ground::Box:
      return "box";
    case Ground::Mesh:
      return "mesh";
    case Ground::Field:
      return "field";
    case Ground::Hull:
      return "hull";
  }
  return "";
}

collision::Shape level_mesh(double low, double high, double reach, int columns, int rows) {
  std::vector<Vec3> corners;
  std::vector<collision::TriangleMesh::Triangle> triangles;
  for (int j = 0; j <= rows; ++j) {
    for (int i = 0; i <= columns; ++i) {
      corners.emplace_back(low + (high - low) * i / columns, -reach + 2.0 * reach * j / rows, 0.0);
    }
  }
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      const auto a = static_cast<std::uint32_t>(j * (columns + 1) + i);
      const auto b = a + 1;
      const auto c = a + static_cast<std::uint32_t>(columns) + 1;
      triangles.push_back({a, b, c + 1});
      triangles.push_back({a, c + 1, c});
    }
  }
  return collision::TriangleMesh::make(corners, triangles);
}

Solid level_ground(Ground ground, double friction, double reach) {
  SolidDef def{.type = BodyType::Static, .material = {.friction = friction}};
  // No cell corner below the origin.
  const Vec3 aside(0.0123 * reach, 0.0071 * reach, 0.0);
  constexpr int kCells = 32;
  switch (ground) {
    case Ground::HalfSpace:
      return {HalfSpace{}, def};
    case Ground::Box:
      def.pose.position = Vec3(0.0, 0.0, -0.25 * reach);
      return {Box{reach, reach, 0.25 * reach}, def};
    case Ground::Mesh:
      def.pose.position = aside;
      return {level_mesh(-reach, reach, reach, kCells, kCells), def};
    case Ground::Field: {
      def.pose.position = aside - Vec3(reach, reach, 0.0);
      const std::vector<double> heights((kCells + 1) * (kCells + 1), 0.0);
      const double spacing = 2.0 * reach / kCells;
      return {collision::HeightField::make(kCells + 1, kCells + 1, spacing, spacing, heights), def};
    }
    case Ground::Hull: {
      std::vector<Vec3> corners;
      for (int i = 0; i < 8; ++i) {
        corners.emplace_back((i & 1) != 0 ? reach : -reach, (i & 2) != 0 ? reach : -reach,
                             (i & 4) != 0 ? 0.0 : -0.5 * reach);
      }
      return {collision::ConvexHull::make(corners), def};
    }
  }
  return {};
}

double depth_below(const Pose& shape_pose, std::span<const Vec3> points) {
  double lowest = HUGE_VAL;
  for (const Vec3& point : points) {
    lowest = std::min(lowest, (shape_pose.orientation * point + shape_pose.position).z());
  }
  return -lowest;
}

std::string told(std::initializer_list<std::pair<const char*, double>> values) {
  std::string text;
  for (const auto& [name, value] : values) {
    char one[64];
    std::snprintf(one, sizeof one, "%s%s %.4g", text.empty() ? "" : ", ", name, value);
    text += one;
  }
  return text;
}

}  // namespace tandem::everyday
