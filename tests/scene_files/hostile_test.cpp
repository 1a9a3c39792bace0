// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <string>
#include <vector>

#include "support/bodies.h"
#include "support/catch.h"
#include "tandem/pbd/random.h"
#include "tandem/scene_files.h"

namespace hostile_test {

using namespace tandem;

/// The error of reading it; "" if it is read, and a failure if something else is thrown.
std::string told(const std::string& text) {
  try {
    parse_scene(text, {}, "room.json");
  } catch (const SceneFileError& error) {
    return error.what();
  }
  return {};
}

std::string body(const std::string& rest) {
  return R"({"bodies": [{"shape": {"type": "sphere", "radius": 1}}, {)" + rest + "}]}";
}

TEST_CASE("scene files: errors name file, place, rule and value", "[scene_files][errors]") {
  struct Case {
    std::string text;
    std::vector<std::string> says;
  };
  const std::string sphere = R"("shape": {"type": "sphere", "radius": 1})";
  const std::string mesh =
      R"("type": "static", "shape": {"type": "mesh", "vertices": [[0,0,0],[1,0,0],[0,1,0]], "triangles": )";
  const std::string two = R"({"bodies": [{"name": "a", )" + sphere + R"(}], "joints": [)";
  const std::vector<Case> cases{
      {"", {"JSON"}},
      {"[]", {"document must be an object"}},
      {"{}", {"\"bodies\""}},
      {R"({"version": 2, "bodies": []})", {"/version must be 1, is 2"}},
      {R"({"gravity": [0, 0, "Infinity"], "bodies": []})", {"gravity", "finite"}},
      {body(R"("shape": {"type": "sphere", "radius": -1})"),
       {"/bodies/1/shape", "radius", "> 0", "-1"}},
      {body(R"("shape": {"type": "sphere", "radius": NaN})"), {"JSON"}},
      {body(R"("shape": {"type": "sphere", "radius": 1e999})"), {"JSON", "1e999"}},
      {body(R"("shape": {"type": "sphere", "radius": "x"})"),
       {"/bodies/1/shape/radius must be a number", "\"x\""}},
      {body(R"("shape": {"type": "sphere"})"), {"/bodies/1/shape", "\"radius\""}},
      {body(R"("shape": {"type": "torus"})"), {"/bodies/1/shape/type", "one of box", "torus"}},
      {body(R"("name": "x")"), {"/bodies/1", "\"shape\""}},
      {body(sphere + R"(, "mass": 0)"), {"/bodies/1: ", "mass", "> 0", "0"}},
      {body(sphere + R"(, "type": "moving")"),
       {"/bodies/1/type", "static, kinematic, dynamic", "moving"}},
      {body(sphere + R"(, "orientation": [0, 0, 0, 2])"), {"/bodies/1: ", "orientation", "unit"}},
      {body(sphere + R"(, "position": [0, 0])"), {"/bodies/1/position", "3 numbers", "[0,0]"}},
      {body(sphere + R"(, "layer": "x")"), {"/bodies/1/layer", "/layers/names"}},
      {body(sphere + R"(, "stableId": -1)"), {"/bodies/1/stableId", "whole number", "-1"}},
      {body(sphere + R"(, "filter": {"category": 4294967296})"),
       {"/bodies/1/filter/category", "4294967295"}},
      {body(sphere + R"(, "friction": -1)"), {"/bodies/1", "friction", "-1"}},
      {body(mesh + "[[0, 1, 4000000000]]}"), {"/bodies/1/shape", "triangles[0]", "4000000000"}},
      {body(mesh + "[[0, 1, -1]]}"), {"/bodies/1/shape/triangles/0/2", "whole number", "-1"}},
      {body(mesh + "[[0, 1]]}"), {"/bodies/1/shape/triangles/0", "3 values"}},
      {body(
           R"("shape": {"type": "heightField", "columns": 16384, "rows": 16384, "spacing": [1, 1], "heights": []})"),
       {"/bodies/1/shape", "heights"}},
      {body(R"("shape": {"type": "hull", "points": [[0,0,0],[1,0,0],[0,1,0],[1,1,0]]})"),
       {"/bodies/1/shape", "volume"}},
      {body(R"("colliders": [])"), {"/bodies/1", "\"mass\""}},
      {body(R"("shape": {"type": "halfSpace"})"), {"/bodies/1", "Static", "Dynamic"}},
      {two + R"({"type": "hinge", "b": "c"}]})", {"/joints/0/b", "/bodies", "\"c\""}},
      {two + R"({"type": "hinge", "b": 7}]})", {"/joints/0/b", "from 0 to 0", "7"}},
      {two + R"({"type": "glue", "b": 0}]})", {"/joints/0/type", "hinge", "glue"}},
      {two + R"({"type": "hinge", "a": 0, "b": 0}]})", {"/joints/0"}},
      {two + R"({"type": "hinge", "b": 0, "axis": {"lower": 2, "upper": 1}}]})",
       {"/joints/0", "upper", "lower"}},
      {two + R"({"type": "hinge", "b": 0, "at": {"axis": [0, 0, 0]}}]})",
       {"/joints/0", "axis", "longer"}},
      {R"({"bodies": [{"name": "a", )" + sphere + R"(}, {"name": "a", )" + sphere + "}]}",
       {"/bodies/1/name", "\"a\""}},
  };
  for (const Case& one : cases) {
    const std::string message = told(one.text);
    CAPTURE(one.text, message);
    CHECK(message.find("room.json") == 0);
    for (const std::string& part : one.says) CHECK(message.find(part) != std::string::npos);
  }
}

TEST_CASE("scene files: depth is bounded", "[scene_files][errors]") {
  const std::string deep(3'000'000, '[');
  CHECK(told(deep).find("depth must be at most 24") != std::string::npos);
  std::string objects;
  for (int i = 0; i < 100'000; ++i) objects += R"({"a":)";
  CHECK(told(objects).find("depth must be at most 24") != std::string::npos);
}

TEST_CASE("scene files: files that are none are told", "[scene_files][errors]") {
  for (const char* path : {"/nowhere/scene.json", "/", "/dev/zero", "/nowhere/scene.gltf"}) {
    CAPTURE(path);
    CHECK_THROWS_AS(load_scene(path), SceneFileError);
  }
}

TEST_CASE("scene files: any changed text is read or refused", "[scene_files][errors]") {
  const std::string good = R"({"layers": {"names": ["x", "y"], "ignore": [["x", "y"]]}, "bodies": [
 {"name": "a", "layer": "x", "shape": {"type": "box", "halfExtents": [1, 1, 1]}, "mass": 2, "parts": [
   {"shape": {"type": "cone", "radius": 1, "halfHeight": 1}}]},
 {"name": "b", "type": "static", "shape": {"type": "mesh", "vertices": [[0,0,0],[1,0,0],[0,1,0]], "triangles": [[0,1,2]]}},
 {"name": "c", "mass": 1, "inertia": [1, 1, 1, 0, 0, 0], "colliders": [{"shape": {"type": "hull",
   "points": [[0,0,0],[1,0,0],[0,1,0],[0,0,1]]}, "filter": {"mask": 3}}]}],
 "joints": [{"type": "hinge", "a": "a", "b": 2, "at": {"position": [0, 0, 1]}, "axis": {"lower": -1}}]})";
  REQUIRE(told(good).empty());
  pbd::SplitMix64 random(11);
  const std::string bytes = "0123456789-.eE\"[]{},: xabc\xff\n";
  int refused = 0;
  for (int i = 0; i < 4000; ++i) {
    std::string text = good;
    for (int k = 0; k < 1 + i % 3; ++k) {
      const auto at =
          static_cast<std::size_t>(random.uniform(0.0, static_cast<double>(text.size())));
      const auto which =
          static_cast<std::size_t>(random.uniform(0.0, static_cast<double>(bytes.size())));
      text[std::min(at, text.size() - 1)] = bytes[std::min(which, bytes.size() - 1)];
    }
    if (!told(text).empty()) ++refused;
  }
  for (std::size_t length = 0; length < good.size(); ++length) {
    CHECK_FALSE(told(good.substr(0, length)).empty());
  }
  CHECK(refused > 1000);
  CHECK(refused < 4000);
}

}  // namespace hostile_test
