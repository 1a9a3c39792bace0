// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "sphere_surface.h"

#include <cmath>

#include "mesh_manifold.h"
#include "sphere_contact.h"
#include "tandem/collision/height_field.h"

namespace tandem::collision {
namespace {

/// m: a centre nearer than this to a point has no direction from it.
constexpr double kOnSurface = 1e-7;
/// m by which a point may lie beside a triangle and still count as over it.
constexpr double kOver = 1e-6;
/// Squares are compared first, with room for their rounding.
constexpr double kRounding = 1.0 + 1e-12;

/// Adds the triangle, where it is near enough.
template <class Surface>
void look_at(const Surface& surface, std::uint32_t triangle, const Vec3& centre, double radius,
             double limit, std::span<const PatchTrace> previous, std::vector<SphereTouch>& near) {
  const TriangleMesh::Triangle corners = surface.corners(triangle);
  const Vec3& p = surface.vertex(corners[0]);
  const Vec3& front = surface.normal(triangle);
  const double height = front.dot(centre - p);
  const double size = 2.0 * radius;
  if (height >= limit) return;
  if (height < 0.0 && (height < -size || !was_touched(previous, front))) return;
  const Vec3& q = surface.vertex(corners[1]);
  const Vec3& r = surface.vertex(corners[2]);
  for (int k = 0; k < 3; ++k) {
    const double high = centre[k] + limit;
    const double low = centre[k] - limit;
    if (p[k] > high && q[k] > high && r[k] > high) return;
    if (p[k] < low && q[k] < low && r[k] < low) return;
  }
  int region = 0;
  const Vec3 nearest = nearest_on_triangle(centre, p, q, r, region);
  SphereTouch touch{-front, height, 0.0, triangle, 0, false};
  if (region != 3) {
    const Vec3 d = nearest - centre;
    const bool over = (d + height * front).squaredNorm() < kOver * kOver;
    if (!over) {
      const double distance2 = d.squaredNorm();
      if (height < 0.0 || distance2 > kRounding * (limit * limit)) return;
      touch.distance = std::sqrt(distance2);
      if (touch.distance >= limit || touch.distance < kOnSurface) return;
      if (height <= kIsFront * touch.distance) {
        if (height <= kRegionSlop * touch.distance) return;
        touch.normal = d / touch.distance;
        touch.beside = true;
      }
    }
  }
  const bool known = std::any_of(previous.begin(), previous.end(), [&](const PatchTrace& trace) {
    return trace.normal_l.dot(touch.normal) > kIsFront;
  });
  touch.rank = (touch.distance - radius) - (known ? 1e-3 * size : 0.0);
  near.push_back(touch);
}

}  // namespace

template <class Surface>
void touch_surface(const Vec3& centre, double radius, double margin, const Surface& surface,
                   std::span<const PatchTrace> previous, TriangleList& list,
                   SphereScratch& scratch) {
  const double limit = margin + radius;
  find_triangles(surface, {centre - Vec3::Constant(limit), centre + Vec3::Constant(limit)}, list);
  std::vector<SphereTouch>& near = scratch.near;
  std::vector<SphereTouch>& touches = scratch.touches;
  near.clear();
  touches.clear();
  for (const std::uint32_t triangle : list.triangles) {
    look_at(surface, triangle, centre, radius, limit, previous, near);
  }
  std::sort(near.begin(), near.end(), [](const SphereTouch& l, const SphereTouch& r) {
    return l.rank != r.rank ? l.rank < r.rank : l.triangle < r.triangle;
  });
  for (SphereTouch& touch : near) {
    // Nearer ones of about the same normal stand for it. Regions are looked at last: it is dear.
    const bool taken = std::any_of(touches.begin(), touches.end(), [&](const SphereTouch& t) {
      return t.normal.dot(touch.normal) >= kSameCluster;
    });
    if (taken) continue;
    if (touch.beside && !normal_allowed(surface, touch.triangle, -touch.normal)) continue;
    const PatchTrace* before = match(touch.normal, previous, touches);
    touch.cluster = before != nullptr ? before->cluster : free_number(previous, touches);
    touches.push_back(touch);
  }
  std::sort(touches.begin(), touches.end(),
            [](const SphereTouch& l, const SphereTouch& r) { return l.cluster < r.cluster; });
}

template void touch_surface(const Vec3&, double, double, const TriangleMesh&,
                            std::span<const PatchTrace>, TriangleList&, SphereScratch&);
template void touch_surface(const Vec3&, double, double, const HeightField&,
                            std::span<const PatchTrace>, TriangleList&, SphereScratch&);

}  // namespace tandem::collision
