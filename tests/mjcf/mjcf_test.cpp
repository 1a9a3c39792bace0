// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/mjcf.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <string>
#include <tuple>

#include "support/bodies.h"
#include "support/catch.h"

namespace mjcf_test {

using namespace tandem;
using tandem::testing::refusal;

const std::string kModel = R"(<mujoco model="things">
  <compiler angle="radian"/>
  <option gravity="0 0 -3.7"/>
  <worldbody>
    <geom name="floor" type="plane" size="5 5 1"/>
    <body name="rod" pos="2 0 1.5" euler="0 0 0.7">
      <joint name="hook" type="hinge" axis="0 1 0"/>
      <geom type="box" size="0.02 0.02 0.3" pos="0 0 -0.3" mass="2"/>
    </body>
    <body name="box" pos="0 0 0.4"><freejoint/><geom type="box" size="0.1 0.1 0.1"/></body>
    <body name="cart" pos="0 3 2">
      <joint name="along" type="slide" axis="1 0 0" range="-1 0.25" limited="true"/>
      <joint name="up" type="slide" axis="0 0 1" stiffness="100" damping="20"/>
      <geom type="sphere" size="0.1" mass="1"/>
      <body name="flag" pos="0 0 0.2"><geom type="capsule" size="0.02 0.1" mass="0.1"/></body>
    </body>
  </worldbody>
  <actuator><motor name="pull" joint="along"/></actuator>
</mujoco>)";

TEST_CASE("mjcf: a rod swings, a box rests and a spring sags as the formulas say", "[mjcf]") {
  SceneFile file = parse_mjcf(kModel);
  Scene& scene = file.scene;
  CHECK(scene.world().gravity() == Vec3(0.0, 0.0, -3.7));
  const BodyId rod = file.find("rod");
  CHECK(scene.pose(rod).position.isApprox(Vec3(2.0, 0.0, 1.5)));
  CHECK(scene.world().props(file.find("box")).mass == Approx(8.0));  // 1000 kg/m^3
  const Vec3 spin = 0.2 * Vec3(-std::sin(0.7), std::cos(0.7), 0.0);
  scene.world().set_twist(rod, {spin.cross(Vec3(0.0, 0.0, -0.3)), spin});
  scene.world().set_twist(file.find("cart"), {.linear = {0.5, 0.0, 0.0}});
  const double inertia = 2.0 * (0.04 * 0.04 + 0.6 * 0.6) / 12.0 + 2.0 * 0.09;
  const double period = 2.0 * std::numbers::pi * std::sqrt(inertia / (2.0 * 3.7 * 0.3));
  constexpr double kStep = 1.0 / 240.0;
  int turns = 0;
  double first = 0.0, last = 0.0, before = 0.0;
  for (int i = 1; i <= 240 * 15; ++i) {
    scene.step(kStep);
    const double angle = scene.joints().hinge_angle(file.find_joint("hook"));
    if (before < 0.0 && angle >= 0.0) {
      last = (i - 1 + before / (before - angle)) * kStep;
      if (turns++ == 0) first = last;
    }
    before = angle;
  }
  REQUIRE(turns > 5);
  CHECK((last - first) / (turns - 1) == Approx(period).epsilon(2e-3));
  CHECK(scene.pose(file.find("box")).position.z() == Approx(0.1).margin(1e-3));
  // The cart has met its stop, and hangs m g / k below where it was; the flag is a part of it.
  const Vec3 cart = scene.pose(file.find("cart")).position;
  CHECK(cart.x() <= 0.25 + 1e-3);
  CHECK(cart.z() == Approx(2.0 - 1.1 * 3.7 / 100.0).margin(1e-3));
  CHECK((file.pose("flag").position - cart).isApprox(Vec3(0.0, 0.0, 0.2), 1e-3));
  CHECK(file.warnings.empty());
  REQUIRE(file.actuators.size() == 1);
  CHECK(file.actuators[0].name == "pull");
}

TEST_CASE("mjcf: a joint starts on the turn within its range, or at the nearest one", "[mjcf]") {
  constexpr double kDegree = std::numbers::pi / 180.0;
  for (const auto& [range, angle, moved] : {std::tuple{"350 372", 360.0, false},
                                            {"30 330", 30.0, true},
                                            {"60 320", 320.0, true},
                                            {"-720 720", 0.0, false}}) {
    INFO(range);
    SceneFile file = parse_mjcf(
        "<mujoco><option gravity='0 0 0'/><worldbody><body><joint name='j' "
        "axis='0 1 0' limited='true' range='" +
        std::string(range) + "'/><geom size='0.1'/></body></worldbody></mujoco>");
    const pbd::JointId id = file.find_joint("j");
    CHECK(file.scene.joints().hinge_angle(id) == Approx(angle * kDegree).margin(1e-12));
    for (int i = 0; i < 60; ++i) file.scene.step(1.0 / 60.0);
    CHECK(file.scene.joints().hinge_angle(id) == Approx(angle * kDegree).margin(1e-6));
    CHECK(file.warnings.empty() != moved);
  }
}

TEST_CASE("mjcf: a model has no more than it may", "[mjcf][errors]") {
  const std::string text =
      "<mujoco><worldbody><body><freejoint/><geom size='0.1'/><geom size='0.1'/></body>"
      "<body pos='0.05 0 0'><freejoint/><geom size='0.1'/></body></worldbody></mujoco>";
  const auto told = [&](std::size_t SceneLimits::*what, std::size_t most) {
    MjcfOptions options;
    options.limits.*what = most;
    return tandem::testing::refusal([&] { parse_mjcf(text, options, "m"); });
  };
  CHECK(told(&SceneLimits::bodies, 3).empty());
  CHECK(told(&SceneLimits::bodies, 2).find("SceneLimits::bodies") != std::string::npos);
  CHECK(told(&SceneLimits::colliders, 2).find("SceneLimits::colliders") != std::string::npos);
  CHECK(told(&SceneLimits::parts, 1).find("SceneLimits::parts") != std::string::npos);
  CHECK(told(&SceneLimits::pairs, 1).find("SceneLimits::pairs") != std::string::npos);
}

TEST_CASE("mjcf: invalid models are refused", "[mjcf][errors]") {
  const auto refused = [](const std::string& text) {
    return refusal([&] { parse_mjcf(text, {}, "x.xml"); });
  };
  CHECK(refused("").find("x.xml: ") == 0);
  CHECK(refused("<mujoco><worldbody><body>").find("x.xml: ") == 0);
  CHECK(refused("<mujoco><include file='/etc/hostname'/></mujoco>").find("x.xml: ") == 0);
  // A text has no files beside it, and what is on the disk is not looked for.
  const auto path = std::filesystem::temp_directory_path() / "tandem_mjcf_test.xml";
  std::ofstream(path) << "<mujoco><worldbody><geom size='1'/></worldbody></mujoco>";
  for (const std::string& names :
       {"<include file='" + path.string() + "'/>",
        std::string("<asset><mesh name='m' file='/m.stl'/></asset>"),
        std::string("<asset><texture name='t' fileright = '/t.png'/></asset>")}) {
    CAPTURE(names);
    CHECK(refused("<mujoco>" + names + "</mujoco>").find("without a file") != std::string::npos);
  }
  std::filesystem::remove(path);
  CHECK_NOTHROW(parse_mjcf(
      "<mujoco><worldbody><body name='file=1'><geom size='1'/></body></worldbody></mujoco>"));
  std::string deep;
  for (int i = 0; i < 100'000; ++i) deep += "<body>";
  CHECK(refused(deep).find("depth") != std::string::npos);
  CHECK_THROWS_AS(load_mjcf("/nowhere.xml"), SceneFileError);
}

}  // namespace mjcf_test
