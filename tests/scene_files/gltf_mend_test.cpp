// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// glTF as it is found: single precision, triangles without area, hulls of many corners, and
// physics by another extension.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>
#include <string>
#include <vector>

#include "support/bodies.h"
#include "support/catch.h"
#include "tandem/scene_files.h"

namespace gltf_test {

using namespace tandem;
using tandem::testing::refusal;

std::string base64(const std::string& bytes);  // gltf_test.cpp

namespace {

SceneFile parse(const std::string& inside, bool strict = false) {
  return parse_gltf(std::string(R"({"asset": {"version": "2.0"}, )") + inside + "}", {}, {}, "g",
                    {}, strict);
}
bool tells(const SceneFile& file, const std::string& what) {
  return std::any_of(file.warnings.begin(), file.warnings.end(), [&](const std::string& warning) {
    return warning.find(what) != std::string::npos;
  });
}

/// Triangles of points as one body, a hull or a mesh.
std::string solid(const std::vector<float>& points, bool hull) {
  std::string bytes(points.size() * 4, '\0');
  std::memcpy(bytes.data(), points.data(), bytes.size());
  const std::string size = std::to_string(bytes.size());
  return std::string(R"("buffers": [{"uri": "data:;base64,)") + base64(bytes) +
         R"(", "byteLength": )" + size + R"(}], "bufferViews": [{"buffer": 0, "byteLength": )" +
         size + R"(}], "accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3",
         "count": )" +
         std::to_string(points.size() / 3) +
         R"(}], "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
         "nodes": [{"name": "b", "mesh": 0, "extensions": {"KHR_physics_rigid_bodies": {)" +
         (hull ? R"("motion": {}, )" : "") +
         R"("collider": {"geometry": {"node": 0, "convexHull": )" + (hull ? "true" : "false") +
         "}}}}}]";
}

TEST_CASE("gltf: physics by OMI's extensions loads", "[gltf]") {
  SceneFile file = parse(R"("extensionsUsed": ["OMI_physics_body", "OMI_physics_shape"],
    "extensionsRequired": ["OMI_physics_body", "OMI_physics_shape"],
    "extensions": {"OMI_physics_shape": {"shapes": [{"type": "box", "box": {"size": [1, 2, 3]}},
       {"type": "capsule"}, {"type": "cylinder"}, {"type": "sphere"}]},
      "OMI_physics_body": {"physicsMaterials": [{"dynamicFriction": 0.25, "restitution": 1}]}},
    "nodes": [
     {"name": "crate", "translation": [0, 5, 0], "extensions": {"OMI_physics_body": {
       "motion": {"type": "dynamic", "mass": 5, "linearVelocity": [0, 1, 0]},
       "collider": {"shape": 0, "physicsMaterial": 0}}}},
     {"name": "pill", "translation": [9, 5, 0], "extensions": {"OMI_physics_body": {
       "motion": {"type": "dynamic"}, "collider": {"shape": 1}}}},
     {"name": "lift", "translation": [20, 0, 0], "extensions": {"OMI_physics_body": {
       "motion": {"type": "kinematic"}, "collider": {"shape": 2}}}},
     {"name": "floor", "translation": [0, -9, 0], "extensions": {"OMI_physics_body": {
       "motion": {"type": "static"}, "collider": {"shape": 0}}}},
     {"name": "zone", "translation": [0, 30, 0], "extensions": {"OMI_physics_body": {
       "trigger": {"shape": 3}}}}])");
  CHECK(file.warnings.empty());
  REQUIRE(file.bodies.size() == 5);
  const auto& world = file.scene.world();
  const auto& props = [&](const char* name) { return world.props(file.find(name)); };
  CHECK(props("crate").mass == 5.0);
  CHECK(props("crate").inertia(2, 2) == Approx(5.0 * (1.0 + 4.0) / 12.0));
  CHECK(world.twist(file.find("crate")).linear.isApprox(Vec3(0.0, 0.0, 1.0)));
  CHECK(props("pill").mass == 1.0);
  CHECK(props("lift").type == BodyType::Kinematic);
  CHECK(props("floor").type == BodyType::Static);
  const auto collider = [&](std::uint32_t i) {
    return file.scene.shapes().collider(file.scene.shapes().collider_at(i));
  };
  CHECK(collider(0).material.friction == 0.25);
  // Default sizes: of the capsule half a metre around one, of the cylinder two high.
  CHECK(std::get<collision::Capsule>(collider(1).shape).radius == 0.5);
  CHECK(std::get<collision::Capsule>(collider(1).shape).half_height == 0.5);
  CHECK(std::get<collision::Cylinder>(collider(2).shape).half_height == 1.0);
  CHECK(collider(4).sensor);
  for (int i = 0; i < 60; ++i) file.scene.step(1.0 / 60.0);
  CHECK(file.scene.pose(file.find("crate")).position.z() ==
        Approx(5.0 + 1.0 - 0.5 * 9.81).margin(0.05));
  CHECK(refusal([] {
          parse(
              R"("nodes": [{"extensions": {"OMI_physics_body": {"motion": {"type": "jumps"}}}}])");
        }).empty());  // a type that OMI has not is told
  CHECK(tells(parse(R"("nodes": [{"extensions": {"OMI_physics_body": {"motion":
        {"type": "jumps"}}}}])"),
              "/motion/type"));
}

TEST_CASE("gltf: a file with unknown required extensions is refused", "[gltf][errors]") {
  const std::string told =
      refusal([] { parse(R"("extensionsRequired": ["KHR_draco_mesh_compression"])"); });
  CHECK(told.find("/extensionsRequired/0") != std::string::npos);
  CHECK(told.find("KHR_draco_mesh_compression") != std::string::npos);
  CHECK(parse(R"("extensionsRequired": ["KHR_materials_unlit"])").warnings.empty());
  CHECK(tells(parse(R"("extensionsUsed": ["OMI_physics_joint", "KHR_lights_punctual"])"),
              "/extensionsUsed/0: OMI_physics_joint is not read"));
}

TEST_CASE("gltf: round-off of single precision below an uneven scale is none", "[gltf]") {
  const auto text = [](const char* turn, const char* more) {
    return std::string(R"("extensions": {"KHR_implicit_shapes": {"shapes": [{"type": "box"}]}},
      "nodes": [{"scale": [1, 0.5, 1], "children": [1]},
      {"translation": [1, 0, 0], "rotation": [0, )") +
           turn + ", 0, 1], " + more + "}]";
  };
  const char* box =
      R"("extensions": {"KHR_physics_rigid_bodies": {"collider": {"geometry": {"shape": 0}}}})";
  CHECK_NOTHROW(parse(text("1.1920929e-7", box)));
  CHECK(refusal([&] {
          parse(text("1e-5", box));
        }).find("/nodes/1 must be without a rotation below a scale that is uneven") !=
        std::string::npos);
  // Shear has no effect on a frame without a shape, as of a joint, but moves what hangs on it.
  CHECK_NOTHROW(parse(text("1e-5", R"("name": "frame")")));
  const std::string below = R"("children": [2]}, {"translation": [0, 1, 0])";
  CHECK(refusal([&] { parse(text("1e-5", below.c_str())); }).find("/nodes/2/translation") !=
        std::string::npos);
}

TEST_CASE("gltf: moments of 0 are infinite, impossible ones the nearest", "[gltf]") {
  const auto text = [](const char* moments) {
    return std::string(R"("nodes": [{"name": "b", "extensions": {"KHR_physics_rigid_bodies":
      {"motion": {"mass": 2, "inertiaDiagonal": )") +
           moments + "}}}}]";
  };
  SceneFile still = parse(text("[0, 0, 0]"));
  still.scene.apply_impulse(still.find("b"), Vec3(1.0, 0.0, 0.0), Vec3(0.0, 1.0, 0.5));
  still.scene.step(1.0 / 60.0);
  CHECK(still.scene.twist(still.find("b")).angular.norm() < 1e-12);
  CHECK(still.scene.twist(still.find("b")).linear.x() == Approx(0.5).epsilon(1e-6));

  // y in glTF is z here.
  SceneFile wheel = parse(text("[0, 1, 0]"));
  CHECK(tells(wheel, "/inertiaDiagonal: 0 stands for infinity"));
  wheel.scene.world().apply_angular_impulse(wheel.find("b"), Vec3(1.0, 1.0, 1.0));
  const Vec3 spin = wheel.scene.twist(wheel.find("b")).angular;
  CHECK(spin.z() == Approx(1.0));
  CHECK(spin.head<2>().norm() < 1e-5);

  // Second moments of a body are not negative: 0.4 is at most the sum of the others.
  const SceneFile rod = parse(text("[0.4, 0.1, 0.1]"));
  CHECK(tells(rod, "/inertiaDiagonal: no body has it"));
  CHECK(rod.scene.world().props(rod.find("b")).inertia.trace() == Approx(0.6).epsilon(0.4));
  CHECK(refusal([&] { parse(text("[0.4, 0.1, 0.1]"), true); }).find("largest moment") !=
        std::string::npos);
}

TEST_CASE("gltf: an open mesh has the mass of its hull, and no triangle counts twice", "[gltf]") {
  // Three faces of the corner of a cube, then one of them again.
  std::vector<float> corner{0, 0, 0, 0, 1, 0, 1, 0, 0, 0, 0, 0, 0, 0,
                            1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  const auto moving = [&] {
    std::string text = solid(corner, false);
    const std::string key = R"("collider")";
    return text.insert(text.find(key), R"("motion": {}, )");
  };
  const SceneFile open = parse(moving());
  CHECK(tells(open, "a mesh with a border has the mass of its hull"));
  CHECK(open.scene.world().props(open.find("b")).mass == Approx(1000.0 / 6.0));
  CHECK(refusal([&] { parse(moving(), true); }).find("closed") != std::string::npos);
  corner.insert(corner.end(), {0, 0, 0, 0, 1, 0, 1, 0, 0});
  const SceneFile twice = parse(solid(corner, false));
  CHECK(tells(twice, "1 triangles with another one on the same side"));
  CHECK(
      std::get<collision::Mesh>(twice.scene.shapes().collider({0, 0}).shape)->triangles().size() ==
      3);
  CHECK(refusal([&] { parse(solid(corner, false), true); }).find("the only one on its side") !=
        std::string::npos);
}

TEST_CASE("gltf: triangles without area are left out, hulls of many corners simplified", "[gltf]") {
  const std::string sliver =
      solid({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0.5f, 0, 0}, false);
  const SceneFile file = parse(sliver);
  CHECK(tells(file, "1 triangles without area"));
  CHECK(std::get<collision::Mesh>(file.scene.shapes().collider({0, 0}).shape)->triangles().size() ==
        1);
  CHECK(refusal([&] { parse(sliver, true); }).find("area of triangles[1]") != std::string::npos);

  std::vector<float> ball;
  for (int i = 0; i < 300; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / 300.0;
    const double turn = i * std::numbers::pi * (3.0 - std::sqrt(5.0));
    const double r = std::sqrt(1.0 - z * z);
    for (const double x : {r * std::cos(turn), r * std::sin(turn), z}) {
      ball.push_back(static_cast<float>(x));
    }
  }
  const SceneFile round = parse(solid(ball, true));
  CHECK(tells(round, "more than 128 corners"));
  CHECK(round.scene.world().props(round.find("b")).mass ==
        Approx(1000.0 * 4.0 / 3.0 * std::numbers::pi).epsilon(0.06));
  CHECK(refusal([&] { parse(solid(ball, true), true); }).find("at most 128") != std::string::npos);
}

}  // namespace
}  // namespace gltf_test
