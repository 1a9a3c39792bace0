// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "mjcf_shapes.h"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "nearest_hull.h"
#include "tandem/pbd/portable.h"

namespace tandem::mjcf {
namespace {

/// Corners of an ellipsoid's hull, along a spiral from pole to pole. Their hull contains a sphere
/// of 0.9726 times their radius, so it is enlarged to be as far inside as outside: by 1.4 %.
constexpr int kCorners = 128;
constexpr double kEnlarged = 2.0 / (1.0 + 0.9726);

}  // namespace

std::optional<collision::Shape> Shapes::of(int g) {
  const mjModel& m = model_.m;
  const mjtNum* size = m.geom_size + 3 * g;
  switch (m.geom_type[g]) {
    case mjGEOM_PLANE:
      return HalfSpace{};
    case mjGEOM_SPHERE:
      return Sphere{size[0]};
    case mjGEOM_CAPSULE:
      return Capsule{.radius = size[0], .half_height = size[1]};
    case mjGEOM_CYLINDER:
      return Cylinder{.radius = size[0], .half_height = size[1]};
    case mjGEOM_BOX:
      return Box(vec(size));
    case mjGEOM_ELLIPSOID:
      return ellipsoid(g);
    case mjGEOM_MESH:
      return mesh(g);
    case mjGEOM_HFIELD:
      return field(g);
    default:
      model_.warn(mjOBJ_GEOM, g, "its type is not read");
      return std::nullopt;
  }
}

/// MuJoCo's contacts use hulls, too.
collision::Hull Shapes::mesh(int g) {
  const mjModel& m = model_.m;
  const int mesh = m.geom_dataid[g];
  collision::Hull& known = meshes_[mesh];
  if (known != nullptr) return known;
  // For colliding meshes MuJoCo knows the corners of the hull: a few of a scan's thousands.
  const int* graph = m.mesh_graphadr[mesh] < 0 ? nullptr : m.mesh_graph + m.mesh_graphadr[mesh];
  const int count = graph == nullptr ? m.mesh_vertnum[mesh] : graph[0];
  scene_files::require_within(
      model_.where(mjOBJ_MESH, mesh),
      limits_.add(&SceneLimits::hull_points, static_cast<std::size_t>(count)));
  std::vector<Vec3> points;
  for (int i = 0; i < count; ++i) {
    // After the numbers of corners and faces, and an address per corner.
    const int vertex = graph == nullptr ? i : graph[2 + count + i];
    const float* p = m.mesh_vert + 3 * (m.mesh_vertadr[mesh] + vertex);
    points.emplace_back(p[0], p[1], p[2]);
  }
  const auto tell = [&](const std::string& off) {
    model_.warnings.add("mesh", model_.title(mjOBJ_MESH, mesh) + ' ' + off,
                        scene_files::kNearestHull);
  };
  return known = model_.guard(mjOBJ_GEOM, g, [&] {
    return scene_files::nearest_hull(points, options_.strict, tell);
  });
}

collision::Hull Shapes::ellipsoid(int g) {
  const double turn = std::acos(-1.0) * (3.0 - std::sqrt(5.0));  // rad, by the golden ratio
  const Vec3 radii = kEnlarged * vec(model_.m.geom_size + 3 * g);
  scene_files::require_within(model_.where(mjOBJ_GEOM, g),
                              limits_.add(&SceneLimits::hull_points, kCorners));
  std::vector<Vec3> points;
  for (int i = 0; i < kCorners; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / kCorners;
    const double r = std::sqrt(1.0 - z * z);
    const auto [sine, cosine] = pbd::portable::sin_cos(turn * i);
    points.push_back(radii.cwiseProduct(Vec3(r * cosine, r * sine, z)));
  }
  model_.warn(mjOBJ_GEOM, g, "an ellipsoid is a hull of 128 corners, within 1.4 % of its size");
  return model_.guard(mjOBJ_GEOM, g, [&] { return collision::ConvexHull::make(points); });
}

/// MuJoCo has them on static bodies alone.
collision::Field Shapes::field(int g) {
  const mjModel& m = model_.m;
  const int id = m.geom_dataid[g];
  const mjtNum* size = m.hfield_size + 4 * id;
  const auto columns = static_cast<std::size_t>(m.hfield_ncol[id]);
  const auto rows = static_cast<std::size_t>(m.hfield_nrow[id]);
  scene_files::require_within(model_.where(mjOBJ_GEOM, g),
                              limits_.add(&SceneLimits::triangles, 2 * columns * rows));
  std::vector<double> heights;
  const float* data = m.hfield_data + m.hfield_adr[id];
  for (std::size_t i = 0; i < columns * rows; ++i) heights.push_back(size[2] * data[i]);
  return model_.guard(mjOBJ_GEOM, g, [&] {
    return collision::HeightField::make(static_cast<std::uint32_t>(columns),
                                        static_cast<std::uint32_t>(rows),
                                        2.0 * size[0] / static_cast<double>(columns - 1),
                                        2.0 * size[1] / static_cast<double>(rows - 1), heights);
  });
}

Vec3 origin_of(const mjModel& m, int g) {
  if (m.geom_type[g] != mjGEOM_HFIELD) return Vec3::Zero();
  const mjtNum* size = m.hfield_size + 4 * m.geom_dataid[g];
  return {-size[0], -size[1], 0.0};
}

}  // namespace tandem::mjcf
