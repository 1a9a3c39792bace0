// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "convex_query.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "axis_rules.h"
#include "box_box.h"
#include "fcl_bridge.h"
#include "meeting.h"

namespace tandem::collision {
namespace {

void reduce_like_before(RawManifold& manifold, double size, const Vec3& weight,
                        const PairCache& cache) {
  static constexpr std::array<std::uint32_t, 4> kNone{};
  const ContactPatch* before = cache.patches;
  const double slop = 1e-3 * size;
  const int count = reduce(manifold.points.data(), manifold.count, manifold.normal, slop, weight,
                           before != nullptr ? before->features.data() : kNone.data(),
                           before != nullptr ? before->count : 0);
  manifold.left_out = least_left_out(manifold.points.data(), count, manifold.count, slop);
  manifold.count = count;
}

/// Whether the library's direction is better than BoxPair's. False if the boxes pass each other in
/// the one, as they then do not meet in the other.
bool is_better(const ContactAxis& found, const ContactAxis& now, const Reach& reach, double size) {
  const bool face = now.owner != FaceOwner::None;
  const double tolerance = kFaceShare * std::max(0.0, -found.separation) + kFaceSize * size;
  const auto closes = [&](const ContactAxis& axis) {
    return -axis.normal.dot(reach.way) > axis.separation;
  };
  return found.separation > now.separation + (face ? tolerance : 1e-9) &&
         !(closes(found) && !closes(now));
}

/// Boxes by the directions of BoxPair. For a pair without old contacts the library decides the
/// direction, unless a face separates (nearly) as well.
/// @return displacement of b for that, m
Vec3 query_boxes(const QueryPair& pair, const Reach& reach, PairCache& cache, RawManifold& out) {
  const Collider& a = *pair.a;
  const Collider& b = *pair.b;
  const BoxPose pose_a{a.rotation, std::get<Box>(a.def.shape).half_extents};
  const BoxPose pose_b{b.rotation, std::get<Box>(b.def.shape).half_extents};
  const Vec3 between = b.position - a.position;
  const auto approach = [&](const BoxPair& boxes) {
    const BoxAxis axis = boxes.best(cache.axis, reach.margin);
    return Approach{boxes.normal(axis), axis.separation};
  };
  const BoxPair now(pose_a, pose_b, between);
  BoxAxis axis = now.best(cache.axis, reach.margin);
  if (axis.separation >= reach.margin) {
    cache.axis = axis.id;
    return Vec3::Zero();
  }
  Vec3 moved = Vec3::Zero();
  const double near = kMet * std::min(a.size, b.size);
  if (axis.separation > near) {
    moved =
        reach.way *
        share_to_meeting(reach.way, near, {now.normal(axis), axis.separation}, [&](double share) {
          return approach({pose_a, pose_b, between + share * reach.way});
        });
  }
  std::optional<BoxPair> there;
  if (!moved.isZero(0.0))
    axis = there.emplace(pose_a, pose_b, between + moved).best(cache.axis, reach.margin);
  const BoxPair& boxes = there ? *there : now;
  cache.axis = axis.id;
  ContactAxis direction{boxes.normal(axis), axis.separation,
                        axis.id < 3   ? FaceOwner::A
                        : axis.id < 6 ? FaceOwner::B
                                      : FaceOwner::None};
  if (cache.patches == nullptr) {
    const ConvexCore core_a = a.core(a.position);
    const ConvexCore core_b = b.core(a.position - moved);
    const Direction found = query_direction(core_a, core_b, reach.margin);
    if (found.status == Direction::Status::Apart) return moved;
    if (found.status == Direction::Status::Found) {
      const ContactAxis other{found.normal, separation(core_a, core_b, found.normal),
                              FaceOwner::None};
      if (is_better(other, direction, reach, std::min(a.size, b.size))) direction = other;
    }
  }
  if (direction.owner != FaceOwner::None) {
    out.normal = direction.normal;
    out.owner = direction.owner;
    if (axis.separation > 0.0 && !boxes.will_meet(axis, direction.normal, reach.sweep))
      return moved;
    boxes.face_points(axis, reach.margin, out);
    if (out.count > 0) return moved;
  }
  out = build_manifold(a.core(a.position), b.core(a.position - moved), direction, reach);
  return moved;
}

/// Any two convex shapes. @return displacement of b for that, m
Vec3 query_cores(const QueryPair& pair, const Reach& reach, const PairCache& cache,
                 std::size_t& queries, RawManifold& out) {
  const Vec3& origin = pair.a->position;
  const ConvexCore a = pair.a->core(origin);
  const ConvexCore now = pair.b->core(origin);
  Direction direction = query_direction(a, now, reach.margin);
  Vec3 moved = until_meeting(a, now, reach.way, reach.margin, direction, queries);
  if (direction.status == Direction::Status::Apart) return moved;
  Vec3 before;
  if (cache.patches != nullptr) {
    const ContactPatch& patch = *cache.patches;
    before = pbd::rotate((patch.in_a ? pair.a : pair.b)->body.orientation, patch.normal_l);
  }
  const Vec3* hint = cache.patches != nullptr ? &before : nullptr;
  const ConvexCore b = moved_by(now, moved);
  const FaceOwner ground = pair.a->dynamic == pair.b->dynamic ? FaceOwner::None
                           : pair.a->dynamic                  ? FaceOwner::B
                                                              : FaceOwner::A;
  out = build_manifold(a, b, choose_axis(a, b, direction, hint, ground), reach);
  return moved;
}

}  // namespace

std::size_t query_convex(const QueryPair& pair, const Reach& reach, PairCache& cache,
                         RawManifold& out) {
  const Vec3& origin = pair.a->position;
  if (pair.b->is_half_space()) {
    const Vec3 n = pair.b->plane_normal();
    const double offset =
        std::get<HalfSpace>(pair.b->def.shape).offset + n.dot(pair.b->position - origin);
    out = half_space_manifold(pair.a->core(origin), n, offset, reach.margin);
    reduce_like_before(out, pair.a->size, reach.weight, cache);
    return 1;
  }
  std::size_t queries = 1;
  const bool boxes = pair.a->kind == Kind::Box && pair.b->kind == Kind::Box;
  const Vec3 moved =
      boxes ? query_boxes(pair, reach, cache, out) : query_cores(pair, reach, cache, queries, out);
  for (int i = 0; i < out.count; ++i) out.points[i].on_b -= moved;
  reduce_like_before(out, std::min(pair.a->size, pair.b->size), reach.weight, cache);
  return queries;
}

}  // namespace tandem::collision
