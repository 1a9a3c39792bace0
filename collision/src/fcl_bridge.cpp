// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// The only file that includes FCL; compiled with EIGEN_MAX_ALIGN_BYTES=16 (see CMakeLists.txt).
//
// What is asked, and why (FCL 0.7.0 with libccd 2.1, measured over 20 000 seeded random poses for
// each kind against a brute-force search over all separating axes):
// - spheres and half-spaces: FCL's own closed forms on inflated shapes; exact. Overlapping boxes:
//   its search over 15 axes, which prefers faces to edges that are less than 5 % better.
// - boxes apart, capsule-box, box-triangle, capsule-triangle: distance of the cores by GJK on
// libccd (1 us),
//   right where they are apart. Where the cores overlap the library is wrong and is not asked:
//   libccd's penetration query (MPR) misses the depth by more than 1 mm in 29 to 34 % of the poses
//   and by up to 0.57 m; FCL's signed distance (EPA) ends the process on touching features, by an
//   assertion compiled into libfcl. The status is then Unknown, and choose_axis() searches the
//   face normals and edge products of the two.
// - GJK is called by its function in FCL's header and not through the solver: the solver's copy is
//   compiled into libfcl with assertions, and those of GJK are no safer than EPA's.
// - sphere-triangle: the distance from the centre. FCL's intersection test keeps the last edge in
//   reach in place of the nearest one, and returns negative depths.
#include "fcl_bridge.h"

#include <vector>

#include "fcl/narrowphase/detail/gjk_solver_libccd.h"

namespace tandem::collision {
namespace {

using Solver = fcl::detail::GJKSolver_libccd<double>;
using Transform = fcl::Transform3<double>;
using Contacts = std::vector<fcl::ContactPoint<double>>;

/// m: nearer cores count as touching, where GJK's direction is noise.
constexpr double kTouching = 1e-7;

Transform transform_of(const ConvexCore& core) {
  Transform t = Transform::Identity();
  t.linear() = core.axes;
  t.translation() = core.centre;
  return t;
}

fcl::Sphere<double> sphere(double radius) { return fcl::Sphere<double>(radius); }
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

/// FCL's normals point from the first shape to the second one, as ours.
template <class ShapeA, class ShapeB>
Direction intersect(const ShapeA& a, const Transform& pose_a, const ShapeB& b,
                    const Transform& pose_b) {
  Contacts contacts;
  if (!Solver().shapeIntersect(a, pose_a, b, pose_b, &contacts) || contacts.empty()) return {};
  return found(contacts.front().normal);
}

/// An object of libccd's, made and freed by FCL.
class CcdObject {
 public:
  explicit CcdObject(const ConvexCore& core) : kind_(core.kind) {
    if (kind_ == CoreKind::Box) {
      object_ = BoxMaker::createGJKObject(box(core), transform_of(core));
    } else if (kind_ == CoreKind::Segment) {
      object_ = CapsuleMaker::createGJKObject(capsule(core, 0.0), transform_of(core));
    } else {
      object_ = fcl::detail::triCreateGJKObject<double>(core.corners[0], core.corners[1],
                                                        core.corners[2]);
    }
  }
  ~CcdObject() {
    if (kind_ == CoreKind::Box) {
      BoxMaker::deleteGJKObject(object_);
    } else if (kind_ == CoreKind::Segment) {
      CapsuleMaker::deleteGJKObject(object_);
    } else {
      fcl::detail::triDeleteGJKObject(object_);
    }
  }
  CcdObject(const CcdObject&) = delete;
  CcdObject& operator=(const CcdObject&) = delete;

  void* get() const { return object_; }
  fcl::detail::GJKSupportFunction support() const {
    if (kind_ == CoreKind::Box) return BoxMaker::getSupportFunction();
    if (kind_ == CoreKind::Segment) return CapsuleMaker::getSupportFunction();
    return fcl::detail::triGetSupportFunction();
  }

 private:
  using BoxMaker = fcl::detail::GJKInitializer<double, fcl::Box<double>>;
  using CapsuleMaker = fcl::detail::GJKInitializer<double, fcl::Capsule<double>>;
  CoreKind kind_;
  void* object_ = nullptr;
};

/// Distance of the cores where they are apart.
Direction distance(const ConvexCore& a, const ConvexCore& b, double reach) {
  const CcdObject object_a(a);
  const CcdObject object_b(b);
  const Solver solver;
  ccd_t ccd;
  CCD_INIT(&ccd);
  ccd.support1 = object_a.support();
  ccd.support2 = object_b.support();
  ccd.max_iterations = solver.max_distance_iterations;
  ccd.dist_tolerance = solver.distance_tolerance;
  ccd_vec3_t on_a = {{0.0, 0.0, 0.0}};
  ccd_vec3_t on_b = {{0.0, 0.0, 0.0}};
  const double gap = fcl::detail::libccd_extension::ccdGJKDist2(object_a.get(), object_b.get(),
                                                                &ccd, &on_a, &on_b);
  if (gap > reach) return {};
  if (!(gap > kTouching)) return {Direction::Status::Unknown, Vec3::UnitZ()};
  return found(Vec3(on_b.v[0] - on_a.v[0], on_b.v[1] - on_a.v[1], on_b.v[2] - on_a.v[2]) / gap);
}

Direction ask(const ConvexCore& a, const ConvexCore& b, double margin) {
  const Transform pose_a = transform_of(a);
  const Transform pose_b = transform_of(b);
  const double reach = a.radius + b.radius + margin;
  if (a.kind == CoreKind::Point) {
    switch (b.kind) {
      case CoreKind::Point:
        return intersect(sphere(a.radius + margin), pose_a, sphere(b.radius), pose_b);
      case CoreKind::Segment:
        return intersect(sphere(a.radius + margin), pose_a, capsule(b, b.radius), pose_b);
      case CoreKind::Box:
        return intersect(sphere(a.radius + margin), pose_a, box(b), pose_b);
      case CoreKind::Triangle: {
        double gap = 0.0;
        fcl::Vector3<double> unused = Vec3::Zero();
        fcl::Vector3<double> nearest = Vec3::Zero();
        const bool apart = Solver().shapeTriangleDistance(
            sphere(0.0), pose_a, b.corners[0], b.corners[1], b.corners[2], &gap, &unused, &nearest);
        if (!apart || gap < kTouching) return {Direction::Status::Unknown, Vec3::UnitZ()};
        return gap > reach ? Direction{} : found((nearest - a.centre) / gap);
      }
    }
  }
  if (a.kind == CoreKind::Segment && b.kind == CoreKind::Segment) {
    double gap = 0.0;
    fcl::Vector3<double> on_a = Vec3::Zero();
    fcl::Vector3<double> on_b = Vec3::Zero();
    // With radius 1 the witnesses tell the direction whether or not the axes cross.
    Solver().shapeDistance(capsule(a, 1.0), pose_a, capsule(b, 1.0), pose_b, &gap, &on_a, &on_b);
    const double axes = gap + 2.0;
    if (axes > reach) return {};
    // on_b - on_a = (axes - 2) n, so that n is lost at exactly 2 m: ask there with other radii.
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
  } catch (...) {  // FCL's way to say that a configuration is too degenerate for it
    return {Direction::Status::Unknown, Vec3::UnitZ()};
  }
}

bool near_half_space(const ConvexCore& a, const Vec3& normal, double offset,
                     double margin) noexcept {
  try {
    const fcl::Halfspace<double> plane(normal, offset + margin);
    const Transform pose = transform_of(a);
    const Transform identity = Transform::Identity();
    const Solver solver;
    switch (a.kind) {
      case CoreKind::Point:
        return solver.shapeIntersect(sphere(a.radius), pose, plane, identity, nullptr);
      case CoreKind::Segment:
        return solver.shapeIntersect(capsule(a, a.radius), pose, plane, identity, nullptr);
      default:
        return solver.shapeIntersect(box(a), pose, plane, identity, nullptr);
    }
  } catch (...) {
    return true;  // the exact test that follows decides
  }
}

}  // namespace tandem::collision
