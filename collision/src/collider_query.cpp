// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "collider_query.h"

#include <algorithm>
#include <cmath>

#include "box_sweep.h"
#include "mesh_manifold.h"
#include "ray_shapes.h"

namespace tandem::collision {
namespace {

/// m, and share of the sizes: shapes this near share a point.
constexpr double kTouch = 1e-12;

MeshPose mesh_pose(const Collider& c, const Vec3& origin) {
  return {c.rotation, c.position - origin};
}

const TriangleMesh& mesh_of(const Collider& c) { return *std::get<Mesh>(c.def.shape); }

/// Calls visit(surface) with the TriangleMesh or HeightField that the collider is.
auto with_surface(const Collider& c, auto&& visit) {
  if (const auto* field = std::get_if<Field>(&c.def.shape)) return visit(**field);
  return visit(mesh_of(c));
}

/// Bounds along the axes of a rotated frame.
Aabb bounds_in(const ConvexCore& core, const MeshPose& frame) {
  Aabb box;
  for (int k = 0; k < 3; ++k) {
    const Vec3 axis = frame.rotation.col(k);
    const double shift = axis.dot(frame.translation);
    box.min[k] = -core.reach(-axis) - core.radius - shift;
    box.max[k] = core.reach(axis) + core.radius - shift;
  }
  return box;
}

/// Calls visit(core, triangle) for the convex pieces of the collider. Of many pieces, only those
/// whose boxes have a finite rank(sweep, box), where the sweep is that of the probe in their frame.
template <class Rank, class Visit>
void for_pieces(const Collider& c, const ConvexCore& probe, const Vec3& origin,
                const Vec3& direction, Rank&& rank, Visit&& visit) {
  if (c.is_surface()) {
    const MeshPose pose = mesh_pose(c, origin);
    const Aabb box = bounds_in(probe, pose);
    const BoxSweep sweep(box, pose.rotation.transpose() * direction);
    with_surface(c, [&](const auto& surface) {
      surface.walk([&](const Aabb& node) { return rank(sweep, box, node); },
                   [&](std::uint32_t t) { visit(triangle_core(surface, t, pose), t); });
    });
  } else {
    visit(c.core(origin), TriangleMesh::kNone);
  }
}

/// Smaller value, or equal value and lower index: results must not depend on the order.
bool better_triangle(double value, std::uint32_t triangle, double best,
                     std::uint32_t best_triangle) {
  return value != best ? value < best : triangle < best_triangle;
}

/// Proximity as seen from the collider (b). Fronts lead out of a mesh, even if the back is nearer.
SurfaceHit seen(Proximity at, const ConvexCore& probe, const ConvexCore& piece,
                std::uint32_t triangle, MeshSides sides) {
  if (triangle != TriangleMesh::kNone && at.gap < 0.0 && sides == MeshSides::Front &&
      at.normal.dot(piece.front) > 0.0) {
    at.normal = -piece.front;
    at.gap = separation(probe, piece, at.normal) - probe.radius;
    at.on_a = probe.support(at.normal) + probe.radius * at.normal;
    at.on_b = at.on_a + at.gap * at.normal;
  }
  return {.distance = std::max(0.0, at.gap),
          .depth = std::max(0.0, -at.gap),
          .normal = -at.normal,
          .point = at.on_b,
          .on_probe = at.on_a,
          .triangle = triangle};
}

struct Plane {
  Vec3 normal;
  double offset;  ///< m, relative to the query's origin
};

Plane plane_of(const Collider& c, const Vec3& origin) {
  const Vec3 n = c.plane_normal();
  return {n, std::get<HalfSpace>(c.def.shape).offset + n.dot(c.position - origin)};
}

/// The probe against a plane, at rest.
SurfaceHit above_plane(const Plane& plane, const ConvexCore& probe) {
  const Vec3 lowest = probe.support(-plane.normal) - probe.radius * plane.normal;
  const double gap = -probe.reach(-plane.normal) - probe.radius - plane.offset;
  return {.distance = std::max(0.0, gap),
          .depth = std::max(0.0, -gap),
          .normal = plane.normal,
          .point = lowest - gap * plane.normal,
          .on_probe = lowest};
}

bool ray_surface(const auto& surface, const MeshPose& pose, const Vec3& direction, double limit,
                 MeshSides sides, SurfaceHit& out) {
  const Vec3 start = -(pose.rotation.transpose() * pose.translation);
  const Vec3 d = pose.rotation.transpose() * direction;
  const BoxSweep sweep({start, start}, d);
  double best = limit;
  out.triangle = TriangleMesh::kNone;
  surface.walk([&](const Aabb& box) { return sweep.rank(box, best); },
               [&](std::uint32_t t) {
                 const Vec3& front = surface.normal(t);
                 const double facing = d.dot(front);
                 if (sides == MeshSides::Front && facing >= 0.0) return;
                 const TriangleMesh::Triangle ids = surface.corners(t);
                 std::array<Vec3, 3> corners;
                 for (int k = 0; k < 3; ++k) corners[k] = surface.vertex(ids[k]) - start;
                 double distance = 0.0;
                 if (!ray_triangle(corners, front, d, best, distance)) return;
                 if (!better_triangle(distance, t, best, out.triangle)) return;
                 best = distance;
                 out.triangle = t;
                 out.normal = pose.rotation * (facing > 0.0 ? Vec3(-front) : front);
               });
  out.distance = best;
  out.depth = 0.0;
  out.point = best * direction;
  return out.triangle != TriangleMesh::kNone;
}

bool ray_mesh(const Collider& c, const Vec3& origin, const Vec3& direction, double limit,
              MeshSides sides, SurfaceHit& out) {
  return with_surface(c, [&](const auto& surface) {
    return ray_surface(surface, mesh_pose(c, origin), direction, limit, sides, out);
  });
}

/// Whether a closed mesh contains the point: the first face on a ray from it shows its back.
bool inside_mesh(const Collider& c, const Vec3& point, const Vec3& origin) {
  if (!mesh_of(c).closed()) return false;
  const Vec3 direction = Vec3(0.5377, 0.3141, 0.7824).normalized();  // parallel to no likely edge
  SurfaceHit hit;
  const double far = 2.0 * c.reach + (point + origin - c.position).norm();
  if (!ray_mesh(c, origin + point, direction, far, MeshSides::Both, hit)) return false;
  return direction.dot(c.rotation * mesh_of(c).normal(hit.triangle)) > 0.0;
}

bool touching(const ConvexCore& a, const ConvexCore& b) {
  const CoreDistance d = core_distance(a, b);
  const double radii = a.radius + b.radius;
  return !d.apart || d.distance - radii <= kTouch * (1.0 + d.size + radii);
}

bool mesh_below_plane(const Collider& c, const Collider& plane_collider) {
  const Plane plane = plane_of(plane_collider, c.position);
  const Vec3 n_l = c.rotation.transpose() * plane.normal;
  const auto vertices = mesh_of(c).vertices();
  return std::any_of(vertices.begin(), vertices.end(),
                     [&](const Vec3& v) { return n_l.dot(v) <= plane.offset; });
}

}  // namespace

Aabb bounds_of(const ConvexCore& core) { return bounds_in(core, {}); }

bool ray_collider(const Collider& c, const Vec3& origin, const Vec3& direction, double limit,
                  MeshSides sides, SurfaceHit& out) {
  if (c.is_surface()) return ray_mesh(c, origin, direction, limit, sides, out);
  out = {};
  if (c.is_half_space()) {
    const Plane plane = plane_of(c, origin);
    out.normal = plane.normal;
    if (plane.offset >= 0.0) {
      out.depth = plane.offset;
      return true;
    }
    const double closing = -direction.dot(plane.normal);
    if (closing <= 0.0 || -plane.offset > closing * limit) return false;
    out.distance = -plane.offset / closing;
    out.point = out.distance * direction;
    return true;
  }
  const ConvexCore core = c.core(origin);
  switch (ray_core(core, direction, limit, out.distance, out.normal)) {
    case RayResult::Miss:
      return false;
    case RayResult::Hit:
      out.point = out.distance * direction;
      return true;
    case RayResult::Inside:
      break;
  }
  const Proximity at = proximity(point_core(Vec3::Zero()), core);
  out.distance = 0.0;
  out.depth = std::max(0.0, -at.gap);
  out.normal = -at.normal;
  return true;
}

bool cast_collider(const Collider& c, const ConvexCore& probe, const Vec3& origin,
                   const Vec3& direction, double limit, MeshSides sides, SurfaceHit& out) {
  if (c.is_half_space()) {
    out = above_plane(plane_of(c, origin), probe);
    if (out.depth > 0.0) {
      out.distance = 0.0;
      return true;
    }
    const double closing = -direction.dot(out.normal);
    if (closing <= 0.0 || out.distance > closing * limit) return false;
    out.distance /= closing;
    out.on_probe += out.distance * direction;
    out.point = out.on_probe;
    return true;
  }
  bool found = false;
  double best = limit;
  const auto rank = [&](const BoxSweep& sweep, const Aabb&, const Aabb& box) {
    return sweep.rank(box, best);
  };
  for_pieces(c, probe, origin, direction, rank, [&](const ConvexCore& piece, std::uint32_t t) {
    const bool back =
        t != TriangleMesh::kNone && sides == MeshSides::Front && direction.dot(piece.front) >= 0.0;
    double travel = 0.0;
    Proximity at;
    // Backs stop nothing, but an overlap at the start counts from either side.
    if (!cast_core(probe, piece, direction, back ? 0.0 : best, travel, at)) return;
    if (back && !(at.gap < 0.0)) return;
    const SurfaceHit hit = seen(at, probe, piece, t, sides);
    const bool deeper = found && travel == 0.0 && best == 0.0
                            ? better_triangle(-hit.depth, t, -out.depth, out.triangle)
                            : !found || better_triangle(travel, t, best, out.triangle);
    if (!deeper) return;
    found = true;
    best = travel;
    out = hit;
    out.distance = travel;
  });
  return found;
}

bool overlaps_collider(const Collider& c, const ConvexCore& probe, const Vec3& origin) {
  if (c.is_half_space()) {
    const Plane plane = plane_of(c, origin);
    return -probe.reach(-plane.normal) - probe.radius <= plane.offset;
  }
  bool found = false;
  const auto rank = [&](const BoxSweep&, const Aabb& own, const Aabb& box) {
    return !found && own.overlaps(box) ? 0.0 : HUGE_VAL;
  };
  for_pieces(c, probe, origin, Vec3::Zero(), rank, [&](const ConvexCore& piece, std::uint32_t) {
    found = found || touching(probe, piece);
  });
  return found || (c.is_mesh() && inside_mesh(c, probe.centre, origin));
}

bool nearest_on_collider(const Collider& c, const ConvexCore& probe, const Vec3& origin,
                         double limit, SurfaceHit& out) {
  if (c.is_half_space()) {
    out = above_plane(plane_of(c, origin), probe);
    return out.distance <= limit;
  }
  bool found = false;
  double best = limit;  // of distance - depth
  const auto rank = [&](const BoxSweep&, const Aabb& own, const Aabb& box) {
    const Vec3 between = (box.min - own.max).cwiseMax(own.min - box.max).cwiseMax(Vec3::Zero());
    const double distance = between.norm() * (1.0 - 1e-12);
    return distance <= best ? distance : best < 0.0 && distance == 0.0 ? 0.0 : HUGE_VAL;
  };
  for_pieces(c, probe, origin, Vec3::Zero(), rank, [&](const ConvexCore& piece, std::uint32_t t) {
    const Proximity at = proximity(probe, piece);
    if (at.gap > limit) return;
    const SurfaceHit hit = seen(at, probe, piece, t, MeshSides::Both);
    const double value = hit.distance - hit.depth;
    if (found && !better_triangle(value, t, best, out.triangle)) return;
    found = true;
    best = value;
    out = hit;
  });
  return found;
}

bool colliders_overlap(const Collider& a, const Collider& b) {
  if (a.is_convex()) return overlaps_collider(b, a.core(a.position), a.position);
  if (b.is_convex()) return overlaps_collider(a, b.core(b.position), b.position);
  if (a.is_mesh() && b.is_half_space()) return mesh_below_plane(a, b);
  if (a.is_half_space() && b.is_mesh()) return mesh_below_plane(b, a);
  return false;
}

}  // namespace tandem::collision
