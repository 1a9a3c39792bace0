// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Actuators of hinges and slides whose force is affine: what they do by formula, and by MuJoCo.
#include <cmath>
#include <numbers>
#include <string>

#include "models.h"
#include "mujoco.h"
#include "support/bodies.h"
#include "support/catch.h"
#include "tandem/pbd/random.h"

namespace mjcf_test {
namespace {

using namespace tandem;
using tandem::testing::refusal;

/// Of 2 kg, each on a way along x, with nothing else about.
std::string carts(int count, const std::string& joint, const std::string& actuators) {
  std::string out = "<option gravity='0 0 0'/><worldbody>";
  for (int i = 0; i < count; ++i) {
    const std::string n = std::to_string(i);
    out += std::string("<body name='b") + n + "' pos='0 " + n + " 0'><joint name='j" + n +
           "' type='slide' axis='1 0 0' " + joint + "/><geom size='.1' mass='2'/></body>";
  }
  return out + "</worldbody><actuator>" + actuators + "</actuator>";
}
double x(const SceneFile& file, const char* name) { return file.pose(name).position.x(); }

TEST_CASE("mjcf: motors push alike everywhere", "[mjcf]") {
  SceneFile file =
      model(carts(4, "",
                  "<motor name='push' joint='j0' gear='3'/>"
                  "<motor name='bound' joint='j1' ctrllimited='true' ctrlrange='-1 2'/>"
                  "<motor name='weak' joint='j2' gear='2' forcelimited='true' "
                  "forcerange='-1 1'/>"
                  "<general name='base' joint='j3' gainprm='2' biastype='affine' "
                  "biasprm='3 0 0'/>"));
  CHECK(file.warnings.empty());
  REQUIRE(file.actuators.size() == 4);
  CHECK(file.actuators[1].upper == 2.0);
  for (const char* name : {"push", "bound", "weak", "base"}) file.set_control(name, 4.0);
  run(file, 1.0);
  CHECK(x(file, "b0") == Approx(0.5 * 12.0 / 2.0).epsilon(5e-3));
  CHECK(x(file, "b1") == Approx(0.5 * 2.0 / 2.0).epsilon(5e-3));
  CHECK(x(file, "b2") == Approx(0.5 * 2.0 / 2.0).epsilon(5e-3));
  CHECK(x(file, "b3") == Approx(0.5 * 11.0 / 2.0).epsilon(5e-3));
  // Against dry friction: 4 N less 1 N, and 0.5 N, which move nothing.
  SceneFile dry = model(
      carts(2, "frictionloss='1'", "<motor name='m' joint='j0'/><motor name='n' joint='j1'/>"));
  CHECK(dry.warnings.empty());
  dry.set_control("m", 4.0);
  dry.set_control("n", 0.5);
  run(dry, 1.0);
  CHECK(x(dry, "b0") == Approx(0.5 * 3.0 / 2.0).epsilon(5e-3));
  CHECK(std::abs(x(dry, "b1")) < 1e-6);
  // A servo so weak that it is a push: 4 N less 2e-4 N for each metre.
  SceneFile weak = model(carts(1, "",
                               "<general joint='j0' gainprm='1' biastype='affine' "
                               "biasprm='4 -.0002 0'/>"));
  run(weak, 1.0);
  CHECK(x(weak, "b0") == Approx(1.0).epsilon(5e-3));
  // Far away as near, and backwards.
  const double v = file.scene.world().twist(file.find("b3")).linear.x();
  const double at = x(file, "b3");
  file.set_control("base", -4.0);
  run(file, 0.5);
  CHECK(x(file, "b3") - at == Approx(0.5 * v - 0.125 * 5.0 / 2.0).epsilon(5e-3));
}

TEST_CASE("mjcf: servos add up to a spring and a damper, from qpos0, to either hand", "[mjcf]") {
  // Critical: 2 kg, 50 N/m in all, 20 N s/m; gear 2 makes 10 N/m of 2.5.
  SceneFile file = model(carts(1, "stiffness='15' springref='.2' damping='5' ref='.5'",
                               "<position name='p' joint='j0' kp='2.5' gear='2'/>"
                               "<position name='q' joint='j0' kp='25'/>"
                               "<velocity name='v' joint='j0' kv='15'/>"));
  CHECK(file.warnings.empty());
  file.set_control("p", 3.0);
  file.set_control("q", 0.4);
  file.set_control("v", 0.1);
  const double rest = (15.0 * 0.2 + 2.0 * 2.5 * 3.0 + 25.0 * 0.4 + 15.0 * 0.1) / 50.0 - 0.5;
  run(file, 0.2);
  const double omega = 5.0;
  const double part = 1.0 - (1.0 + omega * 0.2) * std::exp(-omega * 0.2);
  CHECK(x(file, "b0") == Approx(rest * part).epsilon(2e-2));
  run(file, 4.0);
  CHECK(x(file, "b0") == Approx(rest).epsilon(1e-5));
  // It sleeps by now, and a control wakes it.
  file.set_control("v", -0.5);
  run(file, 4.0);
  CHECK(x(file, "b0") == Approx(rest - 15.0 * 0.6 / 50.0).epsilon(1e-5));

  // The speed of a velocity servo, gear and all: 2 kg, 8 N s/m.
  SceneFile cart = model(carts(1, "", "<velocity name='v' joint='j0' kv='2' gear='2'/>"));
  cart.set_control(0, 3.0);
  run(cart, 0.25);
  CHECK(cart.scene.world().twist(cart.find("b0")).linear.x() ==
        Approx(1.5 * (1.0 - std::exp(-4.0 * 0.25))).epsilon(2e-2));
  run(cart, 3.0);
  CHECK(cart.scene.world().twist(cart.find("b0")).linear.x() == Approx(1.5).epsilon(1e-4));

  // A slide behind a hinge runs the other way here.
  SceneFile back = model(
      "<option gravity='0 0 0'/><worldbody><body name='b'><joint name='h' axis='0 0 1'/>"
      "<joint name='s' type='slide' axis='1 0 0'/><geom size='.1' mass='1'/></body></worldbody>"
      "<actuator><position name='turn' joint='h' kp='9'/><velocity joint='h' kv='2'/>"
      "<position name='out' joint='s' kp='9'/><velocity joint='s' kv='6'/></actuator>");
  back.set_control("turn", 0.5);
  back.set_control("out", 0.7);
  run(back, 6.0);
  CHECK((back.pose("b").position - 0.7 * Vec3(std::cos(0.5), std::sin(0.5), 0.0)).norm() < 1e-3);
}

TEST_CASE("mjcf: controls are a keyframe's at first, and a flag turns all of them off", "[mjcf]") {
  const auto at_rest = [](const std::string& flag, const std::string& key) {
    SceneFile file =
        parse_mjcf(std::string("<mujoco><option>") + flag + "</option>" +
                       carts(1, "damping='20'", "<position joint='j0' kp='50'/>") +
                       "<keyframe><key name='far' qpos='.1' ctrl='.5'/></keyframe></mujoco>",
                   {.keyframe = key});
    run(file, 5.0);
    return x(file, "b0");
  };
  CHECK(at_rest("", "far") == Approx(0.5).epsilon(1e-3));
  CHECK(at_rest("", "") == Approx(0.0).margin(1e-9));
  CHECK(at_rest("<flag actuation='disable'/>", "far") == Approx(0.1).epsilon(1e-6));
}

TEST_CASE("mjcf: other actuators are told, once for all of a kind", "[mjcf]") {
  const SceneFile file = model(
      "<worldbody><site name='s'/><body><joint name='b' type='ball'/><geom size='.1'/></body>"
      "<body pos='0 1 0'><joint name='j' axis='0 0 1'/><geom size='.1'/></body></worldbody>"
      "<actuator><motor name='one' joint='b'/><motor name='two' site='s'/>"
      "<general name='three' joint='j' biastype='affine' biasprm='0 1 0'/>"
      "<position name='four' joint='j' forcelimited='true' forcerange='-1 1'/>"
      "<velocity name='eight' joint='j' forcelimited='true' forcerange='-1 2'/>"
      "<damper name='five' joint='j' ctrlrange='0 1'/>"
      "<general name='six' joint='j' dyntype='filter'/>"
      "<intvelocity name='seven' joint='j' kp='1' actrange='-1 1'/></actuator>");
  CHECK(is_told(file, "actuator one: it acts on a ball"));
  CHECK(is_told(file, "actuator two: it acts on no joint"));
  CHECK(is_told(file, "actuator five, six, seven: its force is not affine"));
  CHECK(is_told(file, "actuator three: its stiffness or damping is negative"));
  CHECK(is_told(file, "actuator four, eight: forcerange is not kept where several"));
  REQUIRE(file.actuators.size() == 2);
  CHECK(file.actuators[0].name == "four");
}

TEST_CASE("mjcf: controls that cannot be are refused", "[mjcf][errors]") {
  SceneFile file = model(carts(1, "", "<motor name='m' joint='j0'/>"));
  CHECK(refusal([&] { file.set_control("n", 1.0); }).find("\"n\"") != std::string::npos);
  CHECK(refusal([&] { file.set_control(1, 1.0); }).find("SceneFile::actuators") !=
        std::string::npos);
  CHECK(refusal([&] { file.set_control("m", NAN); }).find("control must be finite") !=
        std::string::npos);
  CHECK(file.actuators[0].control == 0.0);
  CHECK(refusal([&] {
          model(carts(1, "",
                      "<motor joint='j0' gear='1e308'/><general joint='j0' gainprm='1e308' "
                      "gear='1e308'/>"));
        }).find("joint j0: ") != std::string::npos);
  file.scene.remove(file.find("b0"));
  CHECK_FALSE(refusal([&] { file.set_control("m", 1.0); }).empty());
}

TEST_CASE("mjcf: a servo pulls with its forcerange at most", "[mjcf]") {
  // 2 kg beside a spring of 10 N/m and dry friction; gear 2 makes 8 N of 4, from 1.6 m away on.
  SceneFile file = model(carts(3, "stiffness='10' damping='10' frictionloss='.5'",
                               "<position name='p' joint='j0' kp='100' gear='2' forcelimited='true'"
                               " forcerange='-4 4'/>"
                               "<velocity name='v' joint='j1' kv='8' forcelimited='true'"
                               " forcerange='-6 6' ctrllimited='true' ctrlrange='-2 2'/>"
                               "<position name='w' joint='j2' kp='20' forcelimited='true'"
                               " forcerange='-1 3'/>"));
  CHECK(is_told(file, "actuator w: the larger bound of forcerange is kept either way"));
  REQUIRE(file.actuators.size() == 3);
  CHECK(file.actuators[0].max_force == 8.0);
  file.set_control("p", 3.0);
  file.set_control("v", 5.0);
  CHECK(file.actuators[1].control == 2.0);
  run(file, 12.0);
  CHECK(x(file, "b0") == Approx((8.0 - 0.5) / 10.0).epsilon(1e-2));
  CHECK(x(file, "b1") == Approx((6.0 - 0.5) / 10.0).epsilon(1e-2));
  // It is written with its bound.
  SceneFile again = parse_scene(write_scene(file));
  const pbd::JointMotor& motor = again.scene.joints().def(again.find_joint("j0")).linear[0].motor;
  CHECK(motor.max_force == 8.0);
  CHECK(motor.stiffness == Approx(400.0));
}

/// A chain of hinges about any axes, each with a position servo.
struct Arm {
  int links;
  std::string text;
  /// @param bound  N m, of each servo's joint; 0: none
  Arm(pbd::SplitMix64& random, double bound) {
    const auto number = [&](double low, double high) {
      return std::to_string(random.uniform(low, high)) + ' ';
    };
    links = 2 + static_cast<int>(random.below(4));
    text = "<mujoco><compiler angle='radian'/><worldbody>";
    std::string actuators;
    for (int i = 0; i < links; ++i) {
      const std::string n = std::to_string(i);
      text += std::string("<body name='b") + n + "' pos='" + (i == 0 ? "0" : ".3") +
              " 0 0' euler='" + number(-1, 1);
      text += number(-1, 1);
      text += number(-1, 1);
      text += "'><joint name='j" + n + "' axis='" + number(-1, 1);
      text += number(-1, 1);
      text += std::string("1' damping='3' ref='") + number(-0.3, 0.3) +
              "'/><geom type='capsule' size='.04' fromto='0 0 0 .3 0 0'/>";
      actuators += std::string("<position name='a") + n + "' joint='j" + n + "' gear='2' kp='" +
                   number(8.0, 20.0) + "'";
      if (bound > 0.0) {
        const std::string most = std::to_string(0.5 * random.uniform(0.2, 1.0) * bound);
        actuators += std::string(" forcelimited='true' forcerange='-") + most + " " + most + "'";
      }
      actuators += "/>";
    }
    for (int i = 0; i < links; ++i) text += "</body>";
    text += "</worldbody><actuator>" + actuators + "</actuator></mujoco>";
  }
};

TEST_CASE("mjcf: arms of position servos come to the pose that MuJoCo's come to", "[mjcf]") {
  pbd::SplitMix64 random(2026);
  const bool bounded = GENERATE(false, true);
  int at_bound = 0;
  for (int draw = 0; draw < 20; ++draw) {
    CAPTURE(bounded, draw);
    const Arm arm(random, bounded ? 12.0 : 0.0);
    SceneFile file = parse_mjcf(arm.text);
    CHECK(file.warnings.empty());
    Mujoco reference(arm.text, 1e-3);
    for (int i = 0; i < arm.links; ++i) {
      const double control = random.uniform(-1.0, 1.0);
      file.set_control(static_cast<std::size_t>(i), control);
      reference.data().ctrl[i] = control;
    }
    run(file, 2.0);
    reference.run(2.0);
    double farthest = 0.0;
    for (int i = 0; i < arm.links; ++i) {
      CAPTURE(i);
      const std::string joint = 'j' + std::to_string(i);
      const double angle = file.scene.joints().hinge_angle(file.find_joint(joint));
      CHECK(std::abs(angle - reference.moved(i)) < std::numbers::pi / 180.0);
      farthest = std::max(farthest, std::abs(reference.moved(i)));
      const double most = reference.model().actuator_forcerange[2 * i + 1];
      if (bounded && std::abs(reference.data().actuator_force[i]) > 0.999 * most) ++at_bound;
    }
    CHECK(farthest > 0.1);
  }
  if (bounded) CHECK(at_bound >= 10);
}

}  // namespace
}  // namespace mjcf_test
