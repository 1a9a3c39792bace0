// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/collision/shape.h"

#include <numbers>

#include "fixture.h"
#include "tandem/collision/compound.h"

namespace shape_test {

using namespace tandem::collision;
using namespace tandem::collision::testing;
using Catch::Contains;
using tandem::pbd::Mat3;

namespace {

std::string error_of(const Shape& shape) {
  std::string error;
  REQUIRE_FALSE(validate(shape, &error));
  return error;
}

bool close(const Mat3& l, const Mat3& r, double tolerance) {
  return (l - r).cwiseAbs().maxCoeff() <= tolerance;
}

}  // namespace

TEST_CASE("shape: sizes that are no sizes are refused by name, value and rule",
          "[collision][fault]") {
  CHECK_THAT(error_of(Sphere{-1.0}),
             Contains("Sphere.radius") && Contains("-1") && Contains("> 0"));
  CHECK_THAT(error_of(Sphere{NAN}), Contains("Sphere.radius") && Contains("nan"));
  CHECK_THAT(error_of(Box{Vec3(1, 0, 1)}), Contains("Box.half_extents"));
  CHECK_THAT(error_of(Capsule{0.1, 0.0}), Contains("Capsule.half_height"));
  CHECK_THAT(error_of(Capsule{INFINITY, 1.0}), Contains("Capsule.radius"));
  CHECK_THAT(error_of(HalfSpace{Vec3(0, 0, 2), 0.0}),
             Contains("HalfSpace.normal") && Contains("2"));
  CHECK_THAT(error_of(HalfSpace{Vec3::UnitZ(), NAN}), Contains("HalfSpace.offset"));
  CHECK_THAT(error_of(Mesh{}), Contains("Mesh"));
  CHECK(validate(Sphere{0.1}));
}

TEST_CASE("shape: masses are the closed forms", "[collision][analytic]") {
  const double pi = std::numbers::pi;
  const MassProperties ball = mass_properties(Sphere{0.5}, 1000.0);
  CHECK(ball.mass == Approx(1000.0 * pi / 6.0));
  CHECK(close(ball.inertia, Mat3(Mat3::Identity() * 0.4 * ball.mass * 0.25), 1e-9));

  const MassProperties box = mass_properties(Box{Vec3(0.5, 1.0, 1.5)}, 2.0);
  CHECK(box.mass == Approx(12.0));
  CHECK(close(box.inertia, Mat3(Vec3(13.0, 10.0, 5.0).asDiagonal()), 1e-9));

  // Independent of the closed form: the solid of revolution, summed in thin discs.
  const double r = 0.3;
  const double h = 0.7;
  double mass = 0.0;
  double axial = 0.0;
  double side = 0.0;
  const int discs = 200000;
  for (int i = 0; i < discs; ++i) {
    const double dz = 2.0 * (h + r) / discs;
    const double z = -(h + r) + (i + 0.5) * dz;
    const double over = std::max(0.0, std::abs(z) - h);
    const double r2 = r * r - over * over;
    const double dm = 5.0 * pi * r2 * dz;
    mass += dm;
    axial += 0.5 * dm * r2;
    side += dm * (0.25 * r2 + z * z);
  }
  const MassProperties capsule = mass_properties(Capsule{r, h}, 5.0);
  CHECK(capsule.mass == Approx(mass).epsilon(1e-8));
  CHECK(close(capsule.inertia, Mat3(Vec3(side, side, axial).asDiagonal()), 1e-8 * side));
}

TEST_CASE("shape: a closed mesh has the solid's mass at any place", "[collision][analytic]") {
  const Vec3 half(0.5, 1.0, 1.5);
  const MassProperties solid = mass_properties(Box{half}, 2.0);
  const MassProperties mesh = mass_properties(box_mesh(half), 2.0);
  CHECK(mesh.mass == Approx(solid.mass));
  CHECK(mesh.com.norm() < 1e-12);
  CHECK(close(mesh.inertia, solid.inertia, 1e-10));

  const Mesh centred = box_mesh(half);
  std::vector<Vec3> moved(centred->vertices().begin(), centred->vertices().end());
  for (Vec3& v : moved) v += Vec3(1000, -2000, 500);
  const MassProperties far = mass_properties(TriangleMesh::make(moved, centred->triangles()), 2.0);
  CHECK((far.com - Vec3(1000, -2000, 500)).norm() < 1e-9);
  CHECK(close(far.inertia, solid.inertia, 1e-8));
}

TEST_CASE("shape: shapes without volume have no mass", "[collision][fault]") {
  CHECK_THROWS_WITH(mass_properties(HalfSpace{}, 1.0), Contains("finite volume"));
  CHECK_THROWS_WITH(mass_properties(flat_mesh(1.0, 1), 1.0), Contains("closed mesh"));
  CHECK_THROWS_WITH(mass_properties(Sphere{1.0}, 0.0), Contains("density") && Contains("> 0"));
  const Mesh box = box_mesh(Vec3::Ones());
  std::vector<TriangleMesh::Triangle> turned(box->triangles().begin(), box->triangles().end());
  for (auto& t : turned) std::swap(t[0], t[1]);
  CHECK_THROWS_WITH(mass_properties(TriangleMesh::make(box->vertices(), turned), 1.0),
                    Contains("-8"));
}

TEST_CASE("shape: a density that gives no finite mass or inertia is refused",
          "[collision][fault]") {
  const Vec3 half = Vec3::Constant(0.9);
  std::vector<Vec3> corners;
  for (const double x : {-0.9, 0.9}) {
    for (const double y : {-0.9, 0.9}) {
      for (const double z : {-0.9, 0.9}) corners.emplace_back(x, y, z);
    }
  }
  const Hull hull = ConvexHull::make(corners);
  for (const Shape& shape :
       {Shape(Sphere{0.9}), Shape(Box{half}), Shape(Capsule{0.9, 0.9}), Shape(Cylinder{0.9, 0.9}),
        Shape(Cone{0.9, 0.9}), Shape(hull), Shape(box_mesh(half))}) {
    CAPTURE(shape.index());
    // The same shape of a density that is merely large weighs what it must: mass is linear in it.
    const MassProperties light = mass_properties(shape, 1.0);
    const MassProperties heavy = mass_properties(shape, 1e300);
    CHECK(heavy.mass / 1e300 == Approx(light.mass));
    CHECK(close(heavy.inertia / 1e300, light.inertia, 1e-12));
    CHECK_THROWS_WITH(mass_properties(shape, 1e308),
                      Contains("mass_properties: density") && Contains("1e+308") &&
                          Contains("mass and inertia of the shape are finite"));
  }
  // At 8e303 kg the mass is a number, and the inertia of 5e313 kg m^2 is none.
  const Box large{Vec3::Constant(1e5)};
  CHECK(mass_properties(large, 1e278).inertia(0, 0) == Approx(16.0 / 3.0 * 1e303));
  CHECK_THROWS_WITH(mass_properties(large, 1e288),
                    Contains("mass_properties: density") && Contains("1e+288"));
}

TEST_CASE("compound: parts with a sum that is not finite are refused", "[collision][fault]") {
  const auto boxes = [](std::size_t count, double density, double apart) {
    std::vector<CompoundPart> parts;
    for (std::size_t i = 0; i < count; ++i) {
      const double x = apart * (static_cast<double>(i) - 0.5 * static_cast<double>(count - 1));
      parts.push_back({Box{Vec3::Constant(0.5)}, at(x, 0, 0), density});
    }
    return parts;
  };
  // A cubic metre each: eight of 2e307 kg stay below the largest number, 1.8e308, ten do not.
  CHECK(mass_properties(boxes(8, 2e307, 1e-3)).mass == Approx(1.6e308));
  CHECK_THROWS_WITH(
      mass_properties(boxes(10, 2e307, 1e-3)),
      Contains("mass_properties: mass of all parts") && Contains("inf") && Contains("finite"));
  CHECK_THROWS_WITH(
      mass_properties(boxes(2, 1e300, 1e5)),
      Contains("mass_properties: inertia of all parts") && Contains("inf") && Contains("finite"));
  std::vector<CompoundPart> far = boxes(1, 1e300, 0.0);
  far[0].local.position.x() = 1e10;
  CHECK_THROWS_WITH(mass_properties(far), Contains("centre of mass of all parts") &&
                                              Contains("inf") && Contains("finite"));
  // Nothing at all has no centre.
  std::vector<CompoundPart> dust{{Box{Vec3::Constant(1e-3)}, {}, 1e-320}};
  CHECK_THROWS_WITH(mass_properties(dust),
                    Contains("mass of all parts must be") && Contains("is 0") && Contains("> 0"));
  // A part that is none by itself is named.
  std::vector<CompoundPart> parts = boxes(2, 1.0, 1.0);
  parts[1].density = 1e308;
  CHECK_THROWS_WITH(mass_properties(parts),
                    Contains("parts[1]") && Contains("density") && Contains("1e+308"));
}

TEST_CASE("triangle_mesh: input that is no surface is refused by name", "[collision][fault]") {
  const std::vector<Vec3> v{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(2, 0, 0)};
  using T = std::vector<TriangleMesh::Triangle>;
  CHECK_THROWS_WITH(TriangleMesh::make(v, T{}), Contains("at least one"));
  CHECK_THROWS_WITH(TriangleMesh::make(v, T{{0, 1, 4}}), Contains("triangles[0]") && Contains("4"));
  CHECK_THROWS_WITH(TriangleMesh::make(v, T{{0, 1, 2}, {0, 1, 3}}),
                    Contains("triangles[1]") && Contains("area"));
  CHECK_THROWS_WITH(TriangleMesh::make(v, T{{0, 1, 2}, {1, 2, 0}}), Contains("edge"));
  const std::vector<Vec3> bad{Vec3(0, 0, 0), Vec3(1, NAN, 0), Vec3(0, 1, 0)};
  CHECK_THROWS_WITH(TriangleMesh::make(bad, T{{0, 1, 2}}),
                    Contains("vertices[1]") && Contains("finite"));
}

TEST_CASE("triangle_mesh: triangles that repeat their corners still know their neighbours",
          "[collision][unit]") {
  const std::vector<Vec3> soup{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(1, 1, 0),
                               Vec3(0, 0, 0), Vec3(1, 1, 0), Vec3(0, 1, 0)};
  const std::vector<TriangleMesh::Triangle> t{{0, 1, 2}, {3, 4, 5}};
  const Mesh mesh = TriangleMesh::make(soup, t);
  CHECK(mesh->vertices().size() == 4);
  CHECK(mesh->neighbour(0, 2) == 1);  // the diagonal
  CHECK(mesh->neighbour(1, 0) == 0);
  CHECK(mesh->neighbour(0, 0) == TriangleMesh::kNone);
  CHECK(mesh->edge_id(0, 2) == mesh->edge_id(1, 0));
  CHECK_FALSE(mesh->closed());
  CHECK(box_mesh(Vec3::Ones())->closed());
  CHECK(mesh->ring(0).size() == 3);
}

TEST_CASE("triangle_mesh: the search tree finds the same as a search of all triangles",
          "[collision][unit]") {
  const Mesh mesh = flat_mesh(10.0, 17);
  Random random(3);
  for (int k = 0; k < 200; ++k) {
    const Vec3 middle{random.in(-6, 6), random.in(-6, 6), random.in(-0.5, 0.5)};
    const Vec3 half{random.in(0, 1), random.in(0, 1), random.in(0, 0.3)};
    const Aabb box{middle - half, middle + half};
    std::vector<std::uint32_t> found;
    mesh->query(box, found);
    std::vector<std::uint32_t> expected;
    for (std::uint32_t t = 0; t < mesh->triangles().size(); ++t) {
      Aabb bounds{Vec3::Constant(1e9), Vec3::Constant(-1e9)};
      for (const std::uint32_t v : mesh->triangles()[t]) {
        bounds = bounds.merged({mesh->vertices()[v], mesh->vertices()[v]});
      }
      if (bounds.overlaps(box)) expected.push_back(t);
    }
    CHECK(found == expected);
  }
}

}  // namespace shape_test
