// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "core_cast.h"

#include <algorithm>
#include <cmath>

#include "sphere_contact.h"

namespace tandem::collision {
namespace {

constexpr int kMaxSteps = 32;
/// Share by which triangles are enlarged, so that a path through an edge hits one.
constexpr double kSeam = 1e-6;

/// Share of the path at which a plane at distance `start` first, and `end` at the end, is `radius`
/// away.
double stop_before(double start, double end, double radius) {
  return std::max(0.0, (start - std::min(radius, 0.5 * start)) / (start - end));
}

CoreHit cast_on_convex(const Vec3& from, const Vec3& path, double radius, const Collider& target) {
  double t = 0.0;
  Vec3 normal = Vec3::UnitZ();
  for (int i = 0; i < kMaxSteps; ++i) {
    const SphereContact contact = sphere_contact(from + t * path, target);
    const double distance = contact.distance - contact.radius_b;
    if (i == 0) {
      if (distance <= 0.0) return {};
      radius = std::min(radius, 0.5 * distance);
    }
    const double gap = distance - radius;
    if (gap <= 1e-3 * radius) return {t, -contact.normal};
    const double approach = contact.normal.dot(path);
    if (approach <= 0.0) return {};
    normal = -contact.normal;
    t += gap / approach;
    if (t >= 1.0) return {};
  }
  return {t, normal};
}

/// Clips the path to the planes of all faces.
CoreHit cast_on_hull(const Vec3& from, const Vec3& path, double radius, const ConvexHull& hull) {
  double enter = -1.0;
  double leave = 1.0;
  CoreHit hit;
  for (const ConvexHull::Face& face : hull.faces()) {
    const double start = face.normal.dot(from) - face.offset;
    const double speed = face.normal.dot(path);
    if (start > 0.0 && speed >= 0.0) return {};
    if (speed == 0.0) continue;
    const double t = -start / speed;
    if (speed > 0.0) {
      leave = std::min(leave, t);
    } else if (t > enter) {
      enter = t;
      hit = {stop_before(start, start + speed, radius), face.normal};
    }
  }
  return enter >= 0.0 && enter <= leave ? hit : CoreHit{};
}

CoreHit cast_on_surface(const Vec3& from, const Vec3& path, double radius, const auto& surface,
                        std::vector<std::uint32_t>& list) {
  const Vec3 to = from + path;
  list.clear();
  surface.query({from.cwiseMin(to), from.cwiseMax(to)}, list);
  CoreHit first;
  for (const std::uint32_t t : list) {
    const auto corners = surface.corners(t);
    const Vec3& a = surface.vertex(corners[0]);
    const Vec3& normal = surface.normal(t);
    const double start = normal.dot(from - a);
    const double end = normal.dot(to - a);
    if (start <= 0.0 || end > 0.0) continue;
    const Vec3 p = from + start / (start - end) * path;
    bool inside = true;
    for (int k = 0; k < 3 && inside; ++k) {
      const Vec3& v = surface.vertex(corners[k]);
      const Vec3 edge = surface.vertex(corners[(k + 1) % 3]) - v;
      inside = normal.dot(edge.cross(p - v)) >= -kSeam * edge.squaredNorm();
    }
    if (inside) first.take_first({stop_before(start, end, radius), normal});
  }
  return first;
}

}  // namespace

Vec3 placed_core_centre(const Collider& c, const pbd::Pose& body) {
  Vec3 middle = Vec3::Zero();
  if (const auto* hull = std::get_if<Hull>(&c.def.shape)) middle = (*hull)->centre();
  return body.to_world(c.def.local.position + c.local_rotation() * middle);
}

CoreHit core_cast(const Vec3& from, const Vec3& to, double radius, const Collider& target,
                  std::vector<std::uint32_t>& list) {
  const Vec3 path = to - from;
  if (has_sphere_contact(target.kind)) return cast_on_convex(from, path, radius, target);
  const Mat3 turn = target.rotation.transpose();
  const Vec3 from_l = turn * (from - target.position);
  const Vec3 path_l = turn * path;
  CoreHit hit;
  if (const auto* hull = std::get_if<Hull>(&target.def.shape)) {
    hit = cast_on_hull(from_l - (*hull)->centre(), path_l, radius, **hull);
  } else if (const auto* field = std::get_if<Field>(&target.def.shape)) {
    hit = cast_on_surface(from_l, path_l, radius, **field, list);
  } else {
    hit = cast_on_surface(from_l, path_l, radius, *std::get<Mesh>(target.def.shape), list);
  }
  hit.normal = target.rotation * hit.normal;
  return hit;
}

}  // namespace tandem::collision
