// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "sphere_surface.h"

#include <cmath>

#include "meeting.h"
#include "mesh_manifold.h"
#include "sphere_contact.h"
#include "tandem/collision/height_field.h"

namespace tandem::collision {
namespace {

/// m: a centre nearer than this to a point has no direction from it.
constexpr double kOnSurface = 1e-7;

/// A triangle as a sphere needs it.
struct Facet {
  Vec3 p, q, r, front;

  /// Position of a sphere's centre: on the front's side, or over the triangle.
  /// @return whether there may be a contact
  bool touch(const Vec3& centre, SphereTouch& touch) const {
    const double height = front.dot(centre - p);
    int region = 0;
    touch.point = nearest_on_triangle(centre, p, q, r, region);
    touch.normal = -front;
    touch.distance = height;
    touch.beside = false;
    const Vec3 d = touch.point - centre;
    if (region == 3 || (d + height * front).squaredNorm() < kOver * kOver) return true;
    touch.distance = d.norm();
    if (height < 0.0 || touch.distance < kOnSurface) return false;
    if (height > kSameNormal * touch.distance) return true;
    if (height <= kRegionSlop * touch.distance) return false;
    touch.normal = d / touch.distance;
    touch.beside = true;
    return true;
  }
};

/// Input of touch_surface().
struct Ball {
  Vec3 centre;
  double radius;
  double limit;  ///< m, largest distance from the centre
  Vec3 sweep;
};

/// Whether the triangle is near enough for its distance to matter.
[[gnu::always_inline]] inline bool in_reach(const Vec3& p, const Vec3& q, const Vec3& r,
                                            const Vec3& front, const Ball& ball,
                                            std::span<const PatchTrace> previous) {
  const double height = front.dot(ball.centre - p);
  if (height >= ball.limit) return false;
  if (height < 0.0 && (height < -2.0 * ball.radius || !was_touched(previous, front))) return false;
  for (int k = 0; k < 3; ++k) {
    const double high = ball.centre[k] + ball.limit;
    const double low = ball.centre[k] - ball.limit;
    if (p[k] > high && q[k] > high && r[k] > high) return false;
    if (p[k] < low && q[k] < low && r[k] < low) return false;
  }
  return true;
}

/// Where the ball will meet the triangle. On a rising surface other triangles stop the ball first,
/// and its path may end over this one.
/// @return whether there may be a contact
bool meet(const Facet& facet, const Ball& ball, SphereTouch& touch) {
  const double size = 2.0 * ball.radius;
  const double height = facet.front.dot(ball.centre - facet.p);
  const auto spans = [&](const Vec3& point) {
    return collision::spans(facet.front, facet.p, facet.q, facet.r, point, 0.0);
  };
  if (height - ball.radius >= -kMet * size && !spans(ball.centre) &&
      spans(ball.centre - ball.sweep)) {
    touch.normal = -facet.front;
    touch.distance = height;
    touch.point = ball.centre - height * facet.front;
    touch.beside = false;
    return true;
  }
  if (!facet.touch(ball.centre, touch) || touch.distance >= ball.limit) return false;
  bool met = true;
  const auto look = [&](double share) {
    met = facet.touch(ball.centre - share * ball.sweep, touch);
    return Approach{touch.normal, met ? touch.distance - ball.radius : HUGE_VAL};
  };
  const Approach now{touch.normal, touch.distance - ball.radius};
  if (share_to_meeting(ball.sweep, kMet * size, now, look) > 0.0) {
    touch.distance = touch.normal.dot(touch.point - ball.centre);
  }
  return met;
}

/// Adds the triangle if it is near enough.
template <class Surface>
void look_at(const Surface& surface, std::uint32_t triangle, const Ball& ball,
             std::span<const PatchTrace> previous, std::vector<SphereTouch>& near) {
  const TriangleMesh::Triangle corners = surface.corners(triangle);
  const Vec3& p = surface.vertex(corners[0]);
  const Vec3& q = surface.vertex(corners[1]);
  const Vec3& r = surface.vertex(corners[2]);
  const Vec3& front = surface.normal(triangle);
  if (!in_reach(p, q, r, front, ball, previous)) return;
  SphereTouch touch{.triangle = triangle};
  if (!meet({p, q, r, front}, ball, touch)) return;
  const bool known = std::any_of(previous.begin(), previous.end(), [&](const PatchTrace& trace) {
    return trace.normal_l.dot(touch.normal) > kSameNormal;
  });
  touch.rank = (touch.distance - ball.radius) - (known ? 2e-3 * ball.radius : 0.0);
  near.push_back(touch);
}

}  // namespace

template <class Surface>
void touch_surface(const Vec3& centre, double radius, double margin, const Vec3& sweep,
                   const Surface& surface, std::span<const PatchTrace> previous, TriangleList& list,
                   SphereScratch& scratch) {
  const double limit = margin + radius;
  find_triangles(surface, {centre - Vec3::Constant(limit), centre + Vec3::Constant(limit)}, list);
  std::vector<SphereTouch>& near = scratch.near;
  std::vector<SphereTouch>& touches = scratch.touches;
  near.clear();
  touches.clear();
  const Ball ball{centre, radius, limit, sweep};
  for (const std::uint32_t triangle : list.triangles) {
    look_at(surface, triangle, ball, previous, near);
  }
  std::sort(near.begin(), near.end(), [](const SphereTouch& l, const SphereTouch& r) {
    return l.rank != r.rank ? l.rank < r.rank : l.triangle < r.triangle;
  });
  for (SphereTouch& touch : near) {
    // A nearer one of the same normal replaces it. Regions are tested last, being expensive.
    const bool taken = std::any_of(touches.begin(), touches.end(), [&](const SphereTouch& t) {
      return t.normal.dot(touch.normal) >= kSameNormal;
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

template void touch_surface(const Vec3&, double, double, const Vec3&, const TriangleMesh&,
                            std::span<const PatchTrace>, TriangleList&, SphereScratch&);
template void touch_surface(const Vec3&, double, double, const Vec3&, const HeightField&,
                            std::span<const PatchTrace>, TriangleList&, SphereScratch&);

}  // namespace tandem::collision
