// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// The only file that includes FCL; compiled with EIGEN_MAX_ALIGN_BYTES=16 (see CMakeLists.txt).
//
// What is asked, and why (FCL 0.7.0 with libccd 2.1, measured over 20 000 seeded random poses for
// each kind against a brute-force search over all separating axes):
// - spheres, box-box and half-spaces: FCL's own closed forms on inflated shapes; exact.
// - capsule-box, box-triangle, capsule-triangle: distance of the cores by GJK (1 us), exact where
//   they are apart. Where the cores overlap, libccd's penetration query (MPR) is wrong by more
//   than 1 mm in 29 to 34 % of the poses, by up to 0.57 m; FCL's signed distance (EPA on libccd's
//   polytope, 5 us) is right to 1e-12 but may give up on exactly touching features, which
//   convex_manifold.cpp then settles with the face normals.
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
fcl::Box<double> box(const ConvexCore& core, double margin) {
  return fcl::Box<double>(fcl::Vector3<double>(2.0 * (core.half + Vec3::Constant(margin))));
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
      object_ = BoxMaker::createGJKObject(box(core, 0.0), transform_of(core));
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

/// Distance of the cores, then their depth where they overlap.
Direction distance(const ConvexCore& a, const ConvexCore& b, double reach) {
  const CcdObject object_a(a);
  const CcdObject object_b(b);
  const Solver solver;
  const auto iterations = static_cast<unsigned>(solver.max_distance_iterations);
  double gap = 0.0;
  fcl::Vector3<double> on_a = Vec3::Zero();
  fcl::Vector3<double> on_b = Vec3::Zero();
  const bool apart = fcl::detail::GJKDistance<double>(
      object_a.get(), object_a.support(), object_b.get(), object_b.support(), iterations,
      solver.distance_tolerance, &gap, &on_a, &on_b);
  if (apart && gap > reach) return {};
  if (apart && gap > kTouching) return found((on_b - on_a) / gap);
  fcl::detail::GJKSignedDistance<double>(object_a.get(), object_a.support(), object_b.get(),
                                         object_b.support(), iterations,
                                         solver.distance_tolerance, &gap, &on_a, &on_b);
  // Overlapping, the witness on a lies beyond the one on b.
  const double depth = (on_a - on_b).norm();
  if (!(gap < 0.0) || !(depth > kTouching)) return {Direction::Status::Unknown, Vec3::UnitZ()};
  return found((on_a - on_b) / depth);
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
        return intersect(sphere(a.radius + margin), pose_a, box(b, 0.0), pose_b);
      case CoreKind::Triangle: {
        double gap = 0.0;
        fcl::Vector3<double> unused = Vec3::Zero();
        fcl::Vector3<double> nearest = Vec3::Zero();
        const bool apart = Solver().shapeTriangleDistance(
            sphere(0.0), pose_a, b.corners[0], b.corners[1], b.corners[2], &gap, &unused,
            &nearest);
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
    const Direction overlap = intersect(box(a, 0.0), pose_a, box(b, 0.0), pose_b);
    if (overlap.status != Direction::Status::Apart || margin <= 0.0) return overlap;
    return intersect(box(a, 0.5 * margin), pose_a, box(b, 0.5 * margin), pose_b);
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
        return solver.shapeIntersect(box(a, 0.0), pose, plane, identity, nullptr);
    }
  } catch (...) {
    return true;  // the exact test that follows decides
  }
}

}  // namespace tandem::collision
