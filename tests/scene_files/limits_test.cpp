// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <functional>
#include <string>

#include "support/bodies.h"
#include "support/catch.h"
#include "tandem/collision/crowding.h"
#include "tandem/scene_files.h"

namespace limits_test {

using namespace tandem;
using tandem::testing::names;
using tandem::testing::refusal;

/// The refusal if one of each is too many, and "" if their number is allowed.
std::string told(const std::string& text, std::size_t SceneLimits::*what, std::size_t most,
                 bool gltf) {
  SceneLimits limits;
  limits.*what = most;
  return refusal([&] {
    if (gltf) {
      parse_gltf(text, {}, {}, "file", limits);
    } else {
      parse_scene(text, {}, "file", limits);
    }
  });
}

std::string repeated(int count, const std::function<std::string(int)>& part) {
  std::string out;
  for (int i = 0; i < count; ++i) {
    if (i > 0) out += ',';
    out += part(i);
  }
  return out;
}

std::string balls(int count, double apart) {
  return R"({"bodies": [)" +
         repeated(count,
                  [apart](int i) {
                    return R"({"shape": {"type": "sphere", "radius": 1}, "position": [)" +
                           std::to_string(apart * i) + ", 0, 0]}";
                  }) +
         "]}";
}

TEST_CASE("scene limits: each is kept to the last one, and named", "[scene_files][errors]") {
  struct Case {
    std::string text;
    std::size_t SceneLimits::*what;
    std::size_t has;
    std::string field;
    bool gltf = false;
  };
  const std::string ball = R"({"shape": {"type": "sphere", "radius": 1}})";
  const std::string mesh =
      R"({"bodies": [{"type": "static", "shape": {"type": "mesh", "vertices":
      [[0,0,0],[1,0,0],[0,1,0],[0,0,1]], "triangles": [[0,1,2],[0,3,1]]}}]})";
  const std::string hull = R"({"bodies": [{"shape": {"type": "hull", "points":
      [[0,0,0],[1,0,0],[0,1,0],[0,0,1],[1,1,1]]}}]})";
  const std::string field =
      R"({"bodies": [{"type": "static", "shape": {"type": "heightField", "columns": 3, "rows": 2,
      "spacing": [1, 1], "heights": [0,0,0,0,0,0]}}]})";
  const std::string joints = R"({"bodies": [)" + ball + R"(], "joints": [
      {"type": "ball", "b": 0}, {"type": "ball", "b": 0}, {"type": "ball", "b": 0}]})";
  const std::string compound =
      R"({"bodies": [{"compound": [)" + repeated(4, [&](int) { return ball; }) + "]}]}";
  const std::string parts = R"({"bodies": [{"shape": {"type": "sphere", "radius": 1}, "parts": [)" +
                            repeated(4, [&](int) { return ball; }) + "]}]}";
  const std::string nodes = R"({"asset": {"version": "2.0"}, "nodes": [)" +
                            repeated(7, [](int) { return std::string("{}"); }) + "]}";
  const std::string solids =
      R"({"asset": {"version": "2.0"}, "extensions": {"KHR_implicit_shapes": {"shapes": [
      {"type": "sphere", "sphere": {"radius": 1}}]}}, "nodes": [)" +
      repeated(3,
               [](int i) {
                 return R"({"translation": [)" + std::to_string(4 * i) +
                        R"(, 0, 0], "extensions": {"KHR_physics_rigid_bodies": {"motion": {},
                        "collider": {"geometry": {"shape": 0}}}}})";
               }) +
      "]}";
  const Case cases[] = {
      {balls(3, 4.0), &SceneLimits::bodies, 3, "bodies"},
      {balls(3, 4.0), &SceneLimits::colliders, 3, "colliders"},
      {compound, &SceneLimits::colliders, 4, "colliders"},
      {compound, &SceneLimits::parts, 4, "parts"},
      {parts, &SceneLimits::colliders, 5, "colliders"},
      {parts, &SceneLimits::parts, 4, "parts"},
      {joints, &SceneLimits::joints, 3, "joints"},
      {mesh, &SceneLimits::points, 4, "points"},
      {mesh, &SceneLimits::triangles, 2, "triangles"},
      {field, &SceneLimits::points, 6, "points"},
      {hull, &SceneLimits::hull_points, 5, "hull_points"},
      {nodes, &SceneLimits::nodes, 7, "nodes", true},
      {solids, &SceneLimits::bodies, 3, "bodies", true},
      {solids, &SceneLimits::colliders, 3, "colliders", true},
      {balls(4, 1.0), &SceneLimits::pairs, 5, "pairs"},
      {balls(4, 2.1), &SceneLimits::pairs, 0, ""},
  };
  for (const Case& each : cases) {
    CAPTURE(each.text, each.field);
    CHECK(told(each.text, each.what, each.has, each.gltf).empty());
    if (each.has == 0) continue;
    CHECK(names(told(each.text, each.what, each.has - 1, each.gltf), "file",
                "at most " + std::to_string(each.has - 1) + ' ', "SceneLimits::" + each.field));
  }
}

TEST_CASE("scene limits: the defaults refuse scenes that take seconds a step",
          "[scene_files][errors]") {
  const std::string rule = "SceneLimits::pairs";
  CHECK(names(refusal([&] { parse_scene(balls(1500, 0.0)); }), "scene", "131072", rule));
  CHECK(refusal([&] { parse_scene(balls(500, 0.0)); }).empty());
  const std::string part = R"({"shape": {"type": "sphere", "radius": 1}})";
  const std::string compound =
      R"({"compound": [)" + repeated(3000, [&](int) { return part; }) + "]}";
  CHECK(refusal([&] { parse_scene(R"({"bodies": [)" + compound + "]}"); }).empty());
  CHECK(names(refusal([&] { parse_scene(R"({"bodies": [)" + compound + ", " + compound + "]}"); }),
              "scene", "131072", rule));
}

TEST_CASE("crowding: pairs that may meet, of bodies of which one moves", "[scene_files]") {
  Scene scene;
  const auto add = [&](const SolidDef& def) { return scene.add(Sphere{1.0}, def); };
  const auto crowded = [&](std::size_t most) {
    return collision::is_crowded(scene.shapes(), scene.world(), most);
  };
  scene.add(HalfSpace{}, {.type = BodyType::Static});
  CHECK_FALSE(crowded(0));
  add({.type = BodyType::Static});
  add({.type = BodyType::Static});
  CHECK_FALSE(crowded(0));
  const BodyId mover = add({});
  CHECK(crowded(1));
  CHECK_FALSE(crowded(2));
  scene.set_pose(mover, {.position = {5.0, 0.0, 0.0}});
  CHECK_FALSE(crowded(0));
  const std::int32_t group = scene.new_group();
  add({.pose = {.position = {9.0, 0.0, 0.0}}, .filter = {.group = group}});
  add({.pose = {.position = {9.0, 0.0, 0.0}}, .filter = {.group = group}});
  CHECK_FALSE(crowded(0));
}

}  // namespace limits_test
