// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "scene_view/extent.h"

#include <limits>
#include <variant>

#include "tandem/collision/convex_hull.h"
#include "tandem/collision/height_field.h"

namespace tandem::demos {

namespace {

using collision::Aabb;
using pbd::Vec3;

struct Extent {
  const pbd::Pose& pose;

  Aabb about(const Vec3& centre, const Vec3& half) const {
    return {Vec3(centre - half), Vec3(centre + half)};
  }
  Vec3 axis() const { return pose.orientation * Vec3::UnitZ(); }
  /// Half extents of a disc of that radius across axis().
  Vec3 disc(double radius) const {
    return radius * (Vec3::Ones() - axis().cwiseAbs2()).cwiseMax(0.0).cwiseSqrt();
  }
  void take(Aabb& box, const Vec3& point_l) const {
    const Vec3 point = pose.to_world(point_l);
    box = box.merged({point, point});
  }

  Aabb operator()(const collision::Sphere& s) const {
    return about(pose.position, Vec3::Constant(s.radius));
  }
  Aabb operator()(const collision::Capsule& s) const {
    return about(pose.position, s.half_height * axis().cwiseAbs() + Vec3::Constant(s.radius));
  }
  Aabb operator()(const collision::Box& s) const {
    return about(pose.position, pose.orientation.toRotationMatrix().cwiseAbs() * s.half_extents);
  }
  Aabb operator()(const collision::HalfSpace&) const { return empty_box(); }
  Aabb operator()(const collision::Cylinder& s) const {
    return about(pose.position, s.half_height * axis().cwiseAbs() + disc(s.radius));
  }
  Aabb operator()(const collision::Cone& s) const {
    const Vec3 apex = pose.position + s.half_height * axis();
    return about(pose.position - s.half_height * axis(), disc(s.radius)).merged({apex, apex});
  }
  Aabb operator()(const collision::Mesh& s) const {
    Aabb box = empty_box();
    for (const Vec3& vertex : s->vertices()) take(box, vertex);
    return box;
  }
  Aabb operator()(const collision::Hull& s) const {
    Aabb box = empty_box();
    for (const Vec3& arm : s->arms()) take(box, s->centre() + arm);
    return box;
  }
  Aabb operator()(const collision::Field& s) const {
    const Aabb& own = s->bounds();
    Aabb box = empty_box();
    for (int corner = 0; corner < 8; ++corner) {
      Vec3 point;
      for (int i = 0; i < 3; ++i) point[i] = (corner >> i & 1) != 0 ? own.max[i] : own.min[i];
      take(box, point);
    }
    return box;
  }
};

}  // namespace

Aabb empty_box() {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  return {Vec3::Constant(kFar), Vec3::Constant(-kFar)};
}

bool is_empty(const Aabb& box) { return !(box.min.x() <= box.max.x()); }

Aabb extent(const collision::Shape& shape, const pbd::Pose& pose) {
  return std::visit(Extent{pose}, shape);
}

}  // namespace tandem::demos
