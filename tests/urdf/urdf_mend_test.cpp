// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Robots as they are found: frame links without mass, links on fixed joints, inertias that were
// rounded or never filled in.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "support/bodies.h"
#include "support/catch.h"
#include "tandem/urdf.h"

namespace urdf_test {
namespace {

using namespace tandem;
using tandem::testing::refusal;

std::string inertial(double mass, const std::string& diagonal, const std::string& origin = "") {
  return "<inertial>" + origin + "<mass value='" + std::to_string(mass) + "'/><inertia " +
         diagonal + " ixy='0' ixz='0' iyz='0'/></inertial>";
}
std::string joint(const std::string& name, const std::string& type, const std::string& from,
                  const std::string& to, const std::string& inside = "") {
  return "<joint name='" + name + "' type='" + type + "'><parent link='" + from +
         "'/><child link='" + to + "'/>" + inside + "</joint>";
}
std::string link(const std::string& name, const std::string& inside = "") {
  return "<link name='" + name + "'>" + inside + "</link>";
}
/// An arm on a hinge whose own inertial is given.
std::string arm(const std::string& inside) {
  return std::string("<robot name='r'>") + link("base") + link("arm", inside) +
         joint("j", "continuous", "base", "arm", "<axis xyz='0 1 0'/>") + "</robot>";
}
std::size_t count_told(const SceneFile& file, const std::string& what) {
  return static_cast<std::size_t>(std::count_if(
      file.warnings.begin(), file.warnings.end(),
      [&](const std::string& warning) { return warning.find(what) != std::string::npos; }));
}

TEST_CASE("urdf: links on fixed joints are one body with the inertia of all", "[urdf]") {
  // Two rods of 2 kg at right angles, the second one turned and 1 m out, and a frame at its end.
  const std::string text =
      std::string("<robot name='r'>") + link("base") +
      link("arm", inertial(2.0, "ixx='0.3' iyy='0.3' izz='0.01'")) +
      link("hand", inertial(2.0, "ixx='0.3' iyy='0.3' izz='0.01'", "<origin xyz='0 0 0.5'/>")) +
      link("tip", inertial(0.0, "ixx='0' iyy='0' izz='0'")) + link("lens") +
      joint("j", "continuous", "base", "arm", "<axis xyz='0 1 0'/>") +
      joint("f", "fixed", "arm", "hand", "<origin xyz='0 0 1' rpy='0 1.5707963267948966 0'/>") +
      joint("g", "fixed", "hand", "tip", "<origin xyz='0 0 1'/>") +
      joint("h", "fixed", "hand", "lens", "<origin xyz='0 0 -1'/>") + "</robot>";
  SceneFile file = parse_urdf(text);
  Scene& scene = file.scene;
  const BodyId body = file.find("arm");
  for (const char* part : {"hand", "tip", "lens"}) CHECK(file.find(part) == body);
  CHECK(scene.world().body_count() == 2);
  CHECK(file.joints.size() == 1);
  const pbd::BodyProps& props = scene.world().props(body);
  CHECK(props.mass == 4.0);
  // The hand's middle lies at (0.5, 0, 1): that of both is half way.
  CHECK(scene.world().pose(body).position.isApprox(Vec3(0.25, 0.0, 0.5), 1e-12));
  const double xx = 0.3 + 0.01 + 4.0 * 0.25;
  const double yy = 0.3 + 0.3 + 4.0 * (0.25 + 0.0625);
  const double zz = 0.01 + 0.3 + 4.0 * 0.0625;
  const double xz = -4.0 * 0.25 * 0.5;
  pbd::Mat3 inertia;
  inertia << xx, 0.0, xz, 0.0, yy, 0.0, xz, 0.0, zz;
  CHECK(props.inertia.isApprox(inertia, 1e-12));
  // Frames stay known, where their body goes.
  CHECK(file.pose("tip").position.isApprox(Vec3(1.0, 0.0, 1.0), 1e-12));
  scene.world().set_gravity(Vec3::Zero());
  scene.world().set_twist(body, {Vec3(0.0, 1.0, 0.0).cross(Vec3(0.25, 0.0, 0.5)), Vec3::UnitY()});
  for (int i = 0; i < 60; ++i) scene.step(1.0 / 120.0);
  const double c = std::cos(0.5), s = std::sin(0.5);
  CHECK((file.pose("tip").position - Vec3(c + s, 0.0, c - s)).norm() < 2e-3);
  CHECK((file.pose("lens").position - Vec3(-c + s, 0.0, s + c)).norm() < 2e-3);
  CHECK(count_told(file, "tip: mass 0") == 1);
  CHECK(file.warnings.size() == 1);
  CHECK(refusal([&] { file.pose("nobody"); }).find("\"nobody\"") != std::string::npos);
  // As the document was written, and no other: bodies have one name.
  const SceneFile again = parse_scene(write_scene(file));
  CHECK(again.find("arm").valid());
  CHECK_FALSE(again.find("tip").valid());
  CHECK(refusal([&] { parse_urdf(text, {.strict = true}); }).find("link tip: ") !=
        std::string::npos);
}

TEST_CASE("urdf: links fixed to the world are static, each a body of its own", "[urdf]") {
  const std::string text = std::string("<robot name='r'>") + link("world") +
                           link("stand", inertial(0.0, "ixx='0' iyy='0' izz='0'")) +
                           joint("f", "fixed", "world", "stand", "<origin xyz='1 0 0'/>") +
                           "</robot>";
  SceneFile file = parse_urdf(text);
  CHECK(file.scene.world().props(file.find("stand")).type == BodyType::Static);
  CHECK(file.scene.pose(file.find("stand")).position == Vec3(1.0, 0.0, 0.0));
  CHECK(file.scene.world().body_count() == 2);
}

TEST_CASE("urdf: an inertia that no body can have becomes the nearest one", "[urdf]") {
  struct Case {
    const char* given;
    Vec3 moments;
  };
  const double ball = 0.4 * 2.0 * 1e-4;  // of 2 kg and 1 cm
  for (const Case& each :
       {// Rounded below 0; the rod's other moments stay.
        Case{"ixx='0.3' iyy='0.3' izz='-1e-22'", {0.3 + 0.5 * ball, 0.3 + 0.5 * ball, ball}},
        // Never filled in.
        Case{"ixx='0' iyy='0' izz='0'", {ball, ball, ball}},
        // The triangle rule, broken by rounding and by far: second moments (0.155, 0.145, -0.005)
        // and (0.5, 0.5, -0.4).
        Case{"ixx='0.14' iyy='0.15' izz='0.3'", {0.145, 0.155, 0.3}},
        Case{"ixx='0.1' iyy='0.1' izz='1'", {0.5, 0.5, 1.0}}}) {
    CAPTURE(each.given);
    const std::string text = arm(inertial(2.0, each.given));
    const SceneFile file = parse_urdf(text);
    const pbd::Mat3& inertia = file.scene.world().props(file.find("arm")).inertia;
    CHECK(inertia.isApprox(pbd::Mat3(each.moments.asDiagonal()), 1e-9));
    CHECK(count_told(file, "link arm (by ") == 1);
    CHECK(refusal([&] { parse_urdf(text, {.strict = true}); }).find("inertia") !=
          std::string::npos);
  }
  // A value far below 0 is not due to rounding.
  CHECK(refusal([&] {
          parse_urdf(arm(inertial(2.0, "ixx='0.1' iyy='0.1' izz='-0.08'")));
        }).find("positive definite") != std::string::npos);
  CHECK(refusal([&] {
          parse_urdf(arm(inertial(-1.0, "ixx='1' iyy='1' izz='1'")));
        }).find("link arm: mass") != std::string::npos);
}

TEST_CASE("urdf: a link without mass that moves by itself has a tip's mass", "[urdf]") {
  const std::string text = arm(inertial(0.0, "ixx='0' iyy='0' izz='0'"));
  const SceneFile file = parse_urdf(text, {.tip_mass = 0.5, .tip_radius = 0.1});
  CHECK(file.scene.world().props(file.find("arm")).mass == 0.5);
  CHECK(count_told(file, "link arm: mass 0 of what moves by itself") == 1);
}

TEST_CASE("urdf: a warning about many links is told once", "[urdf]") {
  std::string text = std::string("<robot name='r'>") + link("l0");
  for (int i = 1; i < 20; ++i) {
    const std::string number = std::to_string(i);
    const std::string name = "l" + number;
    text += link(name, inertial(1.0, "ixx='0' iyy='0' izz='0'"));
    text += joint(
        "j" + number, "revolute", "l0", name,
        "<limit lower='-1' upper='1' effort='1' velocity='1'/><safety_controller k_velocity='1'/>");
  }
  const SceneFile file = parse_urdf(text + "</robot>");
  REQUIRE(file.warnings.size() == 2);
  CHECK(file.warnings[0].find("l19 (by ") != std::string::npos);
  CHECK(file.warnings[1].find("joint j1, ") == 0);
  CHECK(file.warnings[1].find("j19") != std::string::npos);
}

/// A knee as all quadrupeds have it, with a shin on it, and a lift that cannot be down.
std::string leg() {
  const std::string heavy = inertial(1.0, "ixx='0.01' iyy='0.01' izz='0.01'");
  return std::string("<robot name='r'>") + link("base") + link("calf", heavy) +
         link("foot", heavy) + link("lift", heavy) +
         joint("knee", "revolute", "base", "calf",
               "<origin xyz='0 0 1'/><axis xyz='0 1 0'/>"
               "<limit lower='-2.7' upper='-0.9' effort='9' velocity='9'/>") +
         joint("ankle", "revolute", "calf", "foot",
               "<origin xyz='0 0 -0.5'/><axis xyz='0 1 0'/>"
               "<limit lower='0.4' upper='1' effort='9' velocity='9'/>") +
         joint("up", "prismatic", "base", "lift",
               "<origin xyz='3 0 0'/><axis xyz='0 0 1'/>"
               "<limit lower='0.25' upper='1' effort='9' velocity='9'/>") +
         "</robot>";
}

TEST_CASE("urdf: a joint outside its limits at zero starts within, at rest", "[urdf]") {
  SceneFile file = parse_urdf(leg());
  const auto angle = [&](SceneFile& of, const char* name) {
    return of.scene.joints().hinge_angle(of.find_joint(name));
  };
  CHECK(angle(file, "knee") == Approx(-0.9).margin(1e-12));
  CHECK(angle(file, "ankle") == Approx(0.4).margin(1e-12));
  // The calf points down at the joints' zero, and has turned by -0.9 about y.
  const Vec3 foot(0.5 * std::sin(0.9), 0.0, 1.0 - 0.5 * std::cos(0.9));
  CHECK(file.pose("foot").position.isApprox(foot, 1e-12));
  CHECK(file.pose("lift").position.isApprox(Vec3(3.0, 0.0, 0.25), 1e-12));
  CHECK(count_told(file, "joint knee (by 0.9 rad), ") == 1);
  CHECK(count_told(file, "up (by 0.25 m)") == 1);
  // Nothing pushes it in: the lift lies on its stop, and without gravity all stay.
  file.scene.world().set_gravity(Vec3::Zero());
  for (int i = 0; i < 60; ++i) file.scene.step(1.0 / 60.0);
  CHECK(file.pose("foot").position.isApprox(foot, 1e-9));
  CHECK(file.pose("lift").position.z() == Approx(0.25).margin(1e-9));

  SceneFile told = parse_urdf(leg(), {.start = {{"knee", -2.0}, {"up", 0.5}, {"ankle", 9.0}}});
  CHECK(angle(told, "knee") == Approx(-2.0).margin(1e-12));
  CHECK(angle(told, "ankle") == Approx(1.0).margin(1e-12));
  CHECK(told.pose("lift").position.z() == Approx(0.5));
  CHECK(count_told(told, "knee") == 0);
  CHECK(refusal([] {
          parse_urdf(leg(), {.start = {{"nobody", 1.0}}});
        }).find("start") != std::string::npos);
}

}  // namespace
}  // namespace urdf_test
