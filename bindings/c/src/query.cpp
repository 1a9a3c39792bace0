// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <algorithm>
#include <optional>
#include <vector>

#include "convert.h"
#include "guard.h"
#include "shape_impl.h"
#include "tandem/collision/scene_query.h"
#include "world_impl.h"

using namespace tandem;
using namespace tandem::c;

struct tandem_query {
  explicit tandem_query(const tandem_world& of) : world(of), query(of.world, of.shapes) {}
  const tandem_world& world;
  collision::SceneQuery query;
};

namespace {

collision::QueryFilter filter_of(const tandem_query_filter* given) {
  if (given == nullptr) return {};
  collision::QueryFilter filter{
      .filter = {.category = given->category, .mask = given->mask, .group = given->group},
      .ignore_body = from_c(given->ignore),
      .sensors = given->sensors != 0,
      .back_faces = given->back_faces != 0};
  if (given->accept != nullptr) {
    filter.accept = [accept = given->accept, user = given->user](collision::ColliderId id) {
      return accept(user, to_c(id)) != 0;
    };
  }
  return filter;
}

template <class Hit>
tandem_query_hit hit_of(const Hit& hit, const pbd::Vec3& point, double distance, double fraction) {
  return {.collider = to_c(hit.collider),
          .body = to_c(hit.body),
          .point = to_c(point),
          .normal = to_c(hit.normal),
          .distance = distance,
          .fraction = fraction,
          .triangle = hit.triangle};
}
tandem_query_hit found_of(const collision::RayHit& hit) {
  return hit_of(hit, hit.point, hit.distance, hit.fraction);
}
tandem_query_hit found_of(const collision::CastHit& hit) {
  return hit_of(hit, hit.point, -hit.depth, hit.fraction);
}
tandem_query_hit found_of(const collision::ClosestHit& hit) {
  return hit_of(hit, hit.on_collider, hit.distance, 0.0);
}
tandem_collider found_of(const collision::ColliderId& id) { return to_c(id); }

/// Writes as many as fit.
template <class Found, class Out>
void write(const std::vector<Found>& found, Out* out, size_t capacity, size_t* count) {
  if (capacity > 0) required(out, "hits");
  required(count, "count") = found.size();
  const size_t written = std::min(capacity, found.size());
  std::transform(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(written), out,
                 [](const Found& each) { return found_of(each); });
}

template <class Found>
std::vector<Found> list_of(const std::optional<Found>& found) {
  return found ? std::vector<Found>{*found} : std::vector<Found>{};
}

}  // namespace

tandem_query* tandem_query_create(const tandem_world* world, tandem_error* error) {
  return made_by(error, [&] { return new tandem_query(required(world, "world")); });
}

void tandem_query_destroy(tandem_query* query) { delete query; }

tandem_result tandem_query_update(tandem_query* query, tandem_error* error) {
  return guarded(error, [&] {
    tandem_query& q = required(query, "query");
    q.query.update(q.world.world, q.world.shapes);
  });
}

void tandem_query_filter_init(tandem_query_filter* filter) {
  if (filter == nullptr) return;
  const collision::QueryFilter defaults;
  *filter = {.category = defaults.filter.category,
             .mask = defaults.filter.mask,
             .group = defaults.filter.group,
             .ignore = TANDEM_NO_BODY,
             .sensors = 0,
             .back_faces = 0,
             .accept = nullptr,
             .user = nullptr};
}

tandem_result tandem_query_ray(const tandem_query* query, tandem_vec3 origin, tandem_vec3 direction,
                               double max_distance, const tandem_query_filter* filter,
                               tandem_query_hit* hits, size_t capacity, size_t* count,
                               tandem_error* error) {
  return guarded(error, [&] {
    const collision::SceneQuery& q = required(query, "query").query;
    const collision::Ray ray{
        .origin = from_c(origin), .direction = from_c(direction), .max_distance = max_distance};
    std::vector<collision::RayHit> found;
    if (capacity > 1) {
      q.ray_cast_all(ray, found, filter_of(filter));
    } else if (capacity == 1) {
      found = list_of(q.ray_cast(ray, filter_of(filter)));
    } else if (q.ray_blocked(ray, filter_of(filter))) {
      found.emplace_back();
    }
    write(found, hits, capacity, count);
  });
}

tandem_result tandem_query_cast(const tandem_query* query, const tandem_shape* shape,
                                const tandem_pose* start, tandem_vec3 displacement,
                                const tandem_query_filter* filter, tandem_query_hit* hits,
                                size_t capacity, size_t* count, tandem_error* error) {
  return guarded(error, [&] {
    const collision::SceneQuery& q = required(query, "query").query;
    const collision::Shape moved = shape_of(required(shape, "shape"));
    const pbd::Pose from = from_c(required(start, "start"));
    std::vector<collision::CastHit> found;
    if (capacity > 1) {
      q.shape_cast_all(moved, from, from_c(displacement), found, filter_of(filter));
    } else {
      found = list_of(q.shape_cast(moved, from, from_c(displacement), filter_of(filter)));
    }
    write(found, hits, capacity, count);
  });
}

tandem_result tandem_query_closest(const tandem_query* query, const tandem_shape* shape,
                                   const tandem_pose* pose, double max_distance,
                                   const tandem_query_filter* filter, tandem_query_hit* hits,
                                   size_t capacity, size_t* count, tandem_error* error) {
  return guarded(error, [&] {
    const collision::SceneQuery& q = required(query, "query").query;
    const pbd::Pose at = from_c(required(pose, "pose"));
    std::vector<collision::ClosestHit> found;
    // A query for all hits needs a shape: the smallest valid sphere stands for a point.
    const collision::Shape asked =
        shape != nullptr ? shape_of(*shape) : collision::Shape(collision::Sphere{1e-9});
    if (capacity > 1) {
      q.closest_all(asked, at, max_distance, found, filter_of(filter));
    } else if (shape != nullptr) {
      found = list_of(q.closest(asked, at, max_distance, filter_of(filter)));
    } else {
      found = list_of(q.closest(at.position, max_distance, filter_of(filter)));
    }
    write(found, hits, capacity, count);
  });
}

tandem_result tandem_query_overlap(const tandem_query* query, const tandem_shape* shape,
                                   const tandem_pose* pose, const tandem_query_filter* filter,
                                   tandem_collider* colliders, size_t capacity, size_t* count,
                                   tandem_error* error) {
  return guarded(error, [&] {
    const collision::SceneQuery& q = required(query, "query").query;
    const collision::Shape asked = shape_of(required(shape, "shape"));
    const pbd::Pose at = from_c(required(pose, "pose"));
    std::vector<collision::ColliderId> found;
    if (capacity > 0) {
      q.overlap(asked, at, found, filter_of(filter));
    } else if (q.overlaps(asked, at, filter_of(filter))) {
      found.emplace_back();
    }
    write(found, colliders, capacity, count);
  });
}
