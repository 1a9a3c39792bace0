// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "tandem/collision/contact_source.h"
#include "tandem/pbd/export.h"
#include "tandem/pbd/world.h"

namespace tandem::collision {

/// Which colliders a query sees.
struct TANDEM_API QueryFilter {
  /// The query's own filter; by default it meets every collider whose mask is not 0.
  Filter filter{.category = ~0u};
  pbd::BodyId ignore_body = {};  ///< all colliders of this body are skipped
  bool sensors = false;          ///< include sensors
  bool back_faces = false;       ///< rays and casts also hit the backs of triangles
  /// Final decision, if set; called for candidates only, in unspecified order.
  std::function<bool(ColliderId)> accept = {};
};

struct TANDEM_API Ray {
  pbd::Vec3 origin = pbd::Vec3::Zero();      ///< m, world
  pbd::Vec3 direction = pbd::Vec3::UnitX();  ///< of any length above 0
  double max_distance = 1000.0;              ///< m, > 0
};

struct TANDEM_API RayHit {
  ColliderId collider = {};
  pbd::BodyId body = {};
  pbd::Vec3 point = pbd::Vec3::Zero();    ///< m, world
  pbd::Vec3 normal = pbd::Vec3::UnitZ();  ///< unit, out of the collider
  double distance = 0.0;                  ///< m; 0 if the ray starts inside a solid
  double fraction = 0.0;                  ///< fraction of max_distance
  /// Triangle index in a mesh; else TriangleMesh::kNone.
  std::uint32_t triangle = TriangleMesh::kNone;
};

struct TANDEM_API CastHit {
  ColliderId collider = {};
  pbd::BodyId body = {};
  pbd::Vec3 point = pbd::Vec3::Zero();    ///< m, world, where the surfaces meet
  pbd::Vec3 normal = pbd::Vec3::UnitZ();  ///< unit, out of the collider
  double fraction = 0.0;                  ///< of the displacement; 0 if they overlap at the start
  double depth = 0.0;                     ///< m, depth of that overlap along `normal`
  std::uint32_t triangle = TriangleMesh::kNone;
};

struct TANDEM_API ClosestHit {
  ColliderId collider = {};
  pbd::BodyId body = {};
  pbd::Vec3 on_shape = pbd::Vec3::Zero();     ///< m, world
  pbd::Vec3 on_collider = pbd::Vec3::Zero();  ///< m, world
  pbd::Vec3 normal = pbd::Vec3::UnitZ();      ///< unit, out of the collider
  double distance = 0.0;                      ///< m, negative where they overlap
  std::uint32_t triangle = TriangleMesh::kNone;
};

/// Rays, casts, overlaps and nearest points among the colliders of one scene.
///
///     SceneQuery query(world, scene);        // once
///     query.update(world, scene);            // whenever bodies have moved or colliders changed
///     auto hit = query.ray_cast({.origin = eye, .direction = forward});
///
/// Queries see the poses of the last update() and change nothing: a simulation runs the same with
/// and without them. The query has its own tree, in which update() touches only colliders that left
/// their boxes.
///
/// Query shapes are convex: no half-space, no mesh. Solids (convex shapes, half-spaces) are hit
/// from inside too, at distance 0 with the shortest way out as normal. Meshes are surfaces whose
/// fronts stop rays and casts (see QueryFilter::back_faces), but overlap() counts the inside of
/// closed ones. Among hits at equal distance the lower collider comes first.
///
/// Errors: std::invalid_argument naming field, value and rule. Memory: allocates in update() if the
/// scene has grown, and in the caller's vectors.
/// @par Thread safety  Const methods are safe against each other; update() is not.
class TANDEM_API SceneQuery {
 public:
  SceneQuery();
  SceneQuery(const pbd::World& world, const CollisionScene& scene);
  ~SceneQuery();
  SceneQuery(SceneQuery&&) noexcept;
  SceneQuery& operator=(SceneQuery&&) noexcept;

  /// Takes the current poses and colliders. One object serves one scene.
  void update(const pbd::World& world, const CollisionScene& scene);

  /// The first hit.
  std::optional<RayHit> ray_cast(const Ray& ray, const QueryFilter& filter = {}) const;
  /// Whether the ray hits anything; stops at the first hit found.
  bool ray_blocked(const Ray& ray, const QueryFilter& filter = {}) const;
  /// Append the first hit of each collider, by distance.
  void ray_cast_all(const Ray& ray, std::vector<RayHit>& out, const QueryFilter& filter = {}) const;

  /// First hit of the shape moving from `start` by `displacement` (m) without turning.
  std::optional<CastHit> shape_cast(const Shape& shape, const pbd::Pose& start,
                                    const pbd::Vec3& displacement,
                                    const QueryFilter& filter = {}) const;
  /// Append the first hit of each collider, by fraction.
  void shape_cast_all(const Shape& shape, const pbd::Pose& start, const pbd::Vec3& displacement,
                      std::vector<CastHit>& out, const QueryFilter& filter = {}) const;

  /// Whether any collider shares a point with the shape.
  bool overlaps(const Shape& shape, const pbd::Pose& pose, const QueryFilter& filter = {}) const;
  /// Appends all colliders that share a point with the shape, ascending.
  void overlap(const Shape& shape, const pbd::Pose& pose, std::vector<ColliderId>& out,
               const QueryFilter& filter = {}) const;

  /// The nearest point within `max_distance` (m, >= 0).
  std::optional<ClosestHit> closest(const Shape& shape, const pbd::Pose& pose, double max_distance,
                                    const QueryFilter& filter = {}) const;
  std::optional<ClosestHit> closest(const pbd::Vec3& point, double max_distance,
                                    const QueryFilter& filter = {}) const;
  /// Appends the nearest point of each collider within `max_distance`, by distance.
  void closest_all(const Shape& shape, const pbd::Pose& pose, double max_distance,
                   std::vector<ClosestHit>& out, const QueryFilter& filter = {}) const;
  /// The nearest point on one collider, whatever the filters are.
  std::optional<ClosestHit> closest_on(ColliderId collider, const Shape& shape,
                                       const pbd::Pose& pose, double max_distance) const;
  std::optional<ClosestHit> closest_on(ColliderId collider, const pbd::Vec3& point,
                                       double max_distance) const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tandem::collision
