// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// The only file that includes FCL; compiled with EIGEN_MAX_ALIGN_BYTES=16 (see CMakeLists.txt).
//
// Queries, and why (FCL 0.7.0 with libccd 2.1, measured over 20 000 seeded random poses for each
// kind against a brute-force search over all separating axes):
// - overlapping boxes: FCL's search over 15 axes, which prefers faces to edges that are less than
//   5 % better. Two capsules: the distance of their axes, a closed form.
// - everything else: distance of the cores by FCL's GJK on libccd (1 us), correct if they are
//   apart. For overlapping cores the library is wrong and not used: libccd's penetration query
//   (MPR) misses the depth by more than 1 mm in 29 to 34 % of the poses and by up to 0.57 m; FCL's
//   signed distance (EPA) ends the process on touching features, by an assertion compiled into
//   libfcl. The status is then Unknown, and choose_axis() searches face normals and edge products.
// - GJK is called by its function in FCL's header, not through the solver: the solver's copy is
//   compiled into libfcl with assertions, and GJK's are no safer than EPA's.
// - Spheres only come here against hulls: see sphere_contact.h.
#include "fcl_bridge.h"

#include <algorithm>
#include <vector>

#include "fcl/narrowphase/detail/gjk_solver_libccd.h"

namespace tandem::collision {
namespace {

using Solver = fcl::detail::GJKSolver_libccd<double>;
using Transform = fcl::Transform3<double>;
using Contacts = std::vector<fcl::ContactPoint<double>>;

/// Share of the smaller size below which cores count as touching, as GJK's direction is noise.
constexpr double kNearlyTouching = 1e-7;
/// m: larger sizes stand for "no bound" (triangles).
constexpr double kLargest = 1e3;

Transform transform_of(const ConvexCore& core) {
  Transform t = Transform::Identity();
  t.linear() = core.axes;
  t.translation() = core.centre;
  return t;
}

fcl::Capsule<double> capsule(const ConvexCore& core, double radius) {
  return fcl::Capsule<double>(radius, 2.0 * core.half[2]);
}
fcl::Box<double> box(const ConvexCore& core) {
  return fcl::Box<double>(fcl::Vector3<double>(2.0 * core.half));
}

Direction found(const Vec3& normal) {
  const double norm = normal.norm();
  if (!(norm > 0.5)) return {Direction::Status::Unknown, Vec3::UnitZ()};
  return {Direction::Status::Found, normal / norm};
}

/// FCL's normals point from the first shape to the second, like ours.
template <class ShapeA, class ShapeB>
Direction intersect(const ShapeA& a, const Transform& pose_a, const ShapeB& b,
                    const Transform& pose_b) {
  Contacts contacts;
  if (!Solver().shapeIntersect(a, pose_a, b, pose_b, &contacts) || contacts.empty()) return {};
  return found(contacts.front().normal);
}

/// Argument of the support function: the core, scaled to a size near 1, so that the library's
/// absolute tolerances mean the same for a millimetre and for a hundred metres.
struct Scaled {
  const ConvexCore* core;
  Vec3 origin;
  double scale;
};

void support(const void* object, const ccd_vec3_t* direction, ccd_vec3_t* out) {
  const auto& scaled = *static_cast<const Scaled*>(object);
  const Vec3 d(direction->v[0], direction->v[1], direction->v[2]);
  const Vec3 p = scaled.scale * (scaled.core->support(d) - scaled.origin);
  for (int i = 0; i < 3; ++i) out->v[i] = p[i];
}

/// Distance of separated cores. FCL's GJK with our own support functions: FCL's allocate an object
/// per shape and query.
Direction distance(const ConvexCore& a, const ConvexCore& b, double reach) {
  const double scale = 1.0 / std::min({a.size, b.size, kLargest});
  const Scaled object_a{&a, a.centre, scale};
  const Scaled object_b{&b, a.centre, scale};
  const Solver solver;
  ccd_t ccd;
  CCD_INIT(&ccd);
  ccd.support1 = &support;
  ccd.support2 = &support;
  ccd.max_iterations = solver.max_distance_iterations;
  ccd.dist_tolerance = solver.distance_tolerance;
  ccd_vec3_t on_a = {{0.0, 0.0, 0.0}};
  ccd_vec3_t on_b = {{0.0, 0.0, 0.0}};
  const double gap =
      fcl::detail::libccd_extension::ccdGJKDist2(&object_a, &object_b, &ccd, &on_a, &on_b);
  if (gap > scale * reach) return {};
  if (!(gap > kNearlyTouching)) return {Direction::Status::Unknown, Vec3::UnitZ()};
  Direction direction =
      found(Vec3(on_b.v[0] - on_a.v[0], on_b.v[1] - on_a.v[1], on_b.v[2] - on_a.v[2]) / gap);
  // For slightly overlapping cores it sometimes reports a distance.
  if (scale * separation(a, b, direction.normal) < 0.5 * gap) {
    return {Direction::Status::Unknown, Vec3::UnitZ()};
  }
  return direction;
}

Direction ask(const ConvexCore& a, const ConvexCore& b, double margin) {
  const double reach = a.radius + b.radius + margin;
  const Transform pose_a = transform_of(a);
  const Transform pose_b = transform_of(b);
  if (a.kind == CoreKind::Segment && b.kind == CoreKind::Segment) {
    double gap = 0.0;
    fcl::Vector3<double> on_a = Vec3::Zero();
    fcl::Vector3<double> on_b = Vec3::Zero();
    // With radius 1 the witness points give the direction whether or not the axes cross.
    Solver().shapeDistance(capsule(a, 1.0), pose_a, capsule(b, 1.0), pose_b, &gap, &on_a, &on_b);
    const double axes = gap + 2.0;
    if (axes > reach) return {};
    // on_b - on_a = (axes - 2) n, so n is lost at exactly 2 m: query with other radii there.
    if (std::abs(gap) > 0.5) return found((on_b - on_a) / gap);
    Solver().shapeDistance(capsule(a, 3.0), pose_a, capsule(b, 3.0), pose_b, &gap, &on_a, &on_b);
    return found((on_b - on_a) / gap);
  }
  if (a.kind == CoreKind::Box && b.kind == CoreKind::Box) {
    const Direction overlap = intersect(box(a), pose_a, box(b), pose_b);
    return overlap.status != Direction::Status::Apart ? overlap : distance(a, b, reach);
  }
  return distance(a, b, reach);
}

}  // namespace

Direction query_direction(const ConvexCore& a, const ConvexCore& b, double margin) noexcept {
  try {
    return ask(a, b, margin);
  } catch (...) {  // FCL throws for configurations that are too degenerate
    return {Direction::Status::Unknown, Vec3::UnitZ()};
  }
}

}  // namespace tandem::collision
