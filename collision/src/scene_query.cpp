// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/collision/scene_query.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "box_sweep.h"
#include "collider_query.h"
#include "query_colliders.h"
#include "query_input.h"
#include "tandem/pbd/validate.h"

namespace tandem::collision {
namespace {

using pbd::Pose;
using pbd::Vec3;

MeshSides sides_of(const QueryFilter& filter) {
  return filter.back_faces ? MeshSides::Both : MeshSides::Front;
}

bool keep_order(const Aabb&, const Aabb&) { return false; }

/// Of two hits at equal distance the lower collider wins.
bool better_collider(double value, std::uint32_t index, double best, ColliderId best_id) {
  return value != best ? value < best : index < best_id.index;
}

template <class Hit>
bool by_collider(const Hit& l, const Hit& r) {
  return l.collider.index < r.collider.index;
}

}  // namespace

class __attribute__((visibility("hidden"))) SceneQuery::Impl {
 public:
  QueryColliders colliders;

  bool accepts(std::uint32_t index, const QueryFilter& filter) const {
    const ColliderDef& def = colliders.collider(index).def;
    if (def.sensor && !filter.sensors) return false;
    if (filter.ignore_body.valid() && def.body == filter.ignore_body) return false;
    if (!may_meet(filter.filter, def.filter)) return false;
    return !filter.accept || filter.accept(colliders.id(index));
  }

  /// Calls visit(index) for accepted colliders whose boxes the sweep meets within `limit`, which
  /// visit() may lower.
  void along(const BoxSweep& sweep, const double& limit, const QueryFilter& filter,
             auto&& visit) const {
    for (const std::uint32_t i : colliders.half_spaces()) {
      if (accepts(i, filter)) visit(i);
    }
    colliders.tree().walk(
        [&](const Aabb& first, const Aabb& second) { return sweep.second_first(first, second); },
        [&](const Aabb& box) { return std::isfinite(sweep.rank(box, limit)); },
        [&](std::uint32_t i) {
          if (accepts(i, filter)) visit(i);
        });
  }

  /// Like along(), for colliders within `distance` of the box.
  void near(const Aabb& own, const double& distance, const QueryFilter& filter,
            auto&& visit) const {
    for (const std::uint32_t i : colliders.half_spaces()) {
      if (accepts(i, filter)) visit(i);
    }
    colliders.tree().walk(
        keep_order,
        [&](const Aabb& box) {
          const Vec3 between =
              (box.min - own.max).cwiseMax(own.min - box.max).cwiseMax(Vec3::Zero());
          return between.norm() <= std::max(0.0, distance) * (1.0 + 1e-12);
        },
        [&](std::uint32_t i) {
          if (accepts(i, filter)) visit(i);
        });
  }

  void rays(const CheckedRay& ray, const double& limit, const QueryFilter& filter,
            auto&& visit) const {
    const BoxSweep sweep({ray.origin, ray.origin}, ray.direction);
    along(sweep, limit, filter, [&](std::uint32_t i) {
      SurfaceHit hit;
      if (ray_collider(colliders.collider(i), ray.origin, ray.direction, limit, sides_of(filter),
                       hit)) {
        visit(i, hit);
      }
    });
  }

  void casts(const Probe& probe, const Vec3& direction, const double& limit,
             const QueryFilter& filter, auto&& visit) const {
    const BoxSweep sweep(probe.box, direction);
    along(sweep, limit, filter, [&](std::uint32_t i) {
      SurfaceHit hit;
      if (cast_collider(colliders.collider(i), probe.core, probe.origin, direction, limit,
                        sides_of(filter), hit)) {
        visit(i, hit);
      }
    });
  }

  RayHit ray_hit(std::uint32_t i, const CheckedRay& ray, const SurfaceHit& hit) const {
    return {.collider = colliders.id(i),
            .body = colliders.collider(i).def.body,
            .point = ray.origin + hit.point,
            .normal = hit.normal,
            .distance = hit.distance,
            .fraction = hit.distance / ray.limit,
            .triangle = hit.triangle};
  }
  CastHit cast_hit(std::uint32_t i, const Probe& probe, double length,
                   const SurfaceHit& hit) const {
    return {.collider = colliders.id(i),
            .body = colliders.collider(i).def.body,
            .point = probe.origin + hit.point,
            .normal = hit.normal,
            .fraction = length > 0.0 ? hit.distance / length : 0.0,
            .depth = hit.depth,
            .triangle = hit.triangle};
  }
  ClosestHit closest_hit(std::uint32_t i, const Probe& probe, const SurfaceHit& hit) const {
    return {.collider = colliders.id(i),
            .body = colliders.collider(i).def.body,
            .on_shape = probe.origin + hit.on_probe,
            .on_collider = probe.origin + hit.point,
            .normal = hit.normal,
            .distance = hit.distance - hit.depth,
            .triangle = hit.triangle};
  }

  std::optional<ClosestHit> closest(const Probe& probe, double max_distance,
                                    const QueryFilter& filter) const {
    check_distance(max_distance);
    std::optional<ClosestHit> best;
    double limit = max_distance;
    near(probe.box, limit, filter, [&](std::uint32_t i) {
      SurfaceHit hit;
      const Collider& c = colliders.collider(i);
      if (!nearest_on_collider(c, probe.core, probe.origin, std::max(0.0, limit), hit)) return;
      const double distance = hit.distance - hit.depth;
      if (best && !better_collider(distance, i, best->distance, best->collider)) return;
      best = closest_hit(i, probe, hit);
      limit = std::min(limit, distance);
    });
    return best;
  }

  std::optional<ClosestHit> closest_on(ColliderId id, const Probe& probe,
                                       double max_distance) const {
    check_distance(max_distance);
    if (id.index >= colliders.size() || !colliders.present(id.index) ||
        colliders.id(id.index) != id) {
      pbd::detail::refuse("SceneQuery::closest_on: collider", "one that the last update() saw",
                          id.index);
    }
    SurfaceHit hit;
    const Collider& c = colliders.collider(id.index);
    if (!nearest_on_collider(c, probe.core, probe.origin, max_distance, hit)) return {};
    return closest_hit(id.index, probe, hit);
  }
};

SceneQuery::SceneQuery() : impl_(std::make_unique<Impl>()) {}
SceneQuery::SceneQuery(const pbd::World& world, const CollisionScene& scene) : SceneQuery() {
  update(world, scene);
}
SceneQuery::~SceneQuery() = default;
SceneQuery::SceneQuery(SceneQuery&&) noexcept = default;
SceneQuery& SceneQuery::operator=(SceneQuery&&) noexcept = default;

void SceneQuery::update(const pbd::World& world, const CollisionScene& scene) {
  impl_->colliders.update(world, scene);
}

std::optional<RayHit> SceneQuery::ray_cast(const Ray& ray, const QueryFilter& filter) const {
  const CheckedRay checked(ray);
  std::optional<RayHit> best;
  double limit = checked.limit;
  impl_->rays(checked, limit, filter, [&](std::uint32_t i, const SurfaceHit& hit) {
    if (best && !better_collider(hit.distance, i, best->distance, best->collider)) return;
    best = impl_->ray_hit(i, checked, hit);
    limit = hit.distance;
  });
  return best;
}

bool SceneQuery::ray_blocked(const Ray& ray, const QueryFilter& filter) const {
  const CheckedRay checked(ray);
  bool found = false;
  double limit = checked.limit;
  impl_->rays(checked, limit, filter, [&](std::uint32_t, const SurfaceHit&) {
    found = true;
    limit = -1.0;  // nothing is met before the start
  });
  return found;
}

void SceneQuery::ray_cast_all(const Ray& ray, std::vector<RayHit>& out,
                              const QueryFilter& filter) const {
  const CheckedRay checked(ray);
  const auto first = static_cast<std::ptrdiff_t>(out.size());
  impl_->rays(checked, checked.limit, filter, [&](std::uint32_t i, const SurfaceHit& hit) {
    out.push_back(impl_->ray_hit(i, checked, hit));
  });
  std::sort(out.begin() + first, out.end(), [](const RayHit& l, const RayHit& r) {
    return l.distance != r.distance ? l.distance < r.distance : by_collider(l, r);
  });
}

std::optional<CastHit> SceneQuery::shape_cast(const Shape& shape, const Pose& start,
                                              const Vec3& displacement,
                                              const QueryFilter& filter) const {
  const Probe probe(shape, start);
  const Displacement way(displacement);
  std::optional<CastHit> best;
  double limit = way.length;
  impl_->casts(probe, way.direction, limit, filter, [&](std::uint32_t i, const SurfaceHit& hit) {
    // Of several overlaps at the start, the deepest.
    const CastHit found = impl_->cast_hit(i, probe, way.length, hit);
    if (best) {
      const bool tied = found.fraction == best->fraction;
      if (tied ? !better_collider(-found.depth, i, -best->depth, best->collider)
               : found.fraction > best->fraction) {
        return;
      }
    }
    best = found;
    limit = hit.distance;
  });
  return best;
}

void SceneQuery::shape_cast_all(const Shape& shape, const Pose& start, const Vec3& displacement,
                                std::vector<CastHit>& out, const QueryFilter& filter) const {
  const Probe probe(shape, start);
  const Displacement way(displacement);
  const auto first = static_cast<std::ptrdiff_t>(out.size());
  impl_->casts(probe, way.direction, way.length, filter,
               [&](std::uint32_t i, const SurfaceHit& hit) {
                 out.push_back(impl_->cast_hit(i, probe, way.length, hit));
               });
  std::sort(out.begin() + first, out.end(), [](const CastHit& l, const CastHit& r) {
    return l.fraction != r.fraction ? l.fraction < r.fraction : by_collider(l, r);
  });
}

bool SceneQuery::overlaps(const Shape& shape, const Pose& pose, const QueryFilter& filter) const {
  const Probe probe(shape, pose);
  bool found = false;
  impl_->near(probe.box, 0.0, filter, [&](std::uint32_t i) {
    found = found || overlaps_collider(impl_->colliders.collider(i), probe.core, probe.origin);
  });
  return found;
}

void SceneQuery::overlap(const Shape& shape, const Pose& pose, std::vector<ColliderId>& out,
                         const QueryFilter& filter) const {
  const Probe probe(shape, pose);
  const auto first = static_cast<std::ptrdiff_t>(out.size());
  impl_->near(probe.box, 0.0, filter, [&](std::uint32_t i) {
    if (overlaps_collider(impl_->colliders.collider(i), probe.core, probe.origin)) {
      out.push_back(impl_->colliders.id(i));
    }
  });
  std::sort(out.begin() + first, out.end());
}

std::optional<ClosestHit> SceneQuery::closest(const Shape& shape, const Pose& pose,
                                              double max_distance,
                                              const QueryFilter& filter) const {
  return impl_->closest(Probe(shape, pose), max_distance, filter);
}

std::optional<ClosestHit> SceneQuery::closest(const Vec3& point, double max_distance,
                                              const QueryFilter& filter) const {
  return impl_->closest(Probe(point), max_distance, filter);
}

void SceneQuery::closest_all(const Shape& shape, const Pose& pose, double max_distance,
                             std::vector<ClosestHit>& out, const QueryFilter& filter) const {
  check_distance(max_distance);
  const Probe probe(shape, pose);
  const auto first = static_cast<std::ptrdiff_t>(out.size());
  impl_->near(probe.box, max_distance, filter, [&](std::uint32_t i) {
    SurfaceHit hit;
    const Collider& c = impl_->colliders.collider(i);
    if (nearest_on_collider(c, probe.core, probe.origin, max_distance, hit)) {
      out.push_back(impl_->closest_hit(i, probe, hit));
    }
  });
  std::sort(out.begin() + first, out.end(), [](const ClosestHit& l, const ClosestHit& r) {
    return l.distance != r.distance ? l.distance < r.distance : by_collider(l, r);
  });
}

std::optional<ClosestHit> SceneQuery::closest_on(ColliderId collider, const Shape& shape,
                                                 const Pose& pose, double max_distance) const {
  return impl_->closest_on(collider, Probe(shape, pose), max_distance);
}

std::optional<ClosestHit> SceneQuery::closest_on(ColliderId collider, const Vec3& point,
                                                 double max_distance) const {
  return impl_->closest_on(collider, Probe(point), max_distance);
}

}  // namespace tandem::collision
