// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <cmath>
#include <filesystem>
#include <numbers>

#include "support/bodies.h"
#include "support/catch.h"
#include "tandem/scene_files.h"

namespace read_scene_test {

using namespace tandem;
using tandem::testing::refusal;

TEST_CASE("scene files: a rod on a hinge swings in the time that the formula says",
          "[scene_files]") {
  SceneFile file = parse_scene(R"({
    "gravity": [0, 0, -9.81],
    "bodies": [{"name": "rod", "shape": {"type": "box", "halfExtents": [0.01, 0.02, 0.4]}, "mass": 2,
                "position": [0, 0, -0.4], "angularVelocity": [0.2, 0, 0], "canSleep": false,
                "linearVelocity": [0, 0.08, 0]}],
    "joints": [{"name": "hook", "type": "hinge", "b": "rod", "at": {"position": [0, 0, 0], "axis": [1, 0, 0]}}]
  })");
  CHECK(file.warnings.empty());
  CHECK(file.scene.world().props(file.find("rod")).mass == 2.0);
  // I = m (0.04^2 + 0.8^2) / 12 + m 0.4^2 about the hinge; T = 2 pi sqrt(I / (m g 0.4)).
  const double inertia = 2.0 * (0.04 * 0.04 + 0.8 * 0.8) / 12.0 + 2.0 * 0.16;
  const double period = 2.0 * std::numbers::pi * std::sqrt(inertia / (2.0 * 9.81 * 0.4));
  constexpr double kStep = 1.0 / 240.0;
  int turns = 0;
  double first = 0.0, last = 0.0, before = 0.0;
  for (int i = 1; i <= 240 * 12; ++i) {
    file.scene.step(kStep);
    const double angle = file.scene.joints().hinge_angle(file.find_joint("hook"));
    if (before < 0.0 && angle >= 0.0) {
      last = (i - 1 + before / (before - angle)) * kStep;
      if (turns++ == 0) first = last;
    }
    before = angle;
  }
  REQUIRE(turns > 5);
  CHECK((last - first) / (turns - 1) == Approx(period).epsilon(2e-3));
}

TEST_CASE("scene files: an arm stays in place within its limits, at any turn", "[scene_files]") {
  struct Case {
    double lower, upper, at;  // degrees
  };
  constexpr double kDegree = std::numbers::pi / 180.0;
  for (const Case& c : {Case{170.0, 190.0, 181.0}, Case{0.0, 270.0, 200.0}}) {
    INFO("[" << c.lower << ", " << c.upper << "] at " << c.at);
    const auto number = [](double value) { return std::to_string(value); };
    const double turn = c.at * kDegree;
    SceneFile file = parse_scene(
        R"({"gravity": [0, 0, 0], "bodies": [{"name": "arm", "mass": 1,
            "shape": {"type": "box", "halfExtents": [0.3, 0.02, 0.02]}, "position": [)" +
        number(0.3 * std::cos(turn)) + ", " + number(0.3 * std::sin(turn)) +
        R"(, 0], "orientation": [0, 0, )" + number(std::sin(0.5 * turn)) + ", " +
        number(std::cos(0.5 * turn)) + R"(]}], "joints": [{"name": "hook", "type": "hinge",
            "b": "arm", "frameA": {"orientation": [0, -0.70710678118654752, 0, 0.70710678118654752]},
            "frameB": {"position": [-0.3, 0, 0],
                       "orientation": [0, -0.70710678118654752, 0, 0.70710678118654752]},
            "axis": {"lower": )" +
        number(c.lower * kDegree) + R"(, "upper": )" + number(c.upper * kDegree) + "}}]}");
    SceneFile again = parse_scene(write_scene(file.scene));
    for (SceneFile* each : {&file, &again}) {
      const pbd::JointId hook = pbd::joint_ids(each->scene.joints())[0];
      for (int i = 0; i < 60; ++i) each->scene.step(1.0 / 60.0);
      CHECK(each->scene.joints().at(hook).position[3] == Approx(turn).margin(1e-5));
    }
  }
}

TEST_CASE("scene files: bodies with layers, parts and compounds rest and fall correctly",
          "[scene_files]") {
  SceneFile file = parse_scene(R"({
    "layers": {"names": ["room", "ghost"], "ignore": [["ghost", "room"]]},
    "bodies": [
      {"name": "ground", "type": "static", "shape": {"type": "halfSpace"}, "layer": "room"},
      {"name": "cube", "shape": {"type": "box", "halfExtents": [0.1, 0.1, 0.1]}, "position": [0, 0, 0.2]},
      {"name": "ghost", "shape": {"type": "sphere", "radius": 0.1}, "position": [1, 0, 0.2], "layer": "ghost"},
      {"name": "table", "position": [2, 0, 0.5], "density": 1, "shape": {"type": "box", "halfExtents": [0.4, 0.4, 0.02]},
       "parts": [{"shape": {"type": "box", "halfExtents": [0.3, 0.3, 0.2]}, "position": [0, 0, -0.2]}]},
      {"name": "club", "position": [4, 0, 1], "compound": [
        {"shape": {"type": "sphere", "radius": 0.1}, "position": [0, 0, 0.3], "density": 750},
        {"shape": {"type": "sphere", "radius": 0.1}, "position": [0, 0, -0.3], "density": 250}]}
    ]})");
  CHECK(file.warnings.empty());
  const auto height = [&](const char* name) {
    return file.scene.pose(file.find(name)).position.z();
  };
  // The club's two balls: 1000 kg/m^3 x 4/3 pi r^3 in all, half as far to the heavier one.
  const auto& club = file.scene.world().props(file.find("club"));
  CHECK(club.mass == Approx(1000.0 * 4.0 / 3.0 * std::numbers::pi * 1e-3));
  CHECK(file.scene.world().pose(file.find("club")).position.z() == Approx(1.0 + 0.15));
  for (int i = 0; i < 240; ++i) file.scene.step(1.0 / 120.0);
  CHECK(height("cube") == Approx(0.1).margin(1e-3));
  CHECK(height("ghost") < -10.0);
  CHECK(height("table") == Approx(0.4).margin(1e-3));
}

TEST_CASE("scene files: the files of rooms are scenes", "[scene_files]") {
  for (const auto& entry : std::filesystem::directory_iterator(TANDEM_ROOMS)) {
    if (entry.path().extension() != ".json") continue;
    SceneFile file = load_scene(entry.path());
    INFO(entry.path());
    CHECK(file.warnings.empty());
    CHECK(file.bodies.size() > 5);
    REQUIRE(file.find("ground").valid());
    for (int i = 0; i < 60; ++i) REQUIRE(file.scene.step(1.0 / 60.0).status == pbd::StepStatus::Ok);
    for (const auto& body : file.bodies) {
      CHECK_FALSE(body.name.empty());
      CHECK(file.scene.pose(body.body).position.z() > -0.05);
    }
  }
}

TEST_CASE("scene files: unknown members are told", "[scene_files]") {
  const SceneFile file =
      parse_scene(R"({"bodies": [{"shape": {"type": "sphere", "radius": 1, "hue/~": 3},
    "colour": "#fff", "frction": 0.2}], "lights": []})");
  REQUIRE(file.warnings.size() == 3);
  CHECK(file.warnings[0].find("/bodies/0/shape/hue~1~0: ") == 0);
  CHECK(file.warnings[1].find("/bodies/0/frction: ") == 0);
  CHECK(file.warnings[2].find("/lights: ") == 0);
}

TEST_CASE("scene files: one body at a time", "[scene_files]") {
  Scene scene;
  const SceneFile::Body body = add_body(
      scene, R"({"name": "ball", "shape": {"type": "sphere", "radius": 0.2}, "density": 7})");
  CHECK(body.name == "ball");
  CHECK(scene.world().props(body.body).mass == Approx(7.0 * 4.0 / 3.0 * std::numbers::pi * 8e-3));
  CHECK_THROWS_AS(add_body(scene, R"({"name": "ball"})"), SceneFileError);
  CHECK_THROWS_AS(add_body(scene, R"({"shape": {"type": "sphere", "radius": 1}, "mass": -2})"),
                  SceneFileError);
  // A part that cannot be added leaves nothing of its body.
  CHECK_THROWS_AS(add_body(scene, R"({"shape": {"type": "sphere", "radius": 1},
                                      "parts": [{"shape": {"type": "sphere", "radius": -1}}]})"),
                  SceneFileError);
  CHECK(scene.world().body_count() == 1);
}

}  // namespace read_scene_test
