// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "support/catch.h"
#include "tandem/collision/contact_source.h"
#include "tandem/pbd/math.h"
#include "tandem/pbd/workers.h"
#include "tandem/pbd/world.h"

namespace tandem::collision::testing {

using pbd::BodyDef;
using pbd::BodyId;
using pbd::BodyType;
using pbd::Manifold;
using pbd::Pose;
using pbd::Quat;
using pbd::Vec3;

inline constexpr double kDt = 1.0 / 60.0;

/// A world with its collision scene. No solver: poses are set by hand.
struct Fixture {
  pbd::World world;
  CollisionScene scene;
  pbd::Workers workers;
  std::vector<Manifold> manifolds;

  explicit Fixture(const CollisionOptions& options = {}) : scene(options) {}

  BodyId body(const Pose& pose, BodyType type = BodyType::Dynamic) {
    BodyDef def;
    def.type = type;
    def.pose = pose;
    return world.add_body(def);
  }
  BodyId add(const Shape& shape, const Pose& pose = {}, BodyType type = BodyType::Dynamic) {
    const BodyId id = body(pose, type);
    ColliderDef def;
    def.body = id;
    def.shape = shape;
    scene.add(world, def);
    return id;
  }
  BodyId fixed(const Shape& shape, const Pose& pose = {}) {
    return add(shape, pose, BodyType::Static);
  }
  const std::vector<Manifold>& collect(double dt = kDt) {
    manifolds.clear();
    scene.collect(world, dt, workers, manifolds);
    return manifolds;
  }
  Vec3 on_a(const Manifold& m, int i) const {
    return world.states()[m.body_a].pose.to_world(m.points[i].anchor_a_l);
  }
  Vec3 on_b(const Manifold& m, int i) const {
    return world.states()[m.body_b].pose.to_world(m.points[i].anchor_b_l);
  }
  /// By the definition in manifold.h.
  double gap(const Manifold& m, int i) const {
    return m.normal.dot(on_b(m, i) - on_a(m, i)) - m.radius_a - m.radius_b;
  }
  double deepest(const Manifold& m) const {
    double least = HUGE_VAL;
    for (int i = 0; i < m.count; ++i) least = std::min(least, gap(m, i));
    return least;
  }
};

/// The same numbers on every platform, unlike the distributions of the standard library.
class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  double in(double low, double high) {
    return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1p-53;
  }
  Vec3 vec_in(double low, double high) { return {in(low, high), in(low, high), in(low, high)}; }
  Vec3 vec(double size) { return {in(-size, size), in(-size, size), in(-size, size)}; }
  Quat quat() {
    for (;;) {
      const Vec3 axis = vec(1.0);  // one call after the other: the order is part of the seed
      const Quat q(in(-1, 1), axis.x(), axis.y(), axis.z());
      const double norm = q.norm();
      if (norm > 0.1 && norm < 1.0) return q.normalized();
    }
  }

 private:
  std::mt19937_64 engine_;
};

inline Pose at(double x, double y, double z) { return {Vec3(x, y, z), Quat::Identity()}; }
inline Pose at(const Vec3& p, const Vec3& rotation) { return {p, pbd::exp_map(rotation)}; }

/// Square of side `size` about the origin at height 0, in n x n cells of two triangles.
inline Mesh flat_mesh(double size, int n) {
  std::vector<Vec3> vertices;
  std::vector<TriangleMesh::Triangle> triangles;
  for (int j = 0; j <= n; ++j) {
    for (int i = 0; i <= n; ++i) {
      vertices.emplace_back(size * (i / double(n) - 0.5), size * (j / double(n) - 0.5), 0.0);
    }
  }
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      const auto v = static_cast<std::uint32_t>(j * (n + 1) + i);
      const auto up = v + static_cast<std::uint32_t>(n) + 1;
      triangles.push_back({v, v + 1, up + 1});
      triangles.push_back({v, up + 1, up});
    }
  }
  return TriangleMesh::make(vertices, triangles);
}

/// The surface of a box, fronts outside.
inline Mesh box_mesh(const Vec3& half) {
  std::vector<Vec3> v;
  for (int i = 0; i < 8; ++i) {
    v.emplace_back((i & 1) != 0 ? half.x() : -half.x(), (i & 2) != 0 ? half.y() : -half.y(),
                   (i & 4) != 0 ? half.z() : -half.z());
  }
  const std::vector<TriangleMesh::Triangle> t{{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6},
                                              {0, 1, 5}, {0, 5, 4}, {2, 6, 7}, {2, 7, 3},
                                              {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return TriangleMesh::make(v, t);
}

}  // namespace tandem::collision::testing
