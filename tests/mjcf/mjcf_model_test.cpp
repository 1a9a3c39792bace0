// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// What models of others have and how MuJoCo takes it: bodies without joints, meshes of many
// corners, who meets whom, joints in their order, and what a flag turns off.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <numbers>
#include <string>
#include <vector>

#include "models.h"
#include "support/bodies.h"
#include "support/catch.h"
#include "support/folder.h"
#include "tandem/mjcf.h"
#include "tandem/pbd/random.h"

namespace mjcf_test {
namespace {

using namespace tandem;
using tandem::testing::refusal;

TEST_CASE("mjcf: bodies without joints are parts of the one that moves", "[mjcf]") {
  SceneFile file = world(
      "<body name='arm'><joint axis='0 1 0'/><geom type='box' size='.1 .1 .1' mass='2'/>"
      "<body name='hand' pos='1 0 0' euler='0 90 0'><geom type='box' size='.1 .2 .3' mass='2'/>"
      "<body name='tip' pos='0 0 1'/></body></body>"
      "<body name='shelf' pos='0 0 -3'><geom type='box' size='1 1 .1'/></body>");
  const BodyId arm = file.find("arm");
  CHECK(file.find("hand") == arm);
  CHECK(file.find("tip") == arm);
  CHECK(file.joints.size() == 1);
  const pbd::BodyProps& props = file.scene.world().props(arm);
  CHECK(props.mass == Approx(4.0));
  CHECK(file.scene.world().pose(arm).position.isApprox(Vec3(0.5, 0.0, 0.0)));
  // The hand's x is the arm's -z, its z the arm's x.
  const double m3 = 2.0 / 3.0;
  const Vec3 moments(m3 * (0.02 + 0.01 + 0.04), m3 * (0.02 + 0.01 + 0.09) + 4.0 * 0.25,
                     m3 * (0.02 + 0.04 + 0.09) + 4.0 * 0.25);
  CHECK(props.inertia.isApprox(pbd::Mat3(moments.asDiagonal()), 1e-9));
  CHECK(file.pose("tip").position.isApprox(Vec3(2.0, 0.0, 0.0), 1e-9));
  CHECK(file.scene.world().props(file.find("shelf")).type == BodyType::Static);
  CHECK(file.scene.pose(file.find("shelf")).position == Vec3(0.0, 0.0, -3.0));
  CHECK(file.warnings.empty());
}

TEST_CASE("mjcf: of meshes with many corners, or flat ones, the nearest hull is taken", "[mjcf]") {
  std::string ball;
  for (int i = 0; i < 300; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / 300.0;
    const double turn = i * std::numbers::pi * (3.0 - std::sqrt(5.0));
    const double r = std::sqrt(1.0 - z * z);
    for (const double x : {r * std::cos(turn), r * std::sin(turn), z}) {
      ball += std::to_string(0.1 * x) + ' ';
    }
  }
  for (const auto& [vertices, told] :
       {std::pair{ball, "mesh b (by "},
        std::pair{std::string("0 0 0 1 0 0 1 1 0 0 1 0 0 0 .0001 1 0 .0001 1 1 .0001 0 1 .0001"),
                  "mesh b (by 0.5 mm)"}}) {
    const std::string text = std::string("<mujoco><asset><mesh name='b' vertex='") + vertices +
                             "'/></asset><worldbody><geom type='plane' size='5 5 1'/>"
                             "<body name='thing' pos='0 0 .5'><freejoint/>"
                             "<geom type='mesh' mesh='b'/></body></worldbody></mujoco>";
    SceneFile file = parse_mjcf(text);
    CHECK(is_told(file, told));
    run(file, 2.0);
    CHECK(std::abs(file.scene.world().pose(file.find("thing")).position.z()) < 0.11);
    CHECK(refusal([&] { parse_mjcf(text, {.strict = true}); }).find("ConvexHull") !=
          std::string::npos);
  }
}

TEST_CASE("mjcf: an ellipsoid lies on its flat side within 1.4 % of its height", "[mjcf]") {
  SceneFile file = world(
      "<geom type='plane' size='5 5 1'/><body name='stone' pos='0 0 .12' euler='0 90 0'>"
      "<freejoint/><geom type='ellipsoid' size='.1 .2 .3'/></body>");
  CHECK(is_told(file, "ellipsoid"));
  const double volume = 4.0 / 3.0 * std::numbers::pi * 0.1 * 0.2 * 0.3;
  CHECK(file.scene.world().props(file.find("stone")).mass == Approx(1000.0 * volume));
  run(file, 4.0);
  CHECK(std::abs(file.pose("stone").position.z() - 0.1) < 0.0014);
}

/// MuJoCo's binary form of a height field.
std::string elevations(std::int32_t rows, std::int32_t columns, const std::vector<float>& data) {
  std::string out(8 + 4 * data.size(), '\0');
  std::memcpy(out.data(), &rows, 4);
  std::memcpy(out.data() + 4, &columns, 4);
  std::memcpy(out.data() + 8, data.data(), 4 * data.size());
  return out;
}

TEST_CASE("mjcf: balls lie on a height field as high as it is there", "[mjcf]") {
  std::vector<float> data;
  for (int row = 0; row < 5; ++row) {
    // A plateau where x > 0 and y > 0.
    for (int column = 0; column < 9; ++column)
      data.push_back(row >= 3 && column >= 5 ? 1.0F : 0.0F);
  }
  const tandem::testing::Folder folder;
  folder.write("field.bin", elevations(5, 9, data));
  const auto ball = [](const std::string& name, const std::string& place) {
    return "<body name='" + name + "' pos='" + place +
           "'><freejoint/><geom type='sphere' size='.1'/></body>";
  };
  const std::string text =
      "<mujoco><asset><hfield name='f' file='field.bin' size='2 1 .5 .1'/></asset><worldbody>"
      "<geom type='hfield' hfield='f' pos='0 0 1'/>" +
      ball("both", "1.5 .75 1.7") + ball("x", "1.5 -.75 1.2") + ball("y", "-1.5 .75 1.2") +
      "</worldbody></mujoco>";
  SceneFile file = tandem::load_mjcf(folder.write("model.xml", text));
  run(file, 2.0);
  CHECK(file.pose("both").position.z() == Approx(1.6).margin(1e-3));
  CHECK(file.pose("x").position.z() == Approx(1.1).margin(1e-3));
  CHECK(file.pose("y").position.z() == Approx(1.1).margin(1e-3));
}

TEST_CASE("mjcf: points within a mesh's hull do not count", "[mjcf]") {
  std::string points = "0 0 0 1 0 0 0 1 0 0 0 1 ";
  for (int i = 0; i < 200; ++i) points += std::to_string(0.3 - 0.001 * i) + " .2 .2 ";
  MjcfOptions options;
  options.limits.hull_points = 8;
  const SceneFile file = parse_mjcf(std::string("<mujoco><asset><mesh name='m' vertex='") + points +
                                        "'/></asset><worldbody><body><freejoint/>"
                                        "<geom type='mesh' mesh='m'/></body></worldbody></mujoco>",
                                    options);
  const auto& hull = std::get<collision::Hull>(file.scene.shapes().collider({0, 0}).shape);
  CHECK(hull->points().size() == 4);
  CHECK(hull->volume() == Approx(1.0 / 6.0).epsilon(1e-6));
}

TEST_CASE("mjcf: geoms meet where either one's contype meets the other's conaffinity", "[mjcf]") {
  pbd::SplitMix64 random(46);
  for (int draw = 0; draw < 20; ++draw) {
    struct Bits {
      std::uint32_t type, affinity;
    };
    std::vector<Bits> bits;
    std::string text;
    for (int i = 0; i < 12; ++i) {
      // Without 0 and 0, which no collider is made of.
      const Bits one{static_cast<std::uint32_t>(random.below(8)),
                     static_cast<std::uint32_t>(1 + random.below(7))};
      bits.push_back(one);
      text += std::string("<body pos='") + std::to_string(i) +
              " 0 0'><freejoint/><geom size='.1' contype='" + std::to_string(one.type) +
              "' conaffinity='" + std::to_string(one.affinity) + "'/></body>";
    }
    const SceneFile file = world(text);
    const collision::CollisionScene& shapes = file.scene.shapes();
    REQUIRE(shapes.slot_count() == bits.size());
    for (std::uint32_t i = 0; i < bits.size(); ++i) {
      for (std::uint32_t j = 0; j < i; ++j) {
        CAPTURE(draw, bits[i].type, bits[i].affinity, bits[j].type, bits[j].affinity);
        const bool meet =
            (bits[i].type & bits[j].affinity) != 0 || (bits[j].type & bits[i].affinity) != 0;
        CHECK(may_meet(shapes.collider(shapes.collider_at(i)).filter,
                       shapes.collider(shapes.collider_at(j)).filter) == meet);
      }
    }
    CHECK(file.warnings.empty());
  }
  SceneFile falls = world(
      "<geom type='plane' size='5 5 1' contype='1' conaffinity='0'/>"
      "<body name='ball' pos='0 0 1'><freejoint/><geom size='.1' contype='0' conaffinity='1'/>"
      "</body><body name='ghost' pos='1 0 1'><freejoint/>"
      "<geom size='.1' contype='2' conaffinity='2'/></body>");
  run(falls, 2.0);
  CHECK(falls.scene.pose(falls.find("ball")).position.z() == Approx(0.1).margin(1e-3));
  CHECK(falls.scene.pose(falls.find("ghost")).position.z() < -10.0);
  // The default is the first category, as that of what an application adds.
  CHECK(world("<geom size='1' contype='2' conaffinity='3'/><geom size='1'/>")
            .scene.shapes()
            .collider({1, 0})
            .filter.category == 1);
  std::string many;
  for (int i = 1; i <= 32; ++i) {
    many += std::string("<geom size='1' contype='") + std::to_string(2 * i) + "'/>";
  }
  CHECK(refusal([&] { world(many); }).find("at most 32 pairs") != std::string::npos);
}

TEST_CASE("mjcf: slides and a hinge in any order of axes and to either hand", "[mjcf]") {
  for (const char* up : {"0 0 1", "0 0 -1"}) {
    for (const char* turn : {"0 1 0", "0 -1 0"}) {
      CAPTURE(up, turn);
      const double sign = std::string(up) == "0 0 1" ? 1.0 : -1.0;
      SceneFile file = world(
          std::string("<body name='root' pos='0 0 1'>"
                      "<joint name='x' type='slide' axis='1 0 0' range='-1 .1' limited='true'/>"
                      "<joint name='z' type='slide' limited='true' axis='") +
          up + "' range='" + (sign > 0.0 ? "-.25 1" : "-1 .25") +
          "'/><joint name='y' type='hinge' limited='true' range='-10 60' axis='" + turn +
          "'/><geom size='.1'/></body>");
      const BodyId root = file.find("root");
      const double spin = std::string(turn) == "0 1 0" ? 1.0 : -1.0;
      file.scene.world().set_twist(root, {{1.0, 0.0, 0.0}, {0.0, 2.0 * spin, 0.0}});
      run(file, 2.0);
      const Pose pose = file.scene.pose(root);
      CHECK((pose.position - Vec3(0.1, 0.0, 0.75)).norm() < 1e-3);
      // It has turned to its stop, 60 degrees about the hinge's axis.
      CHECK(pose.orientation.angularDistance(
                Quat(Eigen::AngleAxisd(spin * std::numbers::pi / 3.0, Vec3::UnitY()))) < 1e-2);
    }
  }
}

TEST_CASE("mjcf: slides behind a hinge turn with it", "[mjcf]") {
  const std::string slide = "<joint name='s' type='slide' axis='1 0 0'/>";
  const std::string hinge = "<joint name='h' axis='0 0 1'/>";
  const auto end = [](const std::string& joints) {
    SceneFile file = model(std::string("<option gravity='0 0 0'/><worldbody><body name='b'>") +
                           joints + "<geom size='.01' pos='1 0 0'/></body></worldbody>");
    file.scene.world().set_twist(file.find("b"), {{0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}});
    run(file, 1.0);
    return file.scene.world().pose(file.find("b")).position;
  };
  // A bead on a rod that turns freely and weighs nothing goes straight on.
  CHECK((end(hinge + slide) - Vec3(1.0, 1.0, 0.0)).norm() < 3e-3);
  // On a carriage that weighs nothing it keeps its speed along the carriage's way, which is 0.
  CHECK(end(slide + hinge).x() == Approx(1.0).margin(3e-3));
  // The carriage has the bead's speed, and the rod stands still.
  CHECK((end("<joint type='slide' axis='0 1 0'/>" + hinge + slide) - Vec3(1.0, 1.0, 0.0)).norm() <
        3e-3);
  // Along the hinge's axis it may stand anywhere.
  CHECK_NOTHROW(end(slide + hinge + "<joint type='slide' axis='0 0 1'/>"));
}

TEST_CASE("mjcf: flags turn parts off", "[mjcf]") {
  const auto with = [](const std::string& flag, const std::string& inside) {
    return model(std::string("<option><flag ") + flag + "='disable'/></option><worldbody>" +
                 inside + "</worldbody>");
  };
  CHECK(with("gravity", "").scene.world().gravity() == Vec3::Zero());
  for (const char* flag : {"contact", "constraint"}) {
    SceneFile file = with(flag,
                          "<geom type='plane' size='5 5 1'/><body name='b' pos='0 0 1'>"
                          "<freejoint/><geom size='.1'/></body>");
    run(file, 1.0);
    CHECK(file.scene.pose(file.find("b")).position.z() < -3.0);
  }
  const std::string arm =
      "<body><joint name='j' axis='0 1 0' range='-10 10' limited='true' stiffness='9' "
      "damping='3'/><geom size='.1' pos='1 0 0'/></body>";
  const auto axis = [&](const std::string& flag) {
    SceneFile file = with(flag, arm);
    return file.scene.joints().def(file.find_joint("j")).angular[0];
  };
  CHECK(axis("limit").freedom == pbd::Freedom::Free);
  CHECK(axis("constraint").freedom == pbd::Freedom::Free);
  CHECK(axis("passive").freedom == pbd::Freedom::Limited);
  CHECK(axis("passive").spring.stiffness == 0.0);
  CHECK(axis("passive").spring.damping == 0.0);
  CHECK(axis("limit").spring.damping == 3.0);
}

TEST_CASE("mjcf: condim 1 has no friction, a free joint's damping slows, mocap goes as told",
          "[mjcf]") {
  SceneFile puck = model(
      "<option gravity='3 0 -9.81'/><worldbody><geom type='plane' size='5 5 1' condim='1'/>"
      "<body name='puck' pos='0 0 .1'><freejoint/><geom type='box' size='.1 .1 .1' condim='1'/>"
      "</body></worldbody>");
  run(puck, 0.5);
  CHECK(puck.scene.pose(puck.find("puck")).position.x() == Approx(0.5 * 3.0 * 0.25).epsilon(1e-2));
  CHECK(puck.warnings.empty());

  SceneFile fly = world(
      "<body name='fly' pos='0 0 1'><joint type='free' damping='5'/><geom size='.1' mass='.4'/>"
      "</body><body name='hand' mocap='true' pos='0 1 1'><geom size='.1'/>"
      "<body name='ring' pos='.5 0 0'/></body>");
  fly.scene.world().set_twist(fly.find("fly"), {{}, {0.0, 0.0, 3.0}});
  const BodyId hand = fly.find("hand");
  CHECK(fly.scene.world().props(hand).type == BodyType::Kinematic);
  fly.scene.world().set_twist(hand, {{0.0, 2.0, 0.0}, {}});
  run(fly, 0.5);
  const double tau = 0.4 / 5.0;
  const double fall = 9.81 * tau * (0.5 - tau * (1.0 - std::exp(-0.5 / tau)));
  CHECK(fly.scene.pose(fly.find("fly")).position.z() == Approx(1.0 - fall).margin(2e-2 * fall));
  CHECK(fly.scene.world().twist(fly.find("fly")).angular.norm() < 1e-3);
  CHECK(fly.pose("ring").position.isApprox(Vec3(0.5, 2.0, 1.0), 1e-9));

  CHECK(is_told(world("<geom name='g' size='1' priority='1'/>"), "geom g: priority"));
  CHECK(is_told(world("<geom name='g' size='1' condim='1'/><geom size='1'/>"), "geom g: condim 1"));
  CHECK(is_told(world("<geom name='g' size='1' margin='.1'/>"), "geom g: margin"));
  CHECK(is_told(world("<geom name='g' size='1' solref='.1 1'/>"), "geom g: solref"));
}

TEST_CASE("mjcf: joints start at qpos0, at a keyframe, or as near as they may", "[mjcf]") {
  const std::string text =
      "<mujoco><option gravity='0 0 0'/><worldbody><body name='a' pos='0 0 1'>"
      "<joint name='s' type='slide' axis='1 0 0'/>"
      "<joint name='h' axis='0 1 0' range='30 90' limited='true'/><geom size='.1' pos='0 0 -1'/>"
      "<body name='b' pos='0 0 -1'><joint name='k' axis='0 1 0' ref='10' range='20 60' "
      "limited='true'/><geom size='.1'/></body></body></worldbody>"
      "<keyframe><key name='home' qpos='.5 .75 .6'/></keyframe></mujoco>";
  const auto check = [](SceneFile& file, double slide, double hinge, double knee) {
    const Vec3 b(slide - std::sin(hinge), 0.0, 1.0 - std::cos(hinge));
    const auto stand = [&] {
      CHECK((file.pose("b").position - b).norm() < 1e-9);
      CHECK(file.scene.joints().at(file.find_joint("h")).position[3] == Approx(hinge).margin(1e-9));
      CHECK(file.scene.joints().hinge_angle(file.find_joint("k")) == Approx(knee).margin(1e-9));
    };
    stand();
    for (int i = 0; i < 60; ++i) file.scene.step(1.0 / 60.0);
    stand();
  };
  constexpr double kDegree = std::numbers::pi / 180.0;
  SceneFile near = parse_mjcf(text);
  check(near, 0.0, 30.0 * kDegree, 10.0 * kDegree);  // from its ref of 10
  CHECK(is_told(near, "joint h (by 0.52 rad), k (by 0.17 rad)"));
  SceneFile home = parse_mjcf(text, {.keyframe = "home"});
  check(home, 0.5, 0.75, 0.6 - 10.0 * kDegree);
  CHECK(home.warnings.empty());
  CHECK(refusal([&] { parse_mjcf(text, {.keyframe = "away"}); }).find("\"away\"") !=
        std::string::npos);
}

TEST_CASE("mjcf: elements unknown to MuJoCo's schema are left out and told", "[mjcf]") {
  const std::string text = R"(<mujoco><option><flag nativeccd="enable" gravity="disable"/></option>
    <worldbody><body name="a"><joint name="j" axis="0 1 0" actuatorfrcrange = '-1 1'
        range="-10 10" limited="true"/><geom name="actuatorfrcrange" size=".1"/>
      <body name="b"><joint actuatorfrcrange="-2 2" name="k" axis="1 0 0"/><geom size=".1"/></body>
    </body></worldbody>
    <sensor>
      <novelty name="n"><part name="x"/></novelty>
      <jointpos joint="j"/>
    </sensor></mujoco>)";
  SceneFile file = parse_mjcf(text);
  CHECK(is_told(file, "<joint>: actuatorfrcrange is not accepted by MuJoCo"));
  CHECK(is_told(file, "(2 times)"));
  CHECK(is_told(file, "<flag>: nativeccd is not accepted"));
  CHECK(is_told(file, "<novelty>: the element is not accepted"));
  CHECK(is_told(file, "sensor 0: not read"));
  CHECK(file.scene.world().gravity() == Vec3::Zero());
  CHECK(file.scene.joints().def(file.find_joint("j")).angular[0].upper ==
        Approx(std::numbers::pi / 18.0));
  CHECK(file.find_joint("k") != pbd::JointId{});
  CHECK(refusal([&] { parse_mjcf(text, {.strict = true}); }).find("unrecognized attribute") !=
        std::string::npos);
  // Neither is how later versions integrate.
  const std::string later =
      "<mujoco><option integrator='implicitfast' gravity='0 0 -1'/><worldbody>"
      "<light mode='targetbody' target='a'/><body name='a'><geom size='.1'/></body></worldbody>"
      "</mujoco>";
  SceneFile newer = parse_mjcf(later);
  CHECK(is_told(newer, "<option>: \"implicitfast\" is not accepted by MuJoCo"));
  CHECK(newer.scene.world().gravity() == Vec3(0.0, 0.0, -1.0));
  CHECK(refusal([&] { parse_mjcf(later, {.strict = true}); }).find("implicitfast") !=
        std::string::npos);
  // A range means a limit by now.
  SceneFile range = world(
      "<body><joint name='j' axis='0 1 0' range='-10 10'/><geom size='.1' pos='1 0 0'/></body>");
  CHECK(range.scene.joints().def(range.find_joint("j")).angular[0].freedom ==
        pbd::Freedom::Limited);
  CHECK(is_told(range, "autolimits is on"));
  // Also in an included model.
  const tandem::testing::Folder folder;
  folder.write("part.xml",
               "<mujoco><worldbody><body name='b'><joint actuatorfrcrange='-1 1'/>"
               "<geom size='.1'/></body></worldbody></mujoco>");
  const std::string path = folder.write("model.xml", "<mujoco><include file='part.xml'/></mujoco>");
  CHECK(is_told(load_mjcf(path), "<joint>: actuatorfrcrange"));
}

}  // namespace
}  // namespace mjcf_test
