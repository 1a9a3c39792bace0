// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/collision/shape.h"

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "tandem/pbd/validate.h"

namespace tandem::collision {
namespace {

using pbd::Mat3;
using pbd::Vec3;

/// m: a larger size is a mistake of units, and its square would swamp the rest of the scene.
constexpr double kMaxSize = 1e6;

bool fail(std::string* error, const char* field, double value, const char* rule) {
  if (error != nullptr) *error = pbd::detail::must_be(field, rule, value);
  return false;
}

bool refuse_null(std::string* error, const char* field, const char* rule) {
  if (error != nullptr) *error = pbd::detail::must_be(field, rule, "null");
  return false;
}

bool size_ok(double value) { return value > 0.0 && value <= kMaxSize; }
constexpr const char* kSizeRule = "> 0 and at most 1e6 m";

struct Validator {
  std::string* error;

  bool operator()(const Sphere& s) const {
    return size_ok(s.radius) || fail(error, "Sphere.radius", s.radius, kSizeRule);
  }
  bool operator()(const Capsule& c) const {
    if (!size_ok(c.radius)) return fail(error, "Capsule.radius", c.radius, kSizeRule);
    return size_ok(c.half_height) || fail(error, "Capsule.half_height", c.half_height, kSizeRule);
  }
  bool operator()(const Box& b) const {
    for (int i = 0; i < 3; ++i) {
      if (!size_ok(b.half_extents[i])) {
        return fail(error, "Box.half_extents", b.half_extents[i], kSizeRule);
      }
    }
    return true;
  }
  bool operator()(const Cylinder& c) const {
    if (!size_ok(c.radius)) return fail(error, "Cylinder.radius", c.radius, kSizeRule);
    return size_ok(c.half_height) || fail(error, "Cylinder.half_height", c.half_height, kSizeRule);
  }
  bool operator()(const Cone& c) const {
    if (!size_ok(c.radius)) return fail(error, "Cone.radius", c.radius, kSizeRule);
    return size_ok(c.half_height) || fail(error, "Cone.half_height", c.half_height, kSizeRule);
  }
  bool operator()(const Hull& h) const {
    return h != nullptr || refuse_null(error, "Hull", "a hull made by ConvexHull::make");
  }
  bool operator()(const Field& f) const {
    return f != nullptr || refuse_null(error, "Field", "a field made by HeightField::make");
  }
  bool operator()(const HalfSpace& h) const {
    const double norm = h.normal.norm();
    if (!(std::abs(norm - 1.0) < 1e-6)) {
      return fail(error, "HalfSpace.normal", norm, "of unit length (within 1e-6)");
    }
    return std::isfinite(h.offset) || fail(error, "HalfSpace.offset", h.offset, "finite");
  }
  bool operator()(const Mesh& m) const {
    return m != nullptr || refuse_null(error, "Mesh", "a mesh made by TriangleMesh::make");
  }
};

Mat3 diagonal(double x, double y, double z) { return Vec3(x, y, z).asDiagonal(); }

struct Weigher {
  double density;

  MassProperties operator()(const Sphere& s) const {
    const double r2 = s.radius * s.radius;
    const double mass = density * 4.0 / 3.0 * std::numbers::pi * r2 * s.radius;
    const double i = 0.4 * mass * r2;
    return {mass, Vec3::Zero(), diagonal(i, i, i)};
  }
  MassProperties operator()(const Box& b) const {
    const Vec3 h2 = b.half_extents.cwiseProduct(b.half_extents);
    const double mass = density * 8.0 * b.half_extents.prod();
    const double third = mass / 3.0;
    return {
        mass, Vec3::Zero(),
        diagonal(third * (h2.y() + h2.z()), third * (h2.z() + h2.x()), third * (h2.x() + h2.y()))};
  }
  MassProperties operator()(const Capsule& c) const {
    const double r2 = c.radius * c.radius;
    const double length = 2.0 * c.half_height;
    const double cylinder = density * std::numbers::pi * r2 * length;
    const double ball = density * 4.0 / 3.0 * std::numbers::pi * r2 * c.radius;
    // Each half ball: 83/320 m r^2 about its own centroid, which is 3/8 r beyond the segment; moved
    // to the middle this gives 2/5 r^2 + L^2/4 + 3/8 L r for both.
    const double side = cylinder * (length * length / 12.0 + 0.25 * r2) +
                        ball * (0.4 * r2 + 0.25 * length * length + 0.375 * length * c.radius);
    const double axial = 0.5 * cylinder * r2 + 0.4 * ball * r2;
    return {cylinder + ball, Vec3::Zero(), diagonal(side, side, axial)};
  }
  MassProperties operator()(const Cylinder& c) const {
    const double r2 = c.radius * c.radius;
    const double mass = density * std::numbers::pi * r2 * 2.0 * c.half_height;
    const double side = mass * (0.25 * r2 + c.half_height * c.half_height / 3.0);
    return {mass, Vec3::Zero(), diagonal(side, side, 0.5 * mass * r2)};
  }
  MassProperties operator()(const Cone& c) const {
    const double r2 = c.radius * c.radius;
    const double height = 2.0 * c.half_height;
    const double mass = density * std::numbers::pi * r2 * height / 3.0;
    // 3/80 m (4 r^2 + H^2) about the centre of mass, a quarter of the height above the base.
    const double side = 0.0375 * mass * (4.0 * r2 + height * height);
    return {mass, Vec3(0, 0, -0.5 * c.half_height), diagonal(side, side, 0.3 * mass * r2)};
  }
  MassProperties operator()(const Hull& h) const {
    const Mat3 covariance = density * h->second_moment();
    return {density * h->volume(), h->centre(), covariance.trace() * Mat3::Identity() - covariance};
  }
  MassProperties operator()(const Field&) const {
    pbd::detail::refuse("mass_properties: shape", "one of finite volume", "a HeightField");
  }
  MassProperties operator()(const HalfSpace&) const {
    pbd::detail::refuse("mass_properties: shape", "one of finite volume", "a HalfSpace");
  }
  MassProperties operator()(const Mesh& m) const {
    if (!m->closed()) {
      pbd::detail::refuse("mass_properties: shape", "a closed mesh", "a Mesh with a border");
    }
    // Sum of signed tetrahedra from a corner of the mesh, to limit round-off far from the origin.
    const Vec3 origin = m->vertices()[0];
    double volume = 0.0;
    Vec3 first = Vec3::Zero();
    Mat3 second = Mat3::Zero();
    for (const TriangleMesh::Triangle& t : m->triangles()) {
      const Vec3 a = m->vertices()[t[0]] - origin;
      const Vec3 b = m->vertices()[t[1]] - origin;
      const Vec3 c = m->vertices()[t[2]] - origin;
      const double v = a.dot(b.cross(c)) / 6.0;
      const Vec3 sum = a + b + c;
      volume += v;
      first += 0.25 * v * sum;
      // Integral of x x^T over a tetrahedron with one corner at the origin.
      second += v / 20.0 *
                (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose());
    }
    if (!(volume > 0.0)) {
      pbd::detail::refuse("mass_properties: volume of the mesh", "> 0 m^3 (fronts point outwards)",
                          volume);
    }
    const Vec3 com = first / volume;
    const Mat3 covariance = density * (second - volume * com * com.transpose());
    return {density * volume, origin + com, covariance.trace() * Mat3::Identity() - covariance};
  }
};

}  // namespace

bool validate(const Shape& shape, std::string* error) {
  return std::visit(Validator{error}, shape);
}

MassProperties mass_properties(const Shape& shape, double density) {
  std::string error;
  if (!validate(shape, &error)) throw std::invalid_argument("mass_properties: " + error);
  if (!(density > 0.0) || !std::isfinite(density)) {
    pbd::detail::refuse("mass_properties: density", "finite and > 0", density);
  }
  MassProperties p = std::visit(Weigher{density}, shape);
  if (!std::isfinite(p.mass) || !p.inertia.allFinite()) {
    pbd::detail::refuse("mass_properties: density",
                        "such that mass and inertia of the shape are finite", density);
  }
  return p;
}

}  // namespace tandem::collision
