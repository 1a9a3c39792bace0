// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// E5: a joint that is violated when it is made closes gently, without residual motion.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "everyday/ground.h"
#include "everyday/group.h"

namespace tandem::everyday {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kHopeless = 1e3;  // rad/s: a faster case has failed

struct Arm {
  double lower, upper, start;  ///< degrees
  bool world;                  ///< attached to the world, otherwise to a body of the same size
};

/// An arm of 1 m on a vertical hinge, where gravity does no work.
void hinge(Tally& tally, const Arm& arm, double length) {
  Scene scene({.gravity = Vec3::Zero()});
  const Vec3 half(0.5 * length, 0.05 * length, 0.05 * length);
  const Quat turn(Eigen::AngleAxisd(arm.start * kDegree, Vec3::UnitZ()));
  const BodyId body = scene.add(
      Box{half}, {.pose = {.position = turn * Vec3(0.5 * length, 0.0, 0.0), .orientation = turn},
                  .filter = {.group = -1}});
  pbd::HingeJointDef def;
  def.b = body;
  if (!arm.world) {
    def.a = scene.add(
        Box{half}, {.pose = {.position = Vec3(0.5 * length, 0.0, 0.0)}, .filter = {.group = -1}});
    def.frame_a.anchor = Vec3(-0.5 * length, 0.0, 0.0);
  }
  // The joint's x is the bodies' z.
  def.frame_a.basis = Quat(Eigen::AngleAxisd(-std::numbers::pi / 2.0, Vec3::UnitY()));
  def.frame_b = {.anchor = Vec3(-0.5 * length, 0.0, 0.0), .basis = def.frame_a.basis};
  def.axis = {
      .freedom = pbd::Freedom::Limited, .lower = arm.lower * kDegree, .upper = arm.upper * kDegree};
  def.start = arm.start * kDegree;  // poses do not tell whole turns
  const pbd::JointId joint = scene.add_joint(def);
  double fastest = 0.0;
  for (int i = 0; i < 180 && fastest < kHopeless; ++i) {
    scene.step(kFrame);
    fastest = std::max(fastest, scene.world().twist(body).angular.norm());
  }
  const std::string which =
      told({{"from", arm.lower}, {"to", arm.upper}, {"at", arm.start}, {"world", arm.world}});
  const double weight = scene.world().props(body).mass * kGravity * length;
  tally.at_most("spin while it closes", fastest, 10.0, "rad/s", which);
  tally.at_most("spin left", scene.world().twist(body).angular.norm(), 5.0, "rad/s", which);
  tally.at_most("energy left", scene.world().kinetic_energy() / weight, 0.1, "m g l", which);
  const double angle = scene.joints().hinge_angle(joint) / kDegree;
  const double nearest = std::clamp(arm.start, arm.lower, arm.upper);
  // A start within the limits is kept; another one ends within them.
  const double off = arm.start == nearest
                         ? std::abs(angle - nearest)
                         : std::abs(angle - std::clamp(angle, arm.lower, arm.upper));
  tally.at_most("angle off", off, 1.0, "degrees", which);
}

void hinges(Tally& tally, Extent extent) {
  for (const bool world : {true, false}) {
    for (const Arm& arm : std::vector<Arm>{{170, 190, 181, world},
                                           {170, 190, 189, world},
                                           {170, 190, 171, world},
                                           {0, 270, 200, world},
                                           {0, 270, 269, world},
                                           {190, 260, 200, world},
                                           {90, 190, 189, world},
                                           {-190, -170, -181, world},
                                           {-270, 0, -200, world},
                                           {90, 110, 0, world},
                                           {-30, 30, 120, world},
                                           {-30, 30, 31, world},
                                           {350, 370, 362, world},
                                           {-720, 720, 400, world}}) {
      for (const double length :
           extent == Extent::Full ? std::vector{0.1, 1.0, 5.0} : std::vector{1.0}) {
        hinge(tally, arm, length);
      }
    }
  }
}

enum class Kind { Ball, Fixed, Slider, Hinge };

/// Two bodies with separated anchors.
void apart(Tally& tally, Kind kind, double distance, double length) {
  Scene scene({.gravity = Vec3::Zero()});
  const Vec3 half(0.5 * length, 0.05 * length, 0.05 * length);
  const BodyId a = scene.add(Box{half}, {.filter = {.group = -1}});
  const Vec3 way = distance * Vec3(0.6, 0.64, 0.48);
  const BodyId b = scene.add(
      Box{half}, {.pose = {.position = Vec3(length, 0.0, 0.0) + way}, .filter = {.group = -1}});
  const pbd::JointFrame frame_a{.anchor = Vec3(0.5 * length, 0.0, 0.0)};
  const pbd::JointFrame frame_b{.anchor = Vec3(-0.5 * length, 0.0, 0.0)};
  switch (kind) {
    case Kind::Ball:
      scene.add_joint(pbd::BallJointDef{.a = a, .b = b, .frame_a = frame_a, .frame_b = frame_b});
      break;
    case Kind::Fixed:
      scene.add_joint(pbd::FixedJointDef{.a = a, .b = b, .frame_a = frame_a, .frame_b = frame_b});
      break;
    case Kind::Slider:
      scene.add_joint(pbd::SliderJointDef{.a = a, .b = b, .frame_a = frame_a, .frame_b = frame_b});
      break;
    case Kind::Hinge:
      scene.add_joint(pbd::HingeJointDef{.a = a, .b = b, .frame_a = frame_a, .frame_b = frame_b});
      break;
  }
  double speed = 0.0;
  double spin = 0.0;
  for (int i = 0; i < 300 && spin < kHopeless; ++i) {
    scene.step(kFrame);
    speed = std::max(speed, scene.world().twist(b).linear.norm());
    spin = std::max(spin, scene.world().twist(b).angular.norm());
  }
  const std::string which =
      told({{"kind", static_cast<double>(kind)}, {"apart", distance}, {"length", length}});
  tally.at_most("speed while it closes", speed, 5.0, "m/s", which);
  tally.at_most("spin while it closes", spin, 10.0, "rad/s", which);
  tally.at_most("spin left", scene.world().twist(b).angular.norm(), 5.0, "rad/s", which);
  const double weight = scene.world().props(b).mass * kGravity * length;
  tally.at_most("energy left", scene.world().kinetic_energy() / weight, 0.1, "m g l", which);
}

void anchors(Tally& tally, Extent extent) {
  for (const Kind kind : {Kind::Ball, Kind::Fixed, Kind::Slider, Kind::Hinge}) {
    for (const double distance :
         extent == Extent::Full ? std::vector{0.01, 0.1, 1.0, 10.0, 104.0} : std::vector{1.0}) {
      for (const double length :
           extent == Extent::Full ? std::vector{0.1, 1.0, 5.0} : std::vector{1.0}) {
        apart(tally, kind, distance, length);
      }
    }
  }
}

}  // namespace

std::vector<Group> joint_groups() {
  return {{"E5", "hinges beyond half a turn", "none", hinges, true},
          {"E5", "joints whose anchors begin apart", "none", anchors, true}};
}

}  // namespace tandem::everyday
