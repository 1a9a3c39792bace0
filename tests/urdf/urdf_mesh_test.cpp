// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Meshes of robots: STL and OBJ below the folders that the caller names, as hulls.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "support/bodies.h"
#include "support/catch.h"
#include "support/folder.h"
#include "tandem/pbd/random.h"
#include "tandem/urdf.h"

namespace urdf_mesh_test {
namespace {

using namespace tandem;
using tandem::testing::Folder;
using tandem::testing::refusal;

using Triangle = std::array<Vec3, 3>;

/// STL of a box with a corner at 0 and one at `size`.
std::vector<Triangle> box(const Vec3& size) {
  const auto corner = [&](int i) {
    return Vec3((i & 1) != 0 ? size.x() : 0.0, (i & 2) != 0 ? size.y() : 0.0,
                (i & 4) != 0 ? size.z() : 0.0);
  };
  constexpr int kFaces[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  std::vector<Triangle> out;
  for (const auto& f : kFaces) {
    out.push_back({corner(f[0]), corner(f[1]), corner(f[2])});
    out.push_back({corner(f[0]), corner(f[2]), corner(f[3])});
  }
  return out;
}

void put(std::string& out, std::uint32_t value) {
  for (int i = 0; i < 4; ++i) out += static_cast<char>(value >> (8 * i) & 0xffu);
}
std::string binary_stl(const std::vector<Triangle>& triangles) {
  std::string out = "solid by some exporters, though it is binary";
  out.resize(80, ' ');
  put(out, static_cast<std::uint32_t>(triangles.size()));
  for (const Triangle& t : triangles) {
    for (int i = 0; i < 3; ++i) put(out, 0x7fc00000u);  // a normal that is none
    for (const Vec3& p : t) {
      for (const double x : p) put(out, std::bit_cast<std::uint32_t>(static_cast<float>(x)));
    }
    out += std::string(2, '\x7f');
  }
  return out;
}
std::string text_of(const Vec3& p) {
  std::string out;
  for (const double x : p) out.append(1, ' ').append(std::to_string(x));
  return out;
}
std::string text_stl(const std::vector<Triangle>& triangles) {
  std::string out = "solid a box\n";
  for (const Triangle& t : triangles) {
    out += "  FACET normal nan 0 0\r\n    outer loop\n";
    for (const Vec3& p : t) out.append("vertex").append(text_of(p)).append(1, '\n');
    out += "    endloop\n  endfacet\n";
  }
  return out + "endsolid a box\n";
}
std::string obj(const std::vector<Triangle>& triangles) {
  std::string out;
  for (const Triangle& t : triangles) {
    for (const Vec3& p : t) out.append(1, 'v').append(text_of(p)).append(1, '\n');
    out += "f -3 -2 -1\n";
  }
  return out;
}

/// A body of 1 kg with these meshes, each with its scale.
std::string robot(const std::vector<std::pair<std::string, std::string>>& meshes) {
  std::string out =
      "<robot name='r'><link name='l'><inertial><mass value='1'/><inertia ixx='.1' iyy='.1' "
      "izz='.1' ixy='0' ixz='0' iyz='0'/></inertial>";
  for (const auto& [file, scale] : meshes) {
    out += "<collision><geometry><mesh filename='" + file + "' scale='" + scale +
           "'/></geometry></collision>";
  }
  return out + "</link></robot>";
}
const collision::ConvexHull& hull_of(const SceneFile& file, std::uint32_t collider) {
  return *std::get<collision::Hull>(file.scene.shapes().collider({collider, 0}).shape);
}
bool is_told(const SceneFile& file, const std::string& what) {
  return std::any_of(file.warnings.begin(), file.warnings.end(), [&](const std::string& warning) {
    return warning.find(what) != std::string::npos;
  });
}

TEST_CASE("urdf mesh: STL and OBJ below a package's folder collide as their hulls", "[urdf]") {
  const Folder folder;
  std::filesystem::create_directory(folder.file("meshes"));
  const auto triangles = box(Vec3(2.0, 1.0, 0.5));
  folder.write("meshes/b.stl", binary_stl(triangles));
  folder.write("meshes/t.STL", text_stl(triangles));
  folder.write("o.obj", obj(triangles));
  const UrdfOptions options{.packages = {{"r", folder.file("")}, {"", folder.file("meshes")}}};
  const std::string scale = "0.5 1 -2";
  const SceneFile file = parse_urdf(robot({{"package://r/meshes/b.stl", scale},
                                           {"t.STL", scale},
                                           {"package://r/meshes/../o.obj", scale},
                                           {"package://r/o.obj", "1 1 1"}}),
                                    options);
  CHECK(file.warnings.empty());
  for (std::uint32_t i = 0; i < 3; ++i) {
    CAPTURE(i);
    CHECK(hull_of(file, i).points().size() == 8);
    CHECK(hull_of(file, i).volume() == Approx(1.0).epsilon(1e-6));
    CHECK((hull_of(file, i).centre() - Vec3(0.5, 0.5, -0.5)).norm() < 1e-6);
  }
  CHECK(hull_of(file, 3).volume() == Approx(1.0).epsilon(1e-6));
  CHECK((hull_of(file, 3).centre() - Vec3(1.0, 0.5, 0.25)).norm() < 1e-6);
}

TEST_CASE("urdf mesh: of balls with many corners the nearest hull is taken", "[urdf]") {
  pbd::SplitMix64 random(3);
  std::vector<Triangle> triangles;
  for (int i = 0; i < 200; ++i) {
    Triangle t;
    for (Vec3& p : t) {
      for (double& x : p) x = random.uniform(-1.0, 1.0);
      p.normalize();
    }
    triangles.push_back(t);
  }
  const Folder folder;
  folder.write("ball.stl", binary_stl(triangles));
  UrdfOptions options{.packages = {{"r", folder.file("")}}};
  const std::string text = robot({{"package://r/ball.stl", ".1 .1 .1"}});
  const SceneFile file = parse_urdf(text, options);
  CHECK(is_told(file, "link l (package://r/ball.stl) (by "));
  CHECK(is_told(file, "more than 128 corners"));
  CHECK(hull_of(file, 0).volume() == Approx(4.0 / 3.0 * 3.14159265 * 1e-3).epsilon(0.1));
  options.strict = true;
  CHECK_FALSE(refusal([&] { parse_urdf(text, options); }).empty());
}

TEST_CASE("urdf mesh: nothing is opened that is not below a folder that was named",
          "[urdf][errors]") {
  const Folder folder;
  std::filesystem::create_directories(folder.file("root/sub"));
  const std::string bytes = binary_stl(box(Vec3::Ones()));
  const std::string outside = folder.write("secret.stl", bytes);
  folder.write("root/in.stl", bytes);
  folder.write("rooted.stl", bytes);
  std::filesystem::create_symlink(outside, folder.file("root/link.stl"));
  std::filesystem::create_symlink(folder.file("root/in.stl"), folder.file("root/sub/in.stl"));
  std::filesystem::create_directory(folder.file("root/folder.stl"));
  UrdfOptions options{.packages = {{"r", folder.file("root")}}};
  for (const std::string& name :
       {std::string("package://r/../secret.stl"), std::string("package://r/sub/../../secret.stl"),
        std::string("package://r/../rooted.stl"), std::string("package://r/link.stl"),
        std::string("package://r/folder.stl"), std::string("package://r/none.stl"),
        std::string("package://q/in.stl"), std::string("package:///in.stl"),
        "package://r/" + outside, outside, "file://" + outside, std::string("in.stl"),
        std::string("package://r")}) {
    CAPTURE(name);
    const SceneFile file = parse_urdf(robot({{name, "1 1 1"}}), options);
    CHECK(is_told(file, "its mesh is not read: it must be "));
    CHECK_THROWS(file.scene.shapes().collider({0, 0}));
  }
  CHECK(parse_urdf(robot({{"package://r/sub/in.stl", "1 1 1"}}), options).warnings.empty());
  // Others are told at once.
  const SceneFile file =
      parse_urdf(robot({{"package://r/a.dae", "1 1 1"}, {"package://r/b.dae", "1 1 1"}}), options);
  REQUIRE(file.warnings.size() == 1);
  CHECK(file.warnings[0] ==
        "link l (package://r/a.dae), l (package://r/b.dae): its mesh is not read: it must be STL "
        "or OBJ");
  options.strict = true;
  CHECK(refusal([&] {
          parse_urdf(robot({{"a.dae", "1 1 1"}}), options);
        }).find("link l: mesh") != std::string::npos);
}

TEST_CASE("urdf mesh: an error names the file", "[urdf][errors]") {
  const Folder folder;
  UrdfOptions options{.packages = {{"r", folder.file("")}}};
  const auto said = [&](const std::string& bytes, const std::string& scale = "1 1 1") {
    folder.write("m.stl", bytes);
    return refusal([&] { parse_urdf(robot({{"package://r/m.stl", scale}}), options); });
  };
  const auto has = [](const std::string& text, const std::string& what) {
    CAPTURE(text, what);
    CHECK(text.find(what) != std::string::npos);
  };
  const auto triangles = box(Vec3::Ones());
  const std::string good = binary_stl(triangles);
  has(said(good.substr(0, good.size() - 1)), "m.stl: length must be 84 bytes");
  std::string other = good;
  other[0] = 'S';
  other[1] = '-';
  has(said(other + "x"), "m.stl: length must be 84 bytes and 50 for each of its triangles");
  other = good;
  other[80] = '\x7f';
  other[83] = '\x7f';
  CHECK_FALSE(said(other).empty());
  other = good;
  other[84 + 50 + 12 + 2] = '\x80';
  other[84 + 50 + 12 + 3] = '\x7f';
  has(said(other), "m.stl: triangle 2 must be of corners that are finite numbers");
  std::string text = text_stl(triangles);
  has(said(text.substr(0, text.find("vertex") + 9)), "triangle 1 must be of corners");
  has(said(text.substr(0, text.find("endsolid"))), "m.stl: length must be ");
  text.replace(text.find("vertex") + 7, 8, "1e99");
  has(said(text), "m.stl: triangle 1 must be of corners that are finite numbers, is \"1e99\"");
  has(said("solid\nendsolid\n"), "link l: ");
  CHECK(said(good, "1 0 1").empty());  // a plate
  options.limits.triangles = 11;
  has(said(good), "m.stl: triangle 11 must be at most 11");
  options.limits.triangles = 12;
  options.limits.hull_points = 7;
  has(said(good), "SceneLimits::hull_points");
  options.limits.hull_points = 8;
  CHECK(said(good).empty());
}

TEST_CASE("urdf mesh: any bytes load or are refused", "[urdf][errors][random]") {
  pbd::SplitMix64 random(8);
  const Folder folder;
  const UrdfOptions options{.packages = {{"r", folder.file("")}}};
  const auto triangles = box(Vec3::Ones());
  int refused = 0;
  for (int draw = 0; draw < 400; ++draw) {
    CAPTURE(draw);
    std::string bytes = draw % 2 == 0 ? binary_stl(triangles) : text_stl(triangles);
    if (random.below(4) == 0) bytes.resize(random.below(bytes.size()));
    for (std::uint64_t i = random.below(4); i > 0 && !bytes.empty(); --i) {
      const std::size_t at = random.below(bytes.size());
      bytes[at] = static_cast<char>(random.below(256));
    }
    folder.write("m.stl", bytes);
    try {
      parse_urdf(robot({{"package://r/m.stl", "1 1 1"}}), options);
    } catch (const SceneFileError&) {
      ++refused;
    }
  }
  CHECK(refused > 50);
}

}  // namespace
}  // namespace urdf_mesh_test
