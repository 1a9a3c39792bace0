// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "mesh_manifold.h"

#include <algorithm>
#include <cmath>

#include "meeting.h"
#include "surface_memory.h"
#include "tandem/collision/height_field.h"

namespace tandem::collision {
namespace {

/// A front is preferred within this share of the depth, and of the shape's size.
constexpr double kFrontShare = 0.05;
constexpr double kFrontSize = 1e-3;
/// A deeper front is not the way out: the triangle faces elsewhere.
constexpr double kMaxReprojection = 4.0;
constexpr double kMaxReprojectionSize = 0.05;

bool by_rank(const MeshPoint& l, const MeshPoint& r) {
  if (l.rank != r.rank) return l.rank < r.rank;
  if (l.triangle != r.triangle) return l.triangle < r.triangle;
  return l.point.feature < r.point.feature;
}

/// Whether a point `gap` (m) above the triangle is still over it when it meets its plane. Otherwise
/// it passes beyond a crest, or a neighbouring triangle handles it.
/// @param way  m, remaining motion of the triangle relative to the point in the step
bool stays_over(const ConvexCore& t, const Vec3& point, double gap, const Vec3& way) {
  const double closing = t.front.dot(way);
  if (gap <= 0.0 || closing <= gap) return true;
  const Vec3 there = point - gap / closing * way;
  return spans(t.front, t.corners[0], t.corners[1], t.corners[2], there, kOver);
}

/// Contact across the front: the part of the shape over the triangle only.
/// @param way  m, remaining motion of the triangle relative to the shape in the step
RawManifold front_manifold(const ConvexCore& a, const ConvexCore& t, const Reach& reach,
                           const Vec3& way) {
  const ContactAxis axis = front_axis(a, t);
  RawManifold out;
  out.normal = axis.normal;
  out.owner = axis.owner;
  const CoreFace reference = face_towards(t, t.front);
  BearingFaces faces(a, axis.normal);
  CoreFace incident;
  for (bool beside = false; faces.next(incident); beside = true) {
    const ClippedFace clipped = clip_face(reference, t.front, incident, false);
    for (int i = 0; i < clipped.count; ++i) {
      const Vec3& p = clipped.corners[i].position;
      const double height = t.front.dot(p - t.corners[0]);
      const double gap = height - a.radius;
      if (gap >= reach.margin || (beside && out.has(clipped.corners[i].feature))) continue;
      if (!stays_over(t, p, gap, way)) continue;
      out.add({p, p - height * t.front, gap, clipped.corners[i].feature});
    }
  }
  return out;
}

template <class Surface>
RawManifold triangle_manifold(const ConvexCore& a, const Surface& mesh, std::uint32_t index,
                              const ConvexCore& t, const MeshPose& pose, const Reach& reach,
                              const Vec3& way, const Direction& direction) {
  const ContactAxis front = front_axis(a, t);
  const Vec3 hint = -t.front;
  const ContactAxis axis = choose_axis(a, t, direction, &hint);
  const double cosine = -axis.normal.dot(t.front);
  const double depth = std::max(0.0, -axis.separation);
  const double tolerance = a.radius > 0.0 ? 0.0 : kFrontShare * depth + kFrontSize * a.size;
  const bool is_front = cosine > kSameNormal;
  if (is_front || front.separation >= axis.separation - tolerance) {
    RawManifold flat = front_manifold(a, t, reach, way);
    if (flat.count > 0) return flat;
  }
  const bool allowed = cosine > kRegionSlop &&
                       normal_allowed(mesh, index, -(pose.rotation.transpose() * axis.normal));
  if (allowed) return build_manifold(a, t, axis, reach);
  if (-front.separation <= kMaxReprojection * depth + kMaxReprojectionSize * a.size) {
    return front_manifold(a, t, reach, way);
  }
  return {};
}

/// Points of equal feature are merged: the deepest stays.
void merge_equal(std::vector<RawPoint>& points) {
  std::sort(points.begin(), points.end());
  points.erase(
      std::unique(points.begin(), points.end(),
                  [](const RawPoint& l, const RawPoint& r) { return l.feature == r.feature; }),
      points.end());
}

/// Points on a segment: its two ends, and the deepest if it is between and below them.
void reduce_segment(std::vector<RawPoint>& points, const Vec3& direction, double slop) {
  if (points.size() <= 2) return;
  const auto along = [&](const RawPoint& p) { return direction.dot(p.on_a); };
  std::sort(points.begin(), points.end(), [&](const RawPoint& l, const RawPoint& r) {
    return along(l) != along(r) ? along(l) < along(r) : l.feature < r.feature;
  });
  const auto deepest =
      std::min_element(points.begin(), points.end(),
                       [](const RawPoint& l, const RawPoint& r) { return l.gap < r.gap; });
  std::array<RawPoint, 3> kept{points.front(), points.back(), *deepest};
  const bool between = kept[2].gap < std::min(kept[0].gap, kept[1].gap) - slop;
  points.assign(kept.begin(), kept.begin() + (between ? 3 : 2));
}

void finish_cluster(std::vector<RawPoint>& points, RawManifold& manifold, double size,
                    const Vec3& weight, const PatchTrace* before) {
  merge_equal(points);
  std::array<std::uint32_t, 4> kept{};
  const int kept_count = before != nullptr ? before->count : 0;
  for (int i = 0; i < kept_count; ++i) kept[i] = before->features[i];
  const auto all = static_cast<int>(points.size());
  const double slop = 1e-3 * size;
  const int count =
      reduce(points.data(), all, manifold.normal, slop, weight, kept.data(), kept_count);
  manifold.left_out = least_left_out(points.data(), count, all, slop);
  for (int i = 0; i < count; ++i) manifold.add(points[i]);
}

template <class Surface>
Aabb triangle_bounds(const Surface& mesh, std::uint32_t t) {
  const TriangleMesh::Triangle corners = mesh.corners(t);
  const Vec3& a = mesh.vertex(corners[0]);
  const Vec3& b = mesh.vertex(corners[1]);
  const Vec3& c = mesh.vertex(corners[2]);
  return {a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c)};
}

}  // namespace

template <class Surface>
bool normal_allowed(const Surface& mesh, std::uint32_t triangle, const Vec3& n) {
  const TriangleMesh::Triangle corners = mesh.corners(triangle);
  const auto corner = [&](int k) -> Vec3 { return mesh.vertex(corners[k % 3]); };
  if (n.dot(mesh.normal(triangle)) > 1.0 - 1e-7) return true;
  int foremost = 0;
  for (int k = 1; k < 3; ++k) {
    if (n.dot(corner(k)) > n.dot(corner(foremost))) foremost = k;
  }
  for (const int k : {foremost, (foremost + 2) % 3}) {  // the two edges at that corner
    const Vec3 edge = (corner(k + 1) - corner(k)).normalized();
    if (std::abs(n.dot(edge)) > kRegionSlop) continue;
    const std::uint32_t other = mesh.neighbour(triangle, k);
    if (other == TriangleMesh::kNone) return true;
    // In the neighbour's plane, from the edge into it; there the edge has the opposite direction.
    return n.dot(edge.cross(mesh.normal(other))) <= kRegionSlop;
  }
  const std::uint32_t v = corners[foremost];
  for (const std::uint32_t w : mesh.ring(v)) {
    const Vec3 along = mesh.vertex(w) - mesh.vertex(v);
    if (n.dot(along) > kRegionSlop * along.norm()) return false;
  }
  return true;
}

/// Bounds of a shape in the mesh frame, including its range.
static Aabb bounds_in_mesh(const ConvexCore& a, const MeshPose& pose, const Reach& reach) {
  const double round = a.radius + reach.margin;
  const Vec3 middle = pose.rotation.transpose() * -pose.translation;
  Aabb bounds;
  for (int i = 0; i < 3; ++i) {
    const Vec3 axis = pose.rotation.col(i);
    bounds.min[i] = middle[i] - a.reach(-axis) - round;
    bounds.max[i] = middle[i] + a.reach(axis) + round;
  }
  return bounds;
}

/// The contacts of a shape with one triangle; count 0 if there are none.
template <class Surface>
static RawManifold collide_triangle(const ConvexCore& a, const Surface& mesh, std::uint32_t index,
                                    const MeshPose& pose, const Reach& reach,
                                    std::span<const PatchTrace> previous, std::size_t& queries) {
  RawManifold found;
  const ConvexCore t = triangle_core(mesh, index, pose);
  const double gap = front_axis(a, t).separation;
  if (gap - a.radius >= reach.margin) return found;
  // Behind the plane there is no contact, unless the shape was pushed through just now.
  const double height = t.front.dot(a.centre - t.corners[0]);
  const bool behind = height < 0.0;
  if (behind && (height < -a.size || !was_touched(previous, mesh.normal(index)))) return found;
  // No direction could be (much) better than a front with such a small overlap; and if the centre
  // is behind the plane, the nearest way out would be the wrong one.
  if (behind || (a.radius == 0.0 && gap >= -kFrontSize * a.size)) {
    found = front_manifold(a, t, reach, reach.way);
  }
  if (found.count > 0 || behind) return found;
  ++queries;
  Direction direction = query_direction(a, t, reach.margin);
  Vec3 moved = until_meeting(a, t, reach.way, reach.margin, direction, queries);
  if (direction.status != Direction::Status::Apart) {
    const ConvexCore there = moved_by(t, moved);
    const Vec3 left = reach.way - moved;
    if (a.radius == 0.0 && !moved.isZero(0.0)) found = front_manifold(a, there, reach, left);
    if (found.count == 0) {
      found = triangle_manifold(a, mesh, index, there, pose, reach, left, direction);
    }
  }
  // On a rising surface other triangles stop the shape first, and its path may end over this one.
  if (found.count == 0 && gap - a.radius >= -kFrontSize * a.size && !reach.sweep.isZero(0.0)) {
    moved = reach.sweep;
    found = front_manifold(a, moved_by(t, moved), reach, Vec3::Zero());
  }
  const double back = found.normal.dot(moved);
  for (int i = 0; i < found.count; ++i) {
    found.points[i].on_b -= moved;
    found.points[i].gap -= back;
  }
  return found;
}

/// Moves the points of one normal, from `seed` on, to scratch.cluster, and numbers them.
static void gather_cluster(MeshScratch& scratch, std::size_t seed, int number, double radius) {
  const Vec3 n = scratch.points[seed].normal;
  scratch.cluster.clear();
  for (std::size_t i = seed; i < scratch.points.size(); ++i) {
    MeshPoint& candidate = scratch.points[i];
    if (candidate.cluster >= 0 || candidate.normal.dot(n) < kSameNormal) continue;
    candidate.cluster = number;
    // Measured along the common normal the gap equals that along the point's own.
    candidate.point.on_b = candidate.point.on_a + (candidate.point.gap + radius) * n;
    scratch.cluster.push_back(candidate.point);
  }
}

template <class Surface>
std::size_t collide_mesh(const ConvexCore& a, const Surface& mesh, const MeshPose& pose,
                         const Reach& reach, std::span<const PatchTrace> previous,
                         TriangleList& list, MeshScratch& scratch, std::vector<RawManifold>& out) {
  out.clear();
  scratch.points.clear();
  const Mat3 to_mesh = pose.rotation.transpose();
  const Aabb bounds = bounds_in_mesh(a, pose, reach);
  find_triangles(mesh, bounds, list);
  std::size_t queries = 0;
  for (const std::uint32_t index : list.triangles) {
    if (!triangle_bounds(mesh, index).overlaps(bounds)) continue;
    const RawManifold found = collide_triangle(a, mesh, index, pose, reach, previous, queries);
    if (found.count == 0) continue;
    const Vec3 normal_l = to_mesh * found.normal;
    const bool known = std::any_of(previous.begin(), previous.end(), [&](const PatchTrace& p) {
      return p.normal_l.dot(normal_l) > kSameNormal;
    });
    const double start = known ? 1e-3 * a.size : 0.0;
    for (int i = 0; i < found.count; ++i) {
      scratch.points.push_back(
          {found.points[i], found.normal, found.points[i].gap - start, index, -1});
    }
  }

  std::sort(scratch.points.begin(), scratch.points.end(), by_rank);
  for (std::size_t seed = 0; seed < scratch.points.size(); ++seed) {
    if (scratch.points[seed].cluster >= 0) continue;
    gather_cluster(scratch, seed, static_cast<int>(out.size()), a.radius);
    RawManifold manifold;
    manifold.normal = scratch.points[seed].normal;
    manifold.owner = FaceOwner::B;
    const PatchTrace* before = match(to_mesh * manifold.normal, previous, out);
    manifold.cluster = before != nullptr ? before->cluster : free_number(previous, out);
    if (a.kind == CoreKind::Segment) {
      merge_equal(scratch.cluster);
      reduce_segment(scratch.cluster, a.axes.col(2), 1e-3 * a.size);
    }
    finish_cluster(scratch.cluster, manifold, a.size, reach.weight, before);
    out.push_back(manifold);
  }
  return queries;
}

RawManifold mesh_half_space(const TriangleMesh& mesh, const MeshPose& pose, const Vec3& normal,
                            double offset, double margin, std::span<const PatchTrace> previous,
                            MeshScratch& scratch) {
  scratch.cluster.clear();
  for (std::uint32_t v = 0; v < mesh.vertices().size(); ++v) {
    const Vec3 p = pose.rotation * mesh.vertex(v) + pose.translation;
    const double height = normal.dot(p) - offset;
    if (height >= margin) continue;
    scratch.cluster.push_back({p, p - height * normal, height, corner_feature(false, v)});
  }
  RawManifold out;
  out.normal = -normal;
  out.owner = FaceOwner::B;
  const double size = (mesh.bounds().max - mesh.bounds().min).minCoeff();
  finish_cluster(scratch.cluster, out, size, pose.translation,
                 previous.empty() ? nullptr : &previous[0]);
  return out;
}

template bool normal_allowed(const TriangleMesh&, std::uint32_t, const Vec3&);
template bool normal_allowed(const HeightField&, std::uint32_t, const Vec3&);
template std::size_t collide_mesh(const ConvexCore&, const TriangleMesh&, const MeshPose&,
                                  const Reach&, std::span<const PatchTrace>, TriangleList&,
                                  MeshScratch&, std::vector<RawManifold>&);
template std::size_t collide_mesh(const ConvexCore&, const HeightField&, const MeshPose&,
                                  const Reach&, std::span<const PatchTrace>, TriangleList&,
                                  MeshScratch&, std::vector<RawManifold>&);

}  // namespace tandem::collision
