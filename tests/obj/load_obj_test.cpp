// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/obj/load_obj.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <sstream>

#include "support/catch.h"

namespace load_obj_test {

using namespace tandem;
using Catch::Contains;
using collision::Mesh;
using collision::TriangleMesh;
using pbd::Vec3;

namespace {

constexpr const char* kCube = R"(# a cube of edge 2
mtllib none.mtl
o cube
v -1 -1 -1
v  1 -1 -1
v  1  1 -1
v -1  1 -1
v -1 -1  1
v  1 -1  1 0.5 0.5 0.5
v  1  1  1
v -1  1  1
vn 0 0 1
vt 0 0
g ends
f 4 3 2 1
f 5/1/1 6/1/1 7/1/1 8/1/1
usemtl nothing
g sides
s off
f 1//1 2//1 6//1 5//1
f -6 -5 -1 -2
f 2 3 7 6
f 1/1 5/1 8/1 4/1
)";

Mesh parse(const std::string& text) { return obj::parse_obj(text, "test.obj"); }

double area(const TriangleMesh& mesh) {
  double sum = 0.0;
  for (const auto& t : mesh.triangles()) {
    const Vec3& a = mesh.vertices()[t[0]];
    sum += 0.5 * (mesh.vertices()[t[1]] - a).cross(mesh.vertices()[t[2]] - a).norm();
  }
  return sum;
}

std::string refused(const std::string& text) {
  try {
    obj::parse_obj(text, "test.obj", {.strict = true});
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "accepted";
}

}  // namespace

TEST_CASE("load_obj: a cube of quads in groups, with all forms of corners", "[obj]") {
  const std::string text = kCube;
  const Mesh mesh = parse(text);
  CHECK(mesh->vertices().size() == 8);
  CHECK(mesh->triangles().size() == 12);
  CHECK(mesh->closed());
  const auto weight = collision::mass_properties(collision::Shape(mesh), 1000.0);
  CHECK(weight.mass == Approx(8000.0));
  CHECK(weight.com.norm() < 1e-12);

  // Windows line ends, no line end at the end.
  std::string windows;
  for (const char c : text) {
    if (c == '\n') windows.push_back('\r');
    windows.push_back(c);
  }
  windows.resize(windows.size() - 2);
  CHECK(parse(windows)->triangles().size() == 12);
}

TEST_CASE("load_obj: polygons keep their area and front, convex or not", "[obj]") {
  // An arrow head, whose shorter diagonal lies outside.
  const Mesh arrow = parse("v 0 0 0\nv 2 -2 0\nv 1 0 0\nv 2 2 0\nf 1 2 3 4\n");
  CHECK(arrow->triangles().size() == 2);
  CHECK(area(*arrow) == Approx(2.0));
  for (std::uint32_t t = 0; t < 2; ++t) CHECK(arrow->normal(t).z() == Approx(1.0));
  // The letter L, far from the origin, standing on its side, with a corner on a straight edge.
  const Mesh l = parse(
      "v 100 0 50\nv 101 0 50\nv 102 0 50\nv 102 0 51\nv 101 0 51\nv 101 0 53\nv 100 0 53\n"
      "f 1 2 3 4 5 6 7");
  CHECK(l->triangles().size() == 5);
  CHECK(area(*l) == Approx(4.0));
  for (std::uint32_t t = 0; t < 5; ++t) CHECK(l->normal(t).y() == Approx(-1.0));
  // A regular 40-gon.
  std::ostringstream many;
  for (int i = 0; i < 40; ++i) {
    many << "v " << std::cos(i * std::numbers::pi / 20) << " "
         << std::sin(i * std::numbers::pi / 20) << " 0\n";
  }
  many << "f";
  for (int i = 1; i <= 40; ++i) many << " " << i;
  const Mesh disc = parse(many.str());
  CHECK(disc->triangles().size() == 38);
  CHECK(area(*disc) == Approx(20.0 * std::sin(std::numbers::pi / 20)).epsilon(1e-5));
}

TEST_CASE("load_obj: an error is named with its line", "[obj][fault]") {
  const std::string v = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  CHECK_THAT(refused(v), Contains("test.obj: faces must be") && Contains("is none"));
  CHECK_THAT(refused(""), Contains("faces must be") && Contains("is none"));
  CHECK_THAT(refused(v + "f 1 2 4"),
             Contains("test.obj:4: vertex number must be one of the 3 vertices, is 4"));
  CHECK_THAT(refused(v + "f 1 2 -4"), Contains("test.obj:4: vertex number") && Contains("is -4"));
  CHECK_THAT(refused("f 1 2 3\n" + v), Contains("test.obj:1: vertex number") && Contains("is 1"));
  CHECK_THAT(refused(v + "\nf 0 1 2"), Contains("test.obj:5: corner") && Contains("is \"0\""));
  CHECK_THAT(refused(v + "f 1 two 3"), Contains("test.obj:4: corner") && Contains("is \"two\""));
  CHECK_THAT(refused(v + "f 1 2"), Contains("test.obj:4: number of corners") && Contains("is 2"));
  CHECK_THAT(refused("v 0 nan 0\n"), Contains("test.obj:1: y must be") && Contains("is \"nan\""));
  CHECK_THAT(refused("v 0 0 1e999\n"),
             Contains("test.obj:1: z must be") && Contains("is \"1e999\""));
  CHECK_THAT(refused("# x\nv 0 0\n"), Contains("test.obj:2: z must be") && Contains("is \"\""));
  CHECK_THAT(refused("v 0 0 zero\n"),
             Contains("z must be") && Contains("is \"zero\"") && Contains("finite number"));
  CHECK_THAT(refused(v + "v 2 0 0\nf 1 2 4"), Contains("test.obj:5: face") && Contains("an area"));
  CHECK_THAT(refused("v 0 0 0\nv 2 0 0\nv 0 1 0\nv 2 1 0\nf 1 2 3 4"), Contains("cross itself"));
  CHECK_THAT(refused(v + "f 1 2 3\nf 1 2 3"), Contains("test.obj:5") && Contains("edge"));
  std::string round = "f";
  for (int i = 1; i <= 10'000; ++i) round += " 1";
  CHECK_THAT(refused(v + round), Contains("corners of a face") && Contains("at most 256"));
  CHECK_THROWS_WITH(obj::load_obj("/dev/zero"), Contains("size") && Contains("2^28"));
  CHECK_THROWS_WITH(obj::load_obj("no/such/file.obj"),
                    Contains("no/such/file.obj: file") && Contains("can be read"));
  CHECK_THROWS_WITH(obj::parse_obj(v + "f 1 2 3", "test.obj", {.scale = 0.0}),
                    Contains("scale must be") && Contains("is 0"));
}

TEST_CASE("load_obj: faces with faults are left out and told with their lines", "[obj]") {
  const auto left_out = [](const std::string& text, std::size_t triangles) {
    std::vector<std::string> told;
    const Mesh mesh = obj::parse_obj(text, "test.obj", {.warnings = &told});
    CHECK(mesh->triangles().size() == triangles);
    REQUIRE(told.size() == 1);
    CHECK_FALSE(refused(text).empty());
    return told[0];
  };
  const std::string v = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  // Two corners in one place, and a bow tie.
  CHECK_THAT(left_out(v + "v 0 0 0\nf 1 2 3\nf 1 4 2\n", 1), Contains("test.obj: line 6: faces"));
  CHECK_THAT(left_out("v 0 0 0\nv 2 0 0\nv 0 1 0\nv 2 1 0\nv 1 5 0\nf 1 2 3 4\nf 1 2 5\n", 1),
             Contains("line 6: faces") && Contains("cross themselves"));
  // Three triangles at one edge, by numbers and by positions.
  CHECK_THAT(left_out(v + "v 0 -1 0\nv 0 0 1\nf 1 2 3\nf 2 1 4\nf 1 2 5\n", 2),
             Contains("line 8: triangles with another one"));
  CHECK_THAT(left_out(v + "v 0 0 1\nv 0 0 0\nv 1 0 0\nf 1 2 3\nf 5 6 4\n", 1),
             Contains("line 8: triangles with another one"));
  // Nothing is left.
  CHECK_THROWS(parse(v + "v 0 0 0\nf 1 4 2\n"));
}

TEST_CASE("load_obj: two quads with three corners in common are cut along two diagonals", "[obj]") {
  // Both are a little shorter from the first corner to the third.
  const std::string text =
      "v 0 0 0\nv 0.5 -1.2 0.3\nv 1 0 0\nv 0.5 0 -0.3\nv 0.5 1.2 0.3\nf 1 2 3 4\nf 1 4 3 5\n";
  std::vector<std::string> told;
  const Mesh mesh = obj::parse_obj(text, "test.obj", {.strict = true, .warnings = &told});
  CHECK(mesh->triangles().size() == 4);
  CHECK(told.empty());
  std::size_t joined = 0;
  for (std::uint32_t t = 0; t < 4; ++t) {
    for (int k = 0; k < 3; ++k) joined += mesh->neighbour(t, k) != TriangleMesh::kNone;
  }
  // Two diagonals and the two edges in common, from both sides.
  CHECK(joined == 8);
}

TEST_CASE("load_obj: a file has no more points and triangles than it may", "[obj][fault]") {
  const std::string text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
  CHECK(obj::parse_obj(text, "quad", {.points = 4, .triangles = 2})->vertex_count() == 4);
  CHECK_THROWS_WITH(obj::parse_obj(text, "quad", {.points = 3}),
                    Catch::Contains("points") && Catch::Contains("at most 3 (ObjOptions::points)"));
  CHECK_THROWS_WITH(obj::parse_obj(text, "quad", {.triangles = 1}),
                    Catch::Contains("at most 1 (ObjOptions::triangles)"));
}

TEST_CASE("load_obj: a file, a stream and a string give the same mesh", "[obj]") {
  const auto path = std::filesystem::temp_directory_path() / "tandem_load_obj_test.obj";
  std::ofstream(path) << kCube;
  const Mesh file = obj::load_obj(path, {.scale = 0.5});
  std::filesystem::remove(path);
  std::istringstream stream(kCube);
  const Mesh streamed = obj::read_obj(stream, "stream", {.scale = 0.5});
  REQUIRE(file->triangles().size() == streamed->triangles().size());
  for (std::size_t t = 0; t < file->triangles().size(); ++t) {
    CHECK(file->triangles()[t] == streamed->triangles()[t]);
  }
  CHECK(file->bounds().max == Vec3(0.5, 0.5, 0.5));
}

}  // namespace load_obj_test
