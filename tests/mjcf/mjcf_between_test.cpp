// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Bodies with several joints that no single one stands for.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "humanoid.h"
#include "models.h"
#include "mujoco.h"
#include "support/catch.h"
#include "tandem/pbd/random.h"

namespace mjcf_test {
namespace {

using namespace tandem;

TEST_CASE("mjcf: limbs of a humanoid swing as MuJoCo's do", "[mjcf]") {
  constexpr double kDegree = std::numbers::pi / 180.0;
  for (const char* joint : {"damping='1' stiffness='1'", "damping='0'"}) {
    CAPTURE(joint);
    const std::string text =
        Humanoid(joint, "", "<flag contact='disable' limit='disable'/>", "", 2.0).text;
    SceneFile file = parse_mjcf(text);
    CHECK(is_told(file, "light bodies stand between"));
    Mujoco reference(text, 1e-4);
    for (int i = 0; i < 480; ++i) file.scene.step(1.0 / 960.0);
    reference.run(0.5);
    const mjModel& m = reference.model();
    double most = 0.0;
    for (int j = 0; j < m.njnt; ++j) {
      const char* name = mj_id2name(&m, mjOBJ_JOINT, j);
      CAPTURE(name);
      CHECK(std::abs(file.scene.joints().hinge_angle(file.find_joint(name)) - reference.moved(j)) <
            0.2 * kDegree);
      most = std::max(most, std::abs(reference.moved(j)));
    }
    CHECK(most > 30.0 * kDegree);
    for (int b = 2; b < m.nbody; ++b) {
      const Pose pose = file.pose(mj_id2name(&m, mjOBJ_BODY, b));
      const mjtNum* at = reference.data().xpos + 3 * b;
      CHECK((pose.position - Vec3(at[0], at[1], at[2])).norm() < 1e-3);
      CHECK(pose.orientation.angularDistance(reference.turn(b)) < 0.2 * kDegree);
    }
  }
}

TEST_CASE("mjcf: a humanoid falls on its joints and comes to rest", "[mjcf]") {
  pbd::SplitMix64 random(7);
  const auto three = [&](double size) {
    Vec3 out;
    for (int i = 0; i < 3; ++i) out[i] = random.uniform(-size, size);
    return out;
  };
  for (int draw = 0; draw < 6; ++draw) {
    CAPTURE(draw);
    SceneFile file = parse_mjcf(Humanoid("damping='1' stiffness='1'", "<freejoint/>", "",
                                         "<geom type='plane' size='9 9 1'/>", 1.4 + 0.1 * draw)
                                    .text);
    const Vec3 speed = three(3.0);
    file.scene.world().set_twist(file.find("torso"), {speed, three(3.0)});
    double spin = 0.0;
    for (int i = 0; i < 300; ++i) {
      file.scene.step(1.0 / 60.0);
      for (const SceneFile::Body& one : file.bodies) {
        spin = std::max(spin, file.scene.world().twist(one.body).angular.norm());
      }
    }
    CHECK(spin > 5.0);
    CHECK(spin < 100.0);
    for (const SceneFile::Body& one : file.bodies) {
      CHECK(file.scene.world().twist(one.body).linear.norm() < 0.3);
      CHECK(file.scene.world().pose(one.body).position.z() > -0.05);
    }
    for (const SceneFile::Joint& one : file.joints) {
      if (one.name.empty()) continue;
      CHECK(file.scene.joints().at(one.joint).residual < 0.05);
    }
  }
}

TEST_CASE("mjcf: hinges of a body start at a keyframe, each in its place", "[mjcf]") {
  const std::string text =
      "<mujoco><compiler angle='radian'/><option gravity='0 0 0'/><worldbody><body name='a' "
      "pos='0 0 1'><joint name='x' axis='1 0 0' ref='.1'/><joint name='s' type='slide' "
      "axis='1 1 0'/><joint name='z' axis='0 0 1' pos='.1 0 0' range='.5 1' limited='true'/>"
      "<joint name='y' axis='0 1 .5'/><geom type='box' size='.1 .2 .3' pos='0 0 -1'/></body>"
      "</worldbody><keyframe><key name='home' qpos='.5 .25 .75 4'/></keyframe></mujoco>";
  SceneFile file = parse_mjcf(text, {.keyframe = "home"});
  const auto check = [&] {
    const pbd::JointBlock& joints = file.scene.joints();
    CHECK(joints.hinge_angle(file.find_joint("x")) == Approx(0.4).margin(1e-9));
    CHECK(file.find_joint("z") == file.find_joint("s"));
    const auto& place = joints.at(file.find_joint("s")).position;
    CHECK(place[3] == Approx(0.75).margin(1e-9));
    CHECK(Vec3(place[0], place[1], place[2]).cwiseAbs().maxCoeff() == Approx(0.25).margin(1e-9));
    CHECK(joints.hinge_angle(file.find_joint("y")) == Approx(4.0).margin(1e-9));
  };
  check();
  run(file, 0.5);
  check();
  // At qpos0 the range is not met: it starts at its nearer end.
  SceneFile moved = parse_mjcf(text);
  const auto& place = moved.scene.joints().at(moved.find_joint("z")).position;
  CHECK(place[3] == Approx(0.5).margin(1e-9));
}

TEST_CASE("mjcf: intermediate bodies take nothing from the weight", "[mjcf]") {
  SceneFile file = parse_mjcf(Humanoid("damping='0'", "<freejoint/>", "", "", 1.4).text);
  Mujoco reference(Humanoid("damping='0'", "<freejoint/>", "", "", 1.4).text, 1e-3);
  double weighing = 0.0;
  const pbd::World& world = file.scene.world();
  for (std::uint32_t i = 0; i < world.body_count(); ++i) {
    const pbd::BodyProps& props = world.props(world.body_at(i));
    weighing += props.gravity_scale * props.mass;
  }
  CHECK(weighing == Approx(reference.model().body_subtreemass[0]).epsilon(1e-12));
  CHECK(world.body_count() ==
        file.bodies.size() + 9);  // one at the abdomen, two a hip, one a foot and shoulder
}

}  // namespace
}  // namespace mjcf_test
