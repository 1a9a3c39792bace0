// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "mesh_manifold.h"

#include <algorithm>
#include <cmath>

#include "sphere_contact.h"
#include "tandem/collision/height_field.h"

namespace tandem::collision {
namespace {

/// Cosine above which two normals belong to one manifold.
constexpr double kSameCluster = 0.99;
/// Cosine above which a cluster carries on one of the last step.
constexpr double kSameAsBefore = 0.9;
/// Cosine above which a normal is the front's and noise.
constexpr double kIsFront = 1.0 - 1e-6;
/// Sine by which a normal may leave a Voronoi region.
constexpr double kRegionSlop = 1e-4;
/// A front is preferred within this share of the depth, and of the shape's size.
constexpr double kFrontShare = 0.05;
constexpr double kFrontSize = 1e-3;
/// A front deeper than this is not the way out: the triangle faces elsewhere.
constexpr double kMaxReprojection = 4.0;
constexpr double kMaxReprojectionSize = 0.05;
/// m: a centre nearer than this to a point has no direction from it.
constexpr double kTouching = 1e-7;
/// m by which a point may lie beside a triangle and still count as over it.
constexpr double kOver = 1e-6;
/// By what share of its size the box is wider that triangles are searched for.
constexpr double kListShare = 0.25;

bool by_rank(const MeshPoint& l, const MeshPoint& r) {
  if (l.rank != r.rank) return l.rank < r.rank;
  if (l.triangle != r.triangle) return l.triangle < r.triangle;
  return l.point.feature < r.point.feature;
}

bool was_touched(std::span<const ContactPatch> previous, const Vec3& front_l) {
  return std::any_of(previous.begin(), previous.end(), [&](const ContactPatch& patch) {
    return patch.count > 0 && -patch.normal_l.dot(front_l) > kSameAsBefore;
  });
}

/// Whether the prism over the triangle holds the point.
bool over_triangle(const ConvexCore& t, const Vec3& p) {
  for (int k = 0; k < 3; ++k) {
    const Vec3 edge = t.corners[(k + 1) % 3] - t.corners[k];
    const Vec3 inwards = t.front.cross(edge);
    if (inwards.dot(p - t.corners[k]) < -kOver * inwards.norm()) return false;
  }
  return true;
}

/// Contact across the front: what of the shape lies over the triangle, and nothing beside it.
RawManifold front_manifold(const ConvexCore& a, const ConvexCore& t, const Reach& reach) {
  const ContactAxis axis = front_axis(a, t);
  if (a.kind == CoreKind::Point) {
    if (!over_triangle(t, a.centre)) return {};
    return build_manifold(a, t, axis, reach);
  }
  RawManifold out;
  out.normal = axis.normal;
  out.owner = axis.owner;
  const CoreFace reference = face_towards(t, t.front);
  const ClippedFace clipped = clip_face(reference, t.front, face_towards(a, axis.normal), false);
  for (int i = 0; i < clipped.count; ++i) {
    const Vec3& p = clipped.corners[i].position;
    const double height = t.front.dot(p - t.corners[0]);
    const double gap = height - a.radius;
    if (gap < reach.margin) out.add({p, p - height * t.front, gap, clipped.corners[i].feature});
  }
  return out;
}

template <class Surface>
RawManifold triangle_manifold(const ConvexCore& a, const Surface& mesh, std::uint32_t index,
                              const ConvexCore& t, const MeshPose& pose, const Reach& reach,
                              const Direction& direction) {
  const ContactAxis front = front_axis(a, t);
  const Vec3 hint = -t.front;
  const ContactAxis axis = choose_axis(a, t, direction, &hint);
  const double cosine = -axis.normal.dot(t.front);
  const double depth = std::max(0.0, -axis.separation);
  const double tolerance = a.radius > 0.0 ? 0.0 : kFrontShare * depth + kFrontSize * a.size;
  const bool is_front = cosine > kIsFront;
  const bool allowed =
      is_front || (cosine > kRegionSlop &&
                   normal_allowed(mesh, index, -(pose.rotation.transpose() * axis.normal)));
  if (is_front || front.separation >= axis.separation - tolerance) {
    RawManifold flat = front_manifold(a, t, reach);
    if (flat.count > 0 || is_front) return flat;
  }
  if (allowed) return build_manifold(a, t, axis, reach);
  if (-front.separation <= kMaxReprojection * depth + kMaxReprojectionSize * a.size) {
    return front_manifold(a, t, reach);
  }
  return {};
}

/// The patch of the last step that the cluster carries on, or null.
const ContactPatch* match(const Vec3& normal_l, std::span<const ContactPatch> previous,
                          const std::vector<RawManifold>& taken) {
  const ContactPatch* best = nullptr;
  double cosine = kSameAsBefore;
  for (const ContactPatch& patch : previous) {
    const double value = patch.normal_l.dot(normal_l);
    const bool used = std::any_of(taken.begin(), taken.end(),
                                  [&](const RawManifold& m) { return m.cluster == patch.cluster; });
    if (!used && value > cosine) {
      cosine = value;
      best = &patch;
    }
  }
  return best;
}

std::uint32_t free_number(std::span<const ContactPatch> previous,
                          const std::vector<RawManifold>& taken) {
  for (std::uint32_t number = 0;; ++number) {
    const bool used = std::any_of(previous.begin(), previous.end(),
                                  [&](const ContactPatch& p) { return p.cluster == number; }) ||
                      std::any_of(taken.begin(), taken.end(),
                                  [&](const RawManifold& m) { return m.cluster == number; });
    if (!used) return number;
  }
}

/// Equal features are one point: the deepest of them stays.
void merge_equal(std::vector<RawPoint>& points) {
  std::sort(points.begin(), points.end(), [](const RawPoint& l, const RawPoint& r) {
    return l.feature != r.feature ? l.feature < r.feature : l.gap < r.gap;
  });
  points.erase(
      std::unique(points.begin(), points.end(),
                  [](const RawPoint& l, const RawPoint& r) { return l.feature == r.feature; }),
      points.end());
}

/// Points on a segment: its two ends, and the deepest where that lies between and below them.
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
                    const ContactPatch* before) {
  merge_equal(points);
  std::array<std::uint32_t, 4> kept{};
  const int kept_count = before != nullptr ? before->count : 0;
  for (int i = 0; i < kept_count; ++i) kept[i] = before->features[i];
  const int count = reduce(points.data(), static_cast<int>(points.size()), manifold.normal,
                           1e-3 * size, kept.data(), kept_count);
  for (int i = 0; i < count; ++i) manifold.add(points[i]);
}

template <class Surface>
Aabb triangle_bounds(const Surface& mesh, std::uint32_t t) {
  const TriangleMesh::Triangle corners = mesh.corners(t);
  const Vec3 a = mesh.vertex(corners[0]);
  const Vec3 b = mesh.vertex(corners[1]);
  const Vec3 c = mesh.vertex(corners[2]);
  return {a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c)};
}

/// Fill the list, unless it still holds: searched for a box somewhat larger than asked.
template <class Surface>
void candidates(const Surface& mesh, const Aabb& bounds, TriangleList& list) {
  if (list.filled && Aabb{list.min, list.max}.contains(bounds)) {
    const Vec3 slack = (list.max - list.min) - (bounds.max - bounds.min);
    if (slack.maxCoeff() < (bounds.max - bounds.min).maxCoeff()) return;
  }
  const Aabb wide = bounds.expanded(kListShare * (bounds.max - bounds.min).maxCoeff());
  list.triangles.clear();
  mesh.query(wide, list.triangles);
  list.min = wide.min;
  list.max = wide.max;
  list.filled = true;
}

/// A sphere touches a triangle at its point nearest to the centre, if that lies in the triangle's
/// own region. A closed form: the library keeps the last edge in reach in place of the nearest one
/// (see fcl_bridge.cpp).
template <class Surface>
void sphere_on_mesh(const ConvexCore& a, const Surface& mesh, const MeshPose& pose,
                    const Vec3& centre, const Reach& reach, std::span<const ContactPatch> previous,
                    const TriangleList& list, MeshScratch& scratch, std::vector<RawManifold>& out) {
  const double limit = reach.margin + a.radius;
  for (const std::uint32_t index : list.triangles) {
    const TriangleMesh::Triangle corners = mesh.corners(index);
    const Vec3 p = mesh.vertex(corners[0]);
    const Vec3 front = mesh.normal(index);
    const double height = front.dot(centre - p);
    if (height >= limit) continue;
    if (height < 0.0 && (height < -a.size || !was_touched(previous, front))) continue;
    int region = 0;
    const Vec3 nearest =
        nearest_on_triangle(centre, p, mesh.vertex(corners[1]), mesh.vertex(corners[2]), region);
    Vec3 normal = -front;
    double distance = height;
    if (region != 3) {
      const Vec3 d = nearest - centre;
      const bool over = (d + height * front).squaredNorm() < kOver * kOver;
      if (!over) {
        if (height < 0.0) continue;
        distance = d.norm();
        if (distance >= limit || distance < kTouching) continue;
        if (height <= kIsFront * distance) {
          normal = d / distance;
          if (height <= kRegionSlop * distance || !normal_allowed(mesh, index, -normal)) continue;
        }
      }
    }
    if (distance >= limit) continue;
    const bool known = std::any_of(previous.begin(), previous.end(), [&](const ContactPatch& q) {
      return q.normal_l.dot(normal) > kIsFront;
    });
    const double gap = distance - a.radius;
    scratch.points.push_back(
        {{a.centre, nearest, gap, 0}, normal, gap - (known ? 1e-3 * a.size : 0.0), index, -1});
  }
  std::sort(scratch.points.begin(), scratch.points.end(), by_rank);
  for (std::size_t seed = 0; seed < scratch.points.size(); ++seed) {
    const MeshPoint& point = scratch.points[seed];
    bool taken = false;
    for (std::size_t i = 0; i < seed && !taken; ++i) {
      taken = scratch.points[i].cluster >= 0 &&
              scratch.points[i].normal.dot(point.normal) >= kSameCluster;
    }
    if (taken) continue;
    scratch.points[seed].cluster = 0;
    const ContactPatch* before = match(point.normal, previous, out);
    const std::uint32_t number = before != nullptr ? before->cluster : free_number(previous, out);
    RawManifold& manifold = out.emplace_back();
    manifold.cluster = number;
    manifold.normal = pose.rotation * point.normal;
    manifold.owner = FaceOwner::B;
    const double distance = point.point.gap + a.radius;
    manifold.add({a.centre, a.centre + distance * manifold.normal, point.point.gap, 0});
  }
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
    // In the neighbour's plane, from the edge into it; there the edge runs the other way.
    return n.dot(edge.cross(mesh.normal(other))) <= kRegionSlop;
  }
  const std::uint32_t v = corners[foremost];
  for (const std::uint32_t w : mesh.ring(v)) {
    const Vec3 along = mesh.vertex(w) - mesh.vertex(v);
    if (n.dot(along) > kRegionSlop * along.norm()) return false;
  }
  return true;
}

template <class Surface>
std::size_t collide_mesh(const ConvexCore& a, const Surface& mesh, const MeshPose& pose,
                         const Reach& reach, std::span<const ContactPatch> previous,
                         TriangleList& list, MeshScratch& scratch, std::vector<RawManifold>& out) {
  out.clear();
  scratch.points.clear();
  // Bounds of the shape in the mesh frame.
  const Mat3 to_mesh = pose.rotation.transpose();
  const Vec3 centre_l = to_mesh * (a.centre - pose.translation);
  const double round = a.radius + reach.margin;
  const Vec3 middle = to_mesh * -pose.translation;
  Aabb bounds;
  for (int i = 0; i < 3; ++i) {
    const Vec3 axis = pose.rotation.col(i);
    bounds.min[i] = middle[i] - a.reach(-axis) - round;
    bounds.max[i] = middle[i] + a.reach(axis) + round;
  }
  candidates(mesh, bounds, list);
  if (a.kind == CoreKind::Point) {
    sphere_on_mesh(a, mesh, pose, centre_l, reach, previous, list, scratch, out);
    return 0;
  }

  std::size_t queries = 0;
  for (const std::uint32_t index : list.triangles) {
    if (!triangle_bounds(mesh, index).overlaps(bounds)) continue;
    const ConvexCore t = triangle_core(mesh, index, pose);
    if (front_axis(a, t).separation - a.radius >= reach.margin) continue;
    // Behind the plane there is no contact, except for a shape that was pushed through just now.
    const double height = t.front.dot(a.centre - t.corners[0]);
    if (height < 0.0 && (height < -a.size || !was_touched(previous, mesh.normal(index)))) continue;
    // No direction could be (much) better than a front that is overlapped this little; and where
    // the middle is behind the plane, the nearest way out would be the wrong one.
    const bool behind = t.front.dot(a.centre - t.corners[0]) < 0.0;
    const double gap = front_axis(a, t).separation;
    RawManifold found;
    if (behind || (a.radius == 0.0 && gap >= -kFrontSize * a.size)) {
      found = front_manifold(a, t, reach);
    }
    if (found.count == 0 && !behind) {
      ++queries;
      const Direction direction = query_direction(a, t, reach.margin);
      if (direction.status == Direction::Status::Apart) continue;
      found = triangle_manifold(a, mesh, index, t, pose, reach, direction);
    }
    const Vec3 normal_l = to_mesh * found.normal;
    const bool known = std::any_of(previous.begin(), previous.end(), [&](const ContactPatch& p) {
      return p.normal_l.dot(normal_l) > kIsFront;
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
    const Vec3 n = scratch.points[seed].normal;
    scratch.cluster.clear();
    for (std::size_t i = seed; i < scratch.points.size(); ++i) {
      MeshPoint& candidate = scratch.points[i];
      if (candidate.cluster >= 0 || candidate.normal.dot(n) < kSameCluster) continue;
      candidate.cluster = static_cast<int>(out.size());
      // Measured along the common normal the gap stays what it was along the point's own.
      candidate.point.on_b = candidate.point.on_a + (candidate.point.gap + a.radius) * n;
      scratch.cluster.push_back(candidate.point);
    }
    RawManifold manifold;
    manifold.normal = n;
    manifold.owner = FaceOwner::B;
    const ContactPatch* before = match(to_mesh * n, previous, out);
    manifold.cluster = before != nullptr ? before->cluster : free_number(previous, out);
    if (a.kind == CoreKind::Segment) {
      merge_equal(scratch.cluster);
      reduce_segment(scratch.cluster, a.axes.col(2), 1e-3 * a.size);
    }
    finish_cluster(scratch.cluster, manifold, a.size, before);
    out.push_back(manifold);
  }
  return queries;
}

RawManifold mesh_half_space(const TriangleMesh& mesh, const MeshPose& pose, const Vec3& normal,
                            double offset, double margin, std::span<const ContactPatch> previous,
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
  finish_cluster(scratch.cluster, out, size, previous.empty() ? nullptr : &previous[0]);
  return out;
}

template std::size_t collide_mesh(const ConvexCore&, const TriangleMesh&, const MeshPose&,
                                  const Reach&, std::span<const ContactPatch>, TriangleList&,
                                  MeshScratch&, std::vector<RawManifold>&);
template std::size_t collide_mesh(const ConvexCore&, const HeightField&, const MeshPose&,
                                  const Reach&, std::span<const ContactPatch>, TriangleList&,
                                  MeshScratch&, std::vector<RawManifold>&);

}  // namespace tandem::collision
