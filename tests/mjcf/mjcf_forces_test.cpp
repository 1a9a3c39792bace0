// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// What acts along the coordinates of a model's joints: dry friction, damping and springs.
#include <cmath>
#include <numbers>
#include <string>

#include "models.h"
#include "mujoco.h"
#include "support/catch.h"

namespace mjcf_test {
namespace {

using namespace tandem;

TEST_CASE("mjcf: frictionloss takes its share of a force and holds smaller ones", "[mjcf]") {
  // 2 kg and 6 N along x; the classes say how much of it friction takes.
  const auto moved = [](const std::string& flag) {
    SceneFile file =
        model("<option gravity='3 0 0'>" + flag +
              "</option><default><default class='rough'><joint frictionloss='4'/></default>"
              "<default class='stuck'><joint frictionloss='6.1'/></default></default><worldbody>"
              "<body name='rough'><joint class='rough' type='slide' axis='1 0 0'/>"
              "<geom size='.1' mass='2'/></body>"
              "<body name='stuck' pos='0 1 0'><joint class='stuck' type='slide' axis='-1 0 0'/>"
              "<geom size='.1' mass='2'/></body></worldbody>");
    CHECK(file.warnings.empty());
    run(file, 1.0);
    return std::pair{file.pose("rough").position.x(), file.pose("stuck").position.x()};
  };
  const auto [rough, stuck] = moved("");
  CHECK(rough == Approx(0.5 * (6.0 - 4.0) / 2.0).epsilon(1e-2));
  CHECK(std::abs(stuck) < 1e-9);
  for (const char* flag : {"frictionloss", "constraint"}) {
    const auto [free, too] = moved(std::string("<flag ") + flag + "='disable'/>");
    CHECK(free == Approx(1.5).epsilon(1e-2));
    CHECK(too == Approx(1.5).epsilon(1e-2));
  }
  // A hinge: 2 kg at 1 m, with the moment of the ball itself.
  SceneFile hinge = model(
      "<option gravity='0 0 0'/><worldbody><body name='b'><joint name='j' axis='0 0 1' "
      "frictionloss='3'/><geom size='.1' pos='1 0 0' mass='2'/></body></worldbody>");
  hinge.scene.world().set_twist(hinge.find("b"), {{0.0, 2.0, 0.0}, {0.0, 0.0, 2.0}});
  run(hinge, 3.0);
  const double moment = 2.0 + 0.4 * 2.0 * 0.01;
  CHECK(hinge.scene.joints().hinge_angle(hinge.find_joint("j")) ==
        Approx(0.5 * moment * 4.0 / 3.0).epsilon(1e-2));
}

/// A ball of 10 kg and 0.2 m that turns about its centre, and stands askew at first.
struct Globe {
  static constexpr double kMoment = 0.4 * 10.0 * 0.04;
  SceneFile file;

  explicit Globe(const std::string& joint)
      : file(model("<option gravity='0 0 0'/><worldbody><body name='globe' euler='30 20 70'>"
                   "<joint name='j' type='ball' " +
                   joint + "/><geom size='.2' mass='10'/></body></worldbody>")) {}
  /// @param spin  rad/s, about its own axes; it keeps that axis.
  void spin(const Vec3& spin) { file.scene.world().set_twist(body(), {{}, turn() * spin}); }
  BodyId body() const { return file.find("globe"); }
  Quat turn() const { return file.scene.pose(body()).orientation; }
  double speed() const { return file.scene.world().twist(body()).angular.norm(); }
};

TEST_CASE("mjcf: a ball has friction about each of its own axes, damping, and a spring", "[mjcf]") {
  Globe one("frictionloss='.2'");
  one.spin(3.0 * Vec3::UnitX());
  run(one.file, 1.0);
  CHECK(one.speed() == Approx(3.0 - 0.2 / Globe::kMoment).epsilon(1e-3));
  Globe all("frictionloss='.2'");
  all.spin(Vec3(3.0, 3.0, 3.0));
  run(all.file, 1.0);
  CHECK(all.speed() == Approx(std::sqrt(3.0) * (3.0 - 0.2 / Globe::kMoment)).epsilon(1e-3));
  run(all.file, 3.0);
  CHECK(all.speed() < 1e-6);

  // Also beyond half a turn, about any axis.
  Globe damped("damping='.1'");
  damped.spin(Vec3(3.0, -2.0, 1.0));
  run(damped.file, 2.0);
  CHECK(damped.speed() ==
        Approx(std::sqrt(14.0) * std::exp(-2.0 * 0.1 / Globe::kMoment)).epsilon(5e-3));

  Globe sprung("stiffness='4'");
  const Quat rest = sprung.turn();
  const double omega = std::sqrt(4.0 / Globe::kMoment);
  sprung.spin(omega * 0.5 * Vec3(0.6, 0.0, 0.8));  // half a radian far
  run(sprung.file, 0.25 * 2.0 * std::numbers::pi / omega);
  CHECK(sprung.turn().angularDistance(rest) == Approx(0.5).epsilon(2e-2));
  CHECK(sprung.file.warnings.empty());
}

TEST_CASE("mjcf: rotors of joints, inner ones too, act as in MuJoCo", "[mjcf]") {
  // Of 2 kg that fall with a rotor of 3 kg.
  SceneFile lift = world(
      "<body name='lift'><joint type='slide' axis='0 0 1' armature='3'/>"
      "<geom size='.1' mass='2'/></body>");
  run(lift, 0.5);
  CHECK(lift.pose("lift").position.z() == Approx(-0.125 * 9.81 * 2.0 / 5.0).epsilon(1e-2));
  CHECK(lift.warnings.empty());
  // A pole on a cart, both with rotors, and a second ball whose rotor turns with it.
  const std::string text =
      "<mujoco><worldbody><body name='cart'><joint name='x' type='slide' axis='1 0 0' "
      "armature='.7'/><geom size='.1' mass='2'/><body name='pole' euler='0 50 0'>"
      "<joint name='h' axis='0 1 0' armature='.4'/><geom size='.1' pos='0 0 -.5' mass='1'/>"
      "</body></body><body name='ball' pos='0 1 0' euler='40 0 0'>"
      "<joint name='b' type='ball' armature='.2'/><geom size='.1' pos='0 0 -.5' mass='1'/>"
      "<body name='inner' pos='0 0 -.5' euler='70 0 0'><joint name='i' axis='1 0 0' "
      "armature='.05'/><geom size='.05' pos='0 0 -.3' mass='.3'/></body>"
      "</body></worldbody></mujoco>";
  SceneFile file = parse_mjcf(text);
  CHECK(file.warnings.empty());
  Mujoco reference(text, 1e-4);
  run(file, 1.0);
  reference.run(1.0);
  CHECK(std::abs(file.pose("cart").position.x() - reference.moved(0)) < 2e-3);
  CHECK(std::abs(reference.moved(0)) > 0.1);
  CHECK(std::abs(file.scene.joints().hinge_angle(file.find_joint("h")) - reference.moved(1)) <
        std::numbers::pi / 180.0);
  CHECK(file.pose("ball").orientation.angularDistance(reference.turn(3)) <
        std::numbers::pi / 180.0);
  CHECK(reference.turn(3).angularDistance(Quat(Eigen::AngleAxisd(0.7, Vec3::UnitX()))) > 0.3);
  CHECK(std::abs(file.scene.joints().hinge_angle(file.find_joint("i")) - reference.moved(3)) <
        std::numbers::pi / 180.0);
  CHECK(std::abs(reference.moved(3)) > 0.3);
}

TEST_CASE("mjcf: omitted features of joints are told", "[mjcf]") {
  const std::string text =
      "<worldbody><body name='a'><joint name='f' type='free' frictionloss='1' armature='1'/>"
      "<geom size='.1'/></body><body pos='0 1 0'><joint name='b' type='ball' armature='1'/>"
      "<geom size='.1'/><body><joint name='h' axis='0 0 1' armature='1'/><geom size='.1'/><body>"
      "<joint name='i' axis='0 0 1' armature='1'/><geom size='.1'/></body></body></body>"
      "</worldbody><equality><joint name='e' joint1='h' joint2='i' polycoef='0 1 1 0 0'/>"
      "<joint name='g' joint1='i'/><joint name='k' joint1='i' active='false'/>"
      "<connect name='c' body1='a' anchor='0 0 0'/></equality>";
  const SceneFile file = model(text);
  CHECK(is_told(file, "joint f: frictionloss of free joints"));
  CHECK(is_told(file, "joint f: armature of free joints"));
  CHECK(is_told(file, "equality e, g: couplings of joints are left out"));
  CHECK(is_told(file, "equality c: left out"));
  CHECK_FALSE(is_told(file, "equality k"));
  CHECK_FALSE(is_told(model("<option><flag equality='disable'/></option>" + text), "equality"));
}

TEST_CASE("mjcf: hinges that an equality couples keep its line", "[mjcf][coupling]") {
  SceneFile file = model(
      "<compiler angle='radian'/><worldbody><body><joint name='x' axis='0 1 0' ref='.3'/>"
      "<geom type='capsule' size='.03' fromto='0 0 0 .3 0 0'/></body><body pos='0 1 0'>"
      "<joint name='y' axis='0 -1 0'/><geom type='capsule' size='.03' fromto='0 0 0 .2 0 0'/>"
      "</body></worldbody><equality><joint joint1='y' joint2='x' polycoef='0 -.5 0 0 0'/>"
      "</equality>");
  CHECK(file.warnings.empty());
  double farthest = 0.0;
  for (int i = 0; i < 120; ++i) {
    file.scene.step(1.0 / 60.0);
    const double x = file.scene.joints().hinge_angle(file.find_joint("x"));
    const double y = file.scene.joints().hinge_angle(file.find_joint("y"));
    CHECK(std::abs(y + 0.5 * x) < 1e-4);
    farthest = std::max(farthest, std::abs(x));
  }
  CHECK(farthest > 0.5);
}

}  // namespace
}  // namespace mjcf_test
