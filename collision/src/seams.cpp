// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "seams.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <tuple>
#include <utility>

#include "collider_query.h"
#include "sphere_contact.h"
#include "tandem/collision/height_field.h"

namespace tandem::collision {
namespace {

/// Share of the part's size by which the outer test point is outside: more than a part sinks into
/// its support, less than a tile is wide.
constexpr double kOut = 0.05;
/// Share of the part's size by which tiles of one floor may differ in height.
constexpr double kFlush = 1e-3;
/// Share of the distance to its own collider by which another one must be nearer to a point: above
/// rounding, so that of two coplanar, overlapping colliders one keeps its points.
constexpr double kNearer = 1.0 - 1e-8;
/// m: how much longer the path to a face may be than its height, for a point above the face.
constexpr double kPlumb = 1e-11;
/// Parts per chunk of a worker.
constexpr std::size_t kPartGrain = 16;

/// The point of a collider's surface nearest to a given one.
struct Foot {
  Vec3 out = Vec3::UnitZ();    ///< unit, out of the surface
  double distance = HUGE_VAL;  ///< m, from the surface; negative inside
};

/// For surfaces that are solid behind their triangles: nearest_on_collider() treats both sides
/// alike.
template <class Surface>
Foot foot_on_surface(const Vec3& point, const Collider& c, const Surface& surface, double limit,
                     std::vector<std::uint32_t>& triangles) {
  const Vec3 p = c.rotation.transpose() * (point - c.position);
  triangles.clear();
  surface.query(Aabb{p, p}.expanded(limit), triangles);
  Foot foot;
  for (const std::uint32_t t : triangles) {
    const auto corners = surface.corners(t);
    const auto& a = surface.vertex(corners[0]);
    const auto& front = surface.normal(t);
    const double height = front.dot(p - a);
    if (height < -limit || height >= foot.distance) continue;
    int region = 0;
    const Vec3 out = p - nearest_on_triangle(p, a, surface.vertex(corners[1]),
                                             surface.vertex(corners[2]), region);
    const double distance = out.norm();
    if (distance < std::abs(height) + kPlumb) {
      foot = {front, height};
    } else if (height >= 0.0 && distance < foot.distance) {
      foot = {out / distance, distance};
    }
  }
  foot.out = c.rotation * foot.out;
  return foot;
}

/// The faces decide whether the point is inside: for a point on a face, a search without faces may
/// lead out of the other side of the hull.
Foot foot_on_hull(const Vec3& point, const Collider& c, const ConvexHull& hull, double limit) {
  const Vec3 p = c.rotation.transpose() * (point - c.position) - hull.centre();
  Foot face;
  face.distance = -HUGE_VAL;
  for (const ConvexHull::Face& f : hull.faces()) {
    const double height = f.normal.dot(p) - f.offset;
    if (height > face.distance) face = {f.normal, height};
  }
  face.out = c.rotation * face.out;
  if (face.distance <= kPlumb) return face;
  SurfaceHit hit;
  if (!nearest_on_collider(c, point_core(Vec3::Zero()), point, limit, hit)) return {};
  return {hit.normal, hit.distance};
}

/// @param limit  m: colliders further away may be ignored
Foot foot_on(const Vec3& point, const Collider& c, double limit,
             std::vector<std::uint32_t>& triangles) {
  if (const auto* mesh = std::get_if<Mesh>(&c.def.shape))
    return foot_on_surface(point, c, **mesh, limit, triangles);
  if (const auto* field = std::get_if<Field>(&c.def.shape))
    return foot_on_surface(point, c, **field, limit, triangles);
  if (const auto* hull = std::get_if<Hull>(&c.def.shape))
    return foot_on_hull(point, c, **hull, limit);
  const SphereContact at = sphere_contact(point, c);
  return {-at.normal, at.distance - at.radius_b};
}

/// Whether the triangles at point p reach above a plane through `on_plane`.
template <class Surface>
bool surface_stands_out(const Vec3& p, const Collider& c, const Surface& surface,
                        const Vec3& on_plane, const Vec3& out, double tolerance,
                        std::vector<std::uint32_t>& triangles) {
  const Vec3 p_l = c.rotation.transpose() * (p - c.position);
  const Vec3 plane_l = c.rotation.transpose() * (on_plane - c.position);
  const Vec3 out_l = c.rotation.transpose() * out;
  triangles.clear();
  surface.query(Aabb{p_l, p_l}.expanded(tolerance), triangles);
  return std::any_of(triangles.begin(), triangles.end(), [&](std::uint32_t t) {
    const auto corners = surface.corners(t);
    return std::any_of(corners.begin(), corners.end(), [&](std::uint32_t v) {
      return out_l.dot(surface.vertex(v) - plane_l) > tolerance;
    });
  });
}

/// Whether the collider reaches above the plane through `on_plane` by more than the tolerance; for
/// triangles, those near the point p.
bool stands_out(const Vec3& p, const Collider& c, const Vec3& on_plane, const Vec3& out,
                double tolerance, std::vector<std::uint32_t>& triangles) {
  if (const auto* mesh = std::get_if<Mesh>(&c.def.shape))
    return surface_stands_out(p, c, **mesh, on_plane, out, tolerance, triangles);
  if (const auto* field = std::get_if<Field>(&c.def.shape))
    return surface_stands_out(p, c, **field, on_plane, out, tolerance, triangles);
  if (c.is_half_space()) return true;  // without edges or sides
  const ConvexCore core = c.core(on_plane);
  return core.reach(out) + core.radius > tolerance;
}

/// One point of a contact, as tested.
struct Contact {
  const Collider& part;
  const Collider& fixed;
  Vec3 point;  ///< m, world, on `fixed`
  Vec3 out;    ///< unit, from `fixed` to `part`
};

bool covers(const Collider& cover, const Contact& contact, std::vector<std::uint32_t>& triangles) {
  const double step = kOut * contact.part.size;
  const Vec3 further = contact.point + step * contact.out;
  if (!cover.is_half_space() && !cover.needed.overlaps(Aabb{further, further}.expanded(step)))
    return false;
  const Foot foot = foot_on(further, cover, 2.0 * step, triangles);
  if (!(foot.distance < 2.0 * step)) return false;
  // Points of a curved side are slightly off the surface: their distance is not exactly the step.
  const double own = foot_on(further, contact.fixed, 2.0 * step, triangles).distance;
  if (!(foot.distance < kNearer * own)) return false;
  return !stands_out(contact.point, contact.fixed, further - foot.distance * foot.out, foot.out,
                     kFlush * contact.part.size, triangles);
}

/// Removes the points that one of the neighbours covers. @return whether there were any
bool drop_points(std::span<const Collider> colliders, std::span<const FixedNeighbour> neighbours,
                 const FixedNeighbour& own, pbd::Manifold& m,
                 std::vector<std::uint32_t>& triangles) {
  const Collider& part = colliders[own.part];
  const Collider& fixed = colliders[own.fixed];
  const bool fixed_is_a = fixed.rank.own < part.rank.own;
  const Vec3 out = fixed_is_a ? m.normal : Vec3(-m.normal);
  const double radius = fixed_is_a ? m.radius_a : m.radius_b;
  int kept = 0;
  for (int i = 0; i < m.count; ++i) {
    const pbd::ManifoldPoint& point = m.points[i];
    const Vec3& anchor_l = fixed_is_a ? point.anchor_a_l : point.anchor_b_l;
    const Contact contact{part, fixed, fixed.body.to_world(anchor_l) + radius * out, out};
    const bool covered =
        std::any_of(neighbours.begin(), neighbours.end(), [&](const FixedNeighbour& other) {
          return other.fixed != own.fixed && covers(colliders[other.fixed], contact, triangles);
        });
    if (!covered) m.points[kept++] = point;
  }
  return std::exchange(m.count, kept) != kept;
}

/// End of the neighbours of the same part, from `begin` on.
std::size_t end_of_part(std::span<const FixedNeighbour> neighbours, std::size_t begin) {
  std::size_t end = begin + 1;
  while (end < neighbours.size() && neighbours[end].part == neighbours[begin].part) ++end;
  return end;
}

}  // namespace

void Seams::add(std::span<const FixedNeighbour> neighbours, std::uint32_t shift) {
  for (FixedNeighbour neighbour : neighbours) {
    neighbour.first += shift;
    neighbours_.push_back(neighbour);
  }
}

void Seams::drop_covered(std::span<const Collider> colliders, pbd::Workers& workers,
                         std::vector<pbd::Manifold>& manifolds) {
  const auto by_part = [](const FixedNeighbour& l, const FixedNeighbour& r) {
    return std::tie(l.part, l.fixed) < std::tie(r.part, r.fixed);
  };
  if (!std::is_sorted(neighbours_.begin(), neighbours_.end(), by_part))
    std::sort(neighbours_.begin(), neighbours_.end(), by_part);
  // A part with a single neighbour is on no seam.
  std::size_t kept = 0;
  const std::span<const FixedNeighbour> all = neighbours_;
  for (std::size_t begin = 0, end = 0; begin < all.size(); begin = end) {
    end = end_of_part(all, begin);
    if (end - begin == 1) continue;
    for (std::size_t i = begin; i < end; ++i) neighbours_[kept++] = all[i];
  }
  neighbours_.resize(kept);
  if (neighbours_.empty()) return;

  triangles_.resize(static_cast<std::size_t>(workers.count()));
  std::atomic<bool> empty = false;
  workers.for_chunks(kept, kPartGrain, [&](std::size_t from, std::size_t to, int w) {
    std::vector<std::uint32_t>& triangles = triangles_[static_cast<std::size_t>(w)];
    for (std::size_t i = from; i < to; ++i) {
      FixedNeighbour& own = neighbours_[i];
      std::size_t begin = i;
      while (begin > 0 && neighbours_[begin - 1].part == own.part) --begin;
      const auto around = std::span<const FixedNeighbour>(neighbours_)
                              .subspan(begin, end_of_part(neighbours_, begin) - begin);
      for (std::uint32_t k = own.first; k < own.first + own.count; ++k) {
        if (drop_points(colliders, around, own, manifolds[k], triangles)) own.covered = true;
        if (manifolds[k].count == 0) empty = true;
      }
    }
  });
  if (empty) std::erase_if(manifolds, [](const pbd::Manifold& m) { return m.count == 0; });
}

}  // namespace tandem::collision
