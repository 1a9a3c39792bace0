// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/urdf.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <tuple>

#include "support/bodies.h"
#include "support/catch.h"

namespace urdf_test {

using namespace tandem;
using tandem::testing::refusal;

/// An arm on a stand, 1.5 m up, whose link is turned about z and whose mass lies 0.3 m down.
const std::string kArm = R"(<?xml version="1.0"?>
<robot name="arm">
  <link name="stand"><collision><geometry><box size="1 1 0.2"/></geometry></collision></link>
  <link name="arm">
    <inertial><origin xyz="0 0 -0.3" rpy="0 0 0.4"/><mass value="2"/>
      <inertia ixx="0.05" ixy="0" ixz="0" iyy="0.05" iyz="0" izz="0.02"/></inertial>
    <collision><origin xyz="0 0 -0.3"/><geometry><cylinder radius="0.05" length="0.5"/></geometry></collision>
  </link>
  <link name="box"><inertial><mass value="3"/><inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.02"/></inertial>
    <collision><geometry><box size="0.2 0.2 0.2"/></geometry></collision></link>
  <joint name="shoulder" type="revolute"><parent link="stand"/><child link="arm"/>
    <origin xyz="2 0 1.5" rpy="0 0 1.2"/><axis xyz="0 1 0"/>
    <limit lower="-0.5" upper="1.5" effort="12" velocity="3"/><dynamics damping="0" friction="0.1"/></joint>
  <joint name="lift" type="prismatic"><parent link="stand"/><child link="box"/>
    <origin xyz="0 0 1"/><axis xyz="0 0 1"/><limit lower="-0.25" upper="2" effort="9" velocity="1"/></joint>
  <gazebo><plugin/></gazebo>
</robot>)";

TEST_CASE("urdf: an arm swings in the time that the formula says, and a lift rests on its stop",
          "[urdf]") {
  std::string smooth = kArm;
  smooth.replace(smooth.find("friction=\"0.1\""), 14, "friction=\"0.0\"");
  SceneFile file = parse_urdf(smooth);
  Scene& scene = file.scene;
  const BodyId arm = file.find("arm");
  CHECK(scene.pose(arm).position.isApprox(Vec3(2.0, 0.0, 1.5)));
  CHECK(scene.world().pose(arm).position.isApprox(Vec3(2.0, 0.0, 1.2)));
  CHECK(scene.world().props(arm).mass == 2.0);
  const pbd::JointId shoulder = file.find_joint("shoulder");
  CHECK(scene.joints().def(shoulder).angular[0].motor.max_force == 12.0);
  CHECK(scene.joints().def(shoulder).angular[0].upper == 1.5);
  // A push about the joint's axis, which the origin has turned.
  const Vec3 axis(-std::sin(1.2), std::cos(1.2), 0.0);
  const Vec3 spin = 0.25 * axis;
  scene.world().set_twist(arm, {spin.cross(Vec3(0.0, 0.0, -0.3)), spin});
  const double period =
      2.0 * std::numbers::pi * std::sqrt((0.05 + 2.0 * 0.09) / (2.0 * 9.81 * 0.3));
  constexpr double kStep = 1.0 / 240.0;
  int turns = 0;
  double first = 0.0, last = 0.0, before = 0.0;
  for (int i = 1; i <= 240 * 10; ++i) {
    scene.step(kStep);
    const double angle = scene.joints().hinge_angle(shoulder);
    if (before < 0.0 && angle >= 0.0) {
      last = (i - 1 + before / (before - angle)) * kStep;
      if (turns++ == 0) first = last;
    }
    before = angle;
  }
  REQUIRE(turns > 5);
  CHECK((last - first) / (turns - 1) == Approx(period).epsilon(2e-3));
  CHECK(scene.pose(file.find("box")).position.z() == Approx(0.75).margin(1e-3));
}

TEST_CASE("urdf: a joint starts on the turn within its limits, or at the nearest one", "[urdf]") {
  for (const auto& [limits, angle, moved] :
       {std::tuple{"lower='6.1' upper='6.5'", 2.0 * std::numbers::pi, 0},
        {"lower='0.2' upper='4'", 0.2, 1},
        {"lower='2' upper='4.2'", 2.0, 1},
        {"lower='2.4' upper='4.4'", 4.4, 1}}) {
    INFO(limits);
    SceneFile file = parse_urdf(
        "<robot name='r'><link name='a'/><link name='b'><inertial><mass value='1'/><inertia "
        "ixx='1' ixy='0' ixz='0' iyy='1' iyz='0' izz='1'/></inertial></link><joint name='j' "
        "type='revolute'><parent link='a'/><child link='b'/><axis xyz='0 0 1'/><limit " +
        std::string(limits) + " effort='1' velocity='1'/></joint></robot>");
    const pbd::JointId id = file.find_joint("j");
    CHECK(file.scene.joints().hinge_angle(id) == Approx(angle).margin(1e-12));
    for (int i = 0; i < 60; ++i) file.scene.step(1.0 / 60.0);
    CHECK(file.scene.joints().hinge_angle(id) == Approx(angle).margin(1e-6));
    CHECK(file.scene.pose(file.find("b"))
              .orientation.angularDistance(Quat(Eigen::AngleAxisd(angle, Vec3::UnitZ()))) < 1e-6);
    CHECK(std::count_if(file.warnings.begin(), file.warnings.end(), [](const std::string& one) {
            return one.find("joint j (by ") == 0;
          }) == moved);
  }
}

TEST_CASE("urdf: dry friction of a joint takes its share of a force, and holds smaller ones",
          "[urdf]") {
  // 2 kg on lifts, and an arm that a push turns by its energy over the friction.
  const auto lift = [](const std::string& name, const std::string& friction) {
    return "<link name='" + name +
           "'><inertial><mass value='2'/><inertia ixx='1' ixy='0' ixz='0' iyy='1' iyz='0' "
           "izz='1'/></inertial></link><joint name='j" +
           name + "' type='prismatic'><parent link='base'/><child link='" + name +
           "'/><axis xyz='0 0 1'/><limit lower='-9' upper='9' effort='1' velocity='1'/>"
           "<dynamics friction='" +
           friction + "'/></joint>";
  };
  SceneFile file = parse_urdf("<robot name='r'><link name='base'/>" + lift("slow", "9.62") +
                              lift("held", "19.63") + "</robot>");
  for (int i = 0; i < 240; ++i) file.scene.step(1.0 / 240.0);
  CHECK(file.scene.pose(file.find("slow")).position.z() ==
        Approx(-0.5 * (9.81 - 9.62 / 2.0)).epsilon(1e-2));
  CHECK(std::abs(file.scene.pose(file.find("held")).position.z()) < 1e-9);
  SceneFile arm = parse_urdf(kArm, {.scene = {.gravity = Vec3::Zero()}});
  const BodyId id = arm.find("arm");
  const Vec3 spin = 0.5 * Vec3(-std::sin(1.2), std::cos(1.2), 0.0);
  arm.scene.world().set_twist(id, {spin.cross(Vec3(0.0, 0.0, -0.3)), spin});
  for (int i = 0; i < 480; ++i) arm.scene.step(1.0 / 240.0);
  CHECK(arm.scene.joints().hinge_angle(arm.find_joint("shoulder")) ==
        Approx(0.5 * (0.05 + 2.0 * 0.09) * 0.25 / 0.1).epsilon(1e-2));
  CHECK(refusal([&] {
          parse_urdf("<robot name='r'><link name='base'/>" + lift("one", "-1") + "</robot>");
        }).find("joint jone: ") != std::string::npos);
}

TEST_CASE("urdf: features that Tandem lacks are told", "[urdf]") {
  const SceneFile file = parse_urdf(kArm);
  const auto told = [&](const char* what) {
    for (const std::string& warning : file.warnings) {
      if (warning.find(what) != std::string::npos) return true;
    }
    return false;
  };
  CHECK(told("<gazebo>"));
  CHECK_FALSE(told("friction"));
  CHECK_FALSE(told("lift"));
}

TEST_CASE("urdf: a base may be free, and links that say no mass have a tip's", "[urdf]") {
  const std::string text = R"(<robot name="x"><link name="base">
    <collision><geometry><sphere radius="0.1"/></geometry></collision></link></robot>)";
  SceneFile held = parse_urdf(text, {.base = {.position = {0.0, 0.0, 2.0}}});
  CHECK(held.scene.world().props(held.find("base")).type == BodyType::Static);
  CHECK(held.warnings.empty());
  SceneFile file = parse_urdf(text, {.base = {.position = {0.0, 0.0, 2.0}},
                                     .fixed_base = false,
                                     .tip_mass = 0.5,
                                     .tip_radius = 0.1});
  const auto& props = file.scene.world().props(file.find("base"));
  CHECK(props.mass == 0.5);
  CHECK(props.inertia(0, 0) == Approx(0.4 * 0.5 * 0.01));
  REQUIRE(file.warnings.size() == 1);
  CHECK(file.warnings[0].find("link base") == 0);
  file.scene.world().set_twist(file.find("base"), {.linear = {1.0, 0.0, 0.0}});
  for (int i = 0; i < 60; ++i) file.scene.step(1.0 / 120.0);
  CHECK(file.scene.pose(file.find("base")).position.x() == Approx(0.5).epsilon(1e-3));
}

TEST_CASE("urdf: a robot has no more than it may", "[urdf][errors]") {
  const std::string shape = "<collision><geometry><sphere radius='0.1'/></geometry></collision>";
  const std::string text = "<robot name='r'><link name='a'>" + shape + "</link><link name='b'>" +
                           shape + shape +
                           "</link><joint name='j' type='continuous'><parent link='a'/>"
                           "<child link='b'/></joint></robot>";
  const auto told = [&](std::size_t SceneLimits::*what, std::size_t most) {
    UrdfOptions options;
    options.limits.*what = most;
    return tandem::testing::refusal([&] { parse_urdf(text, options); });
  };
  CHECK(told(&SceneLimits::bodies, 2).empty());
  CHECK(told(&SceneLimits::bodies, 1).find("SceneLimits::bodies") != std::string::npos);
  CHECK(told(&SceneLimits::colliders, 2).find("SceneLimits::colliders") != std::string::npos);
  CHECK(told(&SceneLimits::parts, 1).find("SceneLimits::parts") != std::string::npos);
  CHECK(told(&SceneLimits::joints, 0).find("SceneLimits::joints") != std::string::npos);
}

TEST_CASE("urdf: invalid files are refused", "[urdf][errors]") {
  const auto refused = [](const std::string& text) {
    return refusal([&] { parse_urdf(text, {}, "arm.urdf"); }).find("arm.urdf: ") == 0;
  };
  CHECK(refused(""));
  CHECK(refused("<robot"));
  CHECK(refused("<robot name='x'/>"));
  std::string deep;
  for (int i = 0; i < 100'000; ++i) deep += "<a>";
  CHECK(refused(deep));
  // Nothing within a value, a comment or a declaration closes an element.
  for (const std::string open : {"<a b=\"/>\">", "<a><!-- </a> -->", "<a b='</a>'>", "<a b=c'>",
                                 "<a><![CDATA[</a>]]>", "<a><?x </a>?>"}) {
    deep.clear();
    for (int i = 0; i < 150'000; ++i) deep += open;
    CAPTURE(open);
    CHECK(refused(deep));
  }
  // Each link is held to the next by two joints: 2^30 bodies.
  std::string doubled = "<robot name='r'><link name='l0'/>";
  for (int i = 0; i < 30; ++i) {
    const std::string from = std::to_string(i);
    const std::string to = std::to_string(i + 1);
    doubled += "<link name='l" + to + "'/>";
    for (const std::string side : {"a", "b"}) {
      doubled += "<joint name='" + side + from + "' type='fixed'><parent link='l" + from +
                 "'/><child link='l" + to + "'/></joint>";
    }
  }
  CHECK(refused(doubled + "</robot>"));
  std::string heavy = kArm;
  heavy.replace(heavy.find("value=\"2\""), 9, "value=\"-2\"");
  CHECK(refused(heavy));
  for (std::size_t length = 0; length + 9 < kArm.size(); length += 7) {
    CAPTURE(length);
    CHECK(refused(kArm.substr(0, length)));
  }
  CHECK_THROWS_AS(load_urdf("/nowhere.urdf"), SceneFileError);
}

}  // namespace urdf_test
