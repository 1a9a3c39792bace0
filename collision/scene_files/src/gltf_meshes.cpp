// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "gltf_meshes.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <span>
#include <unordered_set>

#include "nearest_hull.h"

namespace tandem::scene_files {
namespace {

/// Leaves out triangles that have an edge, run in the same direction, of an earlier one. Equal
/// positions are one corner. @return their number
std::size_t leave_out_repeated(std::span<const Vec3> points,
                               std::vector<collision::TriangleMesh::Triangle>& triangles) {
  const auto before = [](const Vec3& l, const Vec3& r) {
    return std::lexicographical_compare(l.data(), l.data() + 3, r.data(), r.data() + 3);
  };
  std::vector<Vec3> places(points.begin(), points.end());
  std::sort(places.begin(), places.end(), before);
  const auto place = [&](std::uint32_t corner) {
    const auto at = std::lower_bound(places.begin(), places.end(), points[corner], before);
    return static_cast<std::uint64_t>(at - places.begin());
  };
  std::unordered_set<std::uint64_t> used;
  return std::erase_if(triangles, [&](const auto& t) {
    std::array<std::uint64_t, 3> edges{};
    for (std::size_t k = 0; k < 3; ++k) edges[k] = place(t[k]) << 32 | place(t[(k + 1) % 3]);
    const auto known = [&](std::uint64_t edge) { return used.contains(edge); };
    if (std::any_of(edges.begin(), edges.end(), known)) return true;
    used.insert(edges.begin(), edges.end());
    return false;
  });
}

}  // namespace

void GltfMeshes::add(const Place& primitive, Mesh& out) {
  if (primitive.has("mode") && primitive.at("mode").value() != 4) {
    return primitive.at("mode").warn("only triangles (4) are read");
  }
  const Place attributes = primitive.at("attributes");
  const GltfAccessor points = buffers_.accessor(attributes.at("POSITION"), "VEC3", 3);
  const bool indexed = primitive.has("indices");
  GltfAccessor indices;
  if (indexed) indices = buffers_.accessor(primitive.at("indices"), "SCALAR", 1);
  const std::size_t size = indexed ? indices.count : points.count;
  if (size % 3 != 0) primitive.refuse("of three corners for each triangle");
  std::vector<std::uint32_t> corners(size);
  for (std::size_t i = 0; i < size; ++i) {
    const double corner = indexed ? indices.at(i, 0) : static_cast<double>(i);
    if (!(corner >= 0.0 && corner < static_cast<double>(points.count))) {
      primitive.at("indices").refuse("below the number of positions");
    }
    corners[i] = static_cast<std::uint32_t>(corner);
  }
  // Primitives may share their positions: use only those of this one, in their order.
  std::vector<std::uint32_t> used = corners;
  std::sort(used.begin(), used.end());
  used.erase(std::unique(used.begin(), used.end()), used.end());
  primitive.count(&SceneLimits::points, used.size());
  primitive.count(&SceneLimits::triangles, size / 3);
  const std::size_t first = out.points.size();
  for (const std::uint32_t point : used) {
    out.points.emplace_back(points.at(point, 0), points.at(point, 1), points.at(point, 2));
  }
  const auto place = [&](std::uint32_t corner) {
    const auto at = std::lower_bound(used.begin(), used.end(), corner);
    return static_cast<std::uint32_t>(first + static_cast<std::size_t>(at - used.begin()));
  };
  for (std::size_t i = 0; i < size; i += 3) {
    out.triangles.push_back({place(corners[i]), place(corners[i + 1]), place(corners[i + 2])});
  }
}

const GltfMeshes::Mesh& GltfMeshes::mesh(const Place& index) {
  const Place meshes = document_.at("meshes");
  const Place mesh = meshes.pick(index);
  const auto [known, fresh] = meshes_.try_emplace(index.value().get<std::int64_t>());
  if (fresh) {
    const Place primitives = mesh.at("primitives");
    for (std::size_t i = 0; i < primitives.size(); ++i) add(primitives.at(i), known->second);
  }
  return known->second;
}

collision::Shape GltfMeshes::shape(const Place& index, const Vec3& scale, bool hull) {
  const Mesh& read = mesh(index);
  // By bits, which have an order for all numbers.
  const auto bits = [&](int axis) { return std::bit_cast<std::uint64_t>(scale[axis]); };
  const Key key{index.value().get<std::int64_t>(), {bits(0), bits(1), bits(2)}, hull};
  if (const auto known = shapes_.find(key); known != shapes_.end()) return known->second;
  if (hull) {
    index.count(&SceneLimits::hull_points, read.points.size());
  } else {
    index.count(&SceneLimits::points, read.points.size());
    index.count(&SceneLimits::triangles, read.triangles.size());
  }
  std::vector<Vec3> points = read.points;
  for (Vec3& point : points) point = point.cwiseProduct(scale);
  collision::Shape& out = shapes_[key];
  if (hull) {
    return out = nearest_hull(points, index.strict(), [&](const std::string& off) {
             index.warn(std::string(kNearestHull) + ' ' + off);
           });
  }
  std::vector<collision::TriangleMesh::Triangle> triangles = read.triangles;
  if (scale.prod() < 0.0) {  // mirrored
    for (auto& triangle : triangles) std::swap(triangle[1], triangle[2]);
  }
  if (!index.strict()) {
    const std::size_t flat = std::erase_if(triangles, [&](const auto& t) {
      return !collision::TriangleMesh::has_area(points[t[0]], points[t[1]], points[t[2]]);
    });
    if (flat > 0) index.warn(std::to_string(flat) + " triangles without area are left out");
    const std::size_t twice = leave_out_repeated(points, triangles);
    if (twice > 0) {
      index.warn(std::to_string(twice) +
                 " triangles with another one on the same side of an edge are left out");
    }
  }
  return out = collision::TriangleMesh::make(points, triangles);
}

}  // namespace tandem::scene_files
