// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "recording/shape_mesh.h"

#include <array>
#include <cmath>
#include <numbers>
#include <span>

namespace tandem::demos {
namespace {

using pbd::Vec3;

constexpr int kAround = 24;  ///< corners of a circle
constexpr int kUp = 12;      ///< rings from pole to pole

class Builder {
 public:
  std::uint32_t corner(const Vec3& position, const Vec3& normal) {
    for (int k = 0; k < 3; ++k) {
      mesh_.positions.push_back(static_cast<float>(position[k]));
      mesh_.normals.push_back(static_cast<float>(normal[k]));
    }
    return static_cast<std::uint32_t>(mesh_.positions.size() / 3 - 1);
  }
  void triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    mesh_.indices.insert(mesh_.indices.end(), {a, b, c});
  }
  /// A flat face with unshared corners, counter-clockwise from outside.
  void face(std::span<const Vec3> corners, const Vec3& normal) {
    std::vector<std::uint32_t> made;
    for (const Vec3& position : corners) made.push_back(corner(position, normal));
    for (std::size_t i = 2; i < made.size(); ++i) triangle(made[0], made[i - 1], made[i]);
  }
  ShapeMesh done() { return std::move(mesh_); }

 private:
  ShapeMesh mesh_;
};

Vec3 around(int step) {
  const double angle = 2.0 * std::numbers::pi * step / kAround;
  return {std::cos(angle), std::sin(angle), 0.0};
}

/// A ball cut at its equator, the halves `apart` (m) along z.
ShapeMesh ball(double radius, double apart) {
  Builder b;
  std::vector<std::uint32_t> ring;
  const auto add_ring = [&](double latitude, double z) {
    std::vector<std::uint32_t> next;
    for (int i = 0; i <= kAround; ++i) {
      const Vec3 normal = std::cos(latitude) * around(i) + std::sin(latitude) * Vec3::UnitZ();
      next.push_back(b.corner(radius * normal + z * Vec3::UnitZ(), normal));
    }
    for (std::size_t i = 0; !ring.empty() && i < kAround; ++i) {
      b.triangle(ring[i], ring[i + 1], next[i + 1]);
      b.triangle(ring[i], next[i + 1], next[i]);
    }
    ring = next;
  };
  for (int k = 0; k <= kUp; ++k) {
    const double latitude = std::numbers::pi * (static_cast<double>(k) / kUp - 0.5);
    if (2 * k <= kUp) add_ring(latitude, -0.5 * apart);
    if (2 * k >= kUp && apart > 0.0) add_ring(latitude, 0.5 * apart);
    if (2 * k > kUp && !(apart > 0.0)) add_ring(latitude, 0.0);
  }
  return b.done();
}

ShapeMesh box(const Vec3& half) {
  Builder b;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      const Vec3 normal = side * Vec3::Unit(axis);
      const Vec3 u = Vec3::Unit((axis + 1) % 3);
      const Vec3 v = normal.cross(u);
      const std::array<Vec3, 4> corners = {
          (normal - u - v).cwiseProduct(half), (normal + u - v).cwiseProduct(half),
          (normal + u + v).cwiseProduct(half), (normal - u + v).cwiseProduct(half)};
      b.face(corners, normal);
    }
  }
  return b.done();
}

/// A frustum about z; the upper disc may be a point.
ShapeMesh frustum(double lower, double upper, double half_height) {
  Builder b;
  const Vec3 up = half_height * Vec3::UnitZ();
  std::vector<Vec3> below, above;
  std::array<std::uint32_t, 2> last{};
  const double slope = (lower - upper) / (2.0 * half_height);
  for (int i = 0; i <= kAround; ++i) {
    const Vec3 out = around(i);
    const Vec3 normal = (out + slope * Vec3::UnitZ()).normalized();
    const std::array<std::uint32_t, 2> next = {b.corner(lower * out - up, normal),
                                               b.corner(upper * out + up, normal)};
    if (i > 0) {
      b.triangle(last[0], next[0], next[1]);
      if (upper > 0.0) b.triangle(last[0], next[1], last[1]);
    }
    last = next;
    if (i == kAround) continue;
    below.insert(below.begin(), lower * out - up);
    above.push_back(upper * out + up);
  }
  b.face(below, -Vec3::UnitZ());
  if (upper > 0.0) b.face(above, Vec3::UnitZ());
  return b.done();
}

ShapeMesh plane(const collision::HalfSpace& half_space, double extent) {
  Builder b;
  const Vec3 u = half_space.normal.unitOrthogonal();
  const Vec3 v = half_space.normal.cross(u);
  const Vec3 foot = half_space.offset * half_space.normal;
  const double h = 0.5 * extent;
  const std::array<Vec3, 4> corners = {foot - h * u - h * v, foot + h * u - h * v,
                                       foot + h * u + h * v, foot - h * u + h * v};
  b.face(corners, half_space.normal);
  return b.done();
}

ShapeMesh hull(const collision::ConvexHull& hull) {
  Builder b;
  for (const collision::ConvexHull::Face& face : hull.faces()) {
    std::vector<Vec3> corners;
    for (const std::uint32_t v : hull.face_corners(face)) {
      corners.push_back(hull.centre() + hull.arms()[v]);
    }
    b.face(corners, face.normal);
  }
  return b.done();
}

template <class Surface>
ShapeMesh surface(const Surface& from, std::uint32_t triangles) {
  Builder b;
  for (std::uint32_t t = 0; t < triangles; ++t) {
    const auto corners = from.corners(t);
    const std::array<Vec3, 3> places = {from.vertex(corners[0]), from.vertex(corners[1]),
                                        from.vertex(corners[2])};
    b.face(places, from.normal(t));
  }
  return b.done();
}

}  // namespace

ShapeMesh shape_mesh(const collision::Shape& shape, double extent) {
  struct Visitor {
    double extent;
    ShapeMesh operator()(const collision::Sphere& s) const { return ball(s.radius, 0.0); }
    ShapeMesh operator()(const collision::Capsule& s) const {
      return ball(s.radius, 2.0 * s.half_height);
    }
    ShapeMesh operator()(const collision::Box& s) const { return box(s.half_extents); }
    ShapeMesh operator()(const collision::HalfSpace& s) const { return plane(s, extent); }
    ShapeMesh operator()(const collision::Mesh& s) const {
      return surface(*s, static_cast<std::uint32_t>(s->triangles().size()));
    }
    ShapeMesh operator()(const collision::Cylinder& s) const {
      return frustum(s.radius, s.radius, s.half_height);
    }
    ShapeMesh operator()(const collision::Cone& s) const {
      return frustum(s.radius, 0.0, s.half_height);
    }
    ShapeMesh operator()(const collision::Hull& s) const { return hull(*s); }
    ShapeMesh operator()(const collision::Field& s) const {
      return surface(*s, s->triangle_count());
    }
  };
  return std::visit(Visitor{extent}, shape);
}

}  // namespace tandem::demos
