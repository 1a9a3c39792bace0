// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "recording/shape_mesh.h"

#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "support/catch.h"

namespace tandem::demos::shape_mesh_test {
namespace {

using pbd::Vec3;

Vec3 corner(const std::vector<float>& values, std::uint32_t index) {
  return {values[3 * index], values[3 * index + 1], values[3 * index + 2]};
}

/// m^3, by the divergence theorem: right for closed surfaces whose triangles look outwards.
double enclosed(const ShapeMesh& mesh) {
  double sum = 0.0;
  for (std::size_t t = 0; t + 2 < mesh.indices.size(); t += 3) {
    const Vec3 a = corner(mesh.positions, mesh.indices[t]);
    const Vec3 b = corner(mesh.positions, mesh.indices[t + 1]);
    const Vec3 c = corner(mesh.positions, mesh.indices[t + 2]);
    sum += a.dot(b.cross(c)) / 6.0;
    for (int k = 0; k < 3; ++k) {
      const Vec3 normal = corner(mesh.normals, mesh.indices[t + k]);
      CHECK(std::abs(normal.norm() - 1.0) < 1e-5);
      CHECK(normal.dot((b - a).cross(c - a)) >= 0.0);
    }
  }
  return sum;
}

TEST_CASE("shape mesh: the drawn mesh encloses the shape's volume and faces outwards",
          "[demos][analytic]") {
  const std::array<Vec3, 5> pyramid = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(1, 1, 0), Vec3(0, 1, 0),
                                       Vec3(0.5, 0.5, 3.0)};
  const std::vector<collision::Shape> flat = {collision::Box{Vec3(0.1, 0.2, 0.3)},
                                              collision::ConvexHull::make(pyramid)};
  for (const collision::Shape& shape : flat) {
    const double volume = collision::mass_properties(shape, 1.0).mass;
    CHECK(enclosed(shape_mesh(shape)) == Approx(volume).epsilon(1e-5));
  }
  // A circle of 24 corners has this part of its area; a ball is also cut along its height.
  const double circle = 12.0 / std::numbers::pi * std::sin(std::numbers::pi / 12.0);
  const std::vector<collision::Shape> round = {collision::Cylinder{0.3, 0.5},
                                               collision::Cone{0.3, 0.5}};
  for (const collision::Shape& shape : round) {
    const double volume = collision::mass_properties(shape, 1.0).mass;
    CHECK(enclosed(shape_mesh(shape)) == Approx(circle * volume).epsilon(1e-5));
  }
  const std::vector<collision::Shape> balls = {collision::Sphere{0.4},
                                               collision::Capsule{0.25, 0.5}};
  for (const collision::Shape& shape : balls) {
    const double volume = collision::mass_properties(shape, 1.0).mass;
    const double drawn = enclosed(shape_mesh(shape));
    CHECK(drawn < volume);
    CHECK(drawn > 0.96 * volume);
  }
}

TEST_CASE("shape mesh: planes and height fields lie where they are", "[demos]") {
  const Vec3 normal = Vec3(1.0, 2.0, 2.0) / 3.0;
  const ShapeMesh plane = shape_mesh(collision::HalfSpace{normal, 0.7}, 4.0);
  for (std::uint32_t v = 0; v < plane.positions.size() / 3; ++v) {
    CHECK(corner(plane.positions, v).dot(normal) == Approx(0.7).margin(1e-5));
  }
  const std::array<double, 4> heights = {0.0, 0.0, 1.0, 1.0};
  const ShapeMesh field = shape_mesh(collision::HeightField::make(2, 2, 1.0, 1.0, heights));
  CHECK(field.indices.size() == 6);
  for (std::uint32_t v = 0; v < field.positions.size() / 3; ++v) {
    const Vec3 at = corner(field.positions, v);
    CHECK(at.z() == Approx(at.y()).margin(1e-6));
  }
}

}  // namespace
}  // namespace tandem::demos::shape_mesh_test
