// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "scenes/doll.h"

#include <numbers>

#include "scenes/place.h"

namespace tandem::bench {
namespace {

/// A bone's joint to its parent.
struct Hold {
  int parent = -1;  ///< none
  Vec3 joint = Vec3::Zero();
  Vec3 axis = Vec3::UnitZ();  ///< of twist, or of the hinge
  double cone = 0.0;          ///< degrees; 0: a hinge
  double lower = 0.0, upper = 0.0;
  double friction = 1.0;  ///< fraction of kDollFriction
};

/// A capsule between two points.
struct Bone {
  Vec3 from, to;
  double radius = 0.0;
  Hold hold;
};

constexpr double kDollFriction = 5.0;  // N m
constexpr int kBelly = 1;
constexpr int kChest = 3;
constexpr int kMiddle = 6;  // symmetric bones come first, then those of the left

// Box3D's human (shared/human.c, MIT licence, Erin Catto), to the millimetre, with its capsules,
// limits and friction; right limbs mirror left ones. Joints are at the child's frame, so that all
// start closed, and a cone is about the initial pose.
const std::array<Bone, 10>& bones() {
  static const std::array<Bone, 10> kBones{{
      // pelvis
      {{-0.044, 0.07, 1.012}, {-0.044, -0.07, 1.012}, 0.13, {}},
      // belly
      {{-0.03, 0.06, 1.166},
       {-0.03, -0.06, 1.166},
       0.12,
       {0, {-0.034, 0, 1.121}, {0.095, 0, 0.995}, 25, -15, 15}},
      // waist
      {{-0.043, 0.08, 1.286},
       {-0.043, -0.08, 1.286},
       0.1,
       {1, {-0.027, 0, 1.203}, {-0.01, 0, 1}, 25, -15, 15}},
      // chest
      {{-0.081, 0.11, 1.436},
       {-0.081, -0.11, 1.436},
       0.145,
       {2, {-0.028, 0, 1.31}, {-0.103, 0, 0.995}, 15, -10, 10}},
      // neck
      {{-0.045, 0, 1.592},
       {-0.016, 0, 1.645},
       0.07,
       {3, {-0.056, 0, 1.576}, {0.549, 0, 0.836}, 45, -15, 15, 0.8}},
      // head
      {{0.021, 0, 1.709},
       {0.008, 0, 1.768},
       0.0975,
       {4, {-0.001, 0, 1.658}, {0.126, 0, 0.992}, 15, -15, 15, 0.4}},
      // thigh
      {{-0.041, 0.121, 0.952},
       {-0.032, 0.101, 0.557},
       0.09,
       {0, {-0.035, 0.09, 0.986}, {-0.005, 1, 0.024}, 10, -60, 40}},
      // shin
      {{-0.036, 0.101, 0.537},
       {-0.111, 0.098, 0.108},
       0.075,
       {6, {-0.037, 0.101, 0.527}, {-0.138, 0.99, 0.019}, 0, -5, 45}},
      // upper arm
      {{-0.116, 0.204, 1.484},
       {-0.118, 0.301, 1.254},
       0.075,
       {kChest, {-0.116, 0.204, 1.484}, {-0.006, 0.389, -0.921}, 60, -5, 5}},
      // forearm
      {{-0.118, 0.306, 1.243},
       {-0.015, 0.414, 0.983},
       0.05,
       {8, {-0.118, 0.306, 1.243}, {-0.055, -0.913, -0.403}, 0, -5, 60}},
  }};
  return kBones;
}

double capsule_mass(double radius, double half_height) {
  return kWaterDensity * std::numbers::pi * radius * radius *
         (2.0 * half_height + 4.0 / 3.0 * radius);
}

/// The same bone on the right: mirrored points, and rotations about the mirrored axis.
Bone mirrored(Bone bone) {
  for (Vec3* point : {&bone.from, &bone.to, &bone.hold.joint}) point->y() = -point->y();
  bone.hold.axis = Vec3(-bone.hold.axis.x(), bone.hold.axis.y(), -bone.hold.axis.z());
  return bone;
}

void add_bone(Scene& scene, const Pose& frame, const Bone& bone, int parent) {
  const Vec3 along = bone.to - bone.from;
  const CapsuleShape shape{bone.radius, 0.5 * along.norm()};
  const Quat turn = frame.orientation * Quat::FromTwoVectors(Vec3::UnitZ(), along);
  const int body = scene.add(shape, capsule_mass(shape.radius, shape.half_height),
                             {frame.to_world(0.5 * (bone.from + bone.to)), turn});
  scene.bodies.back().limb = true;
  if (parent < 0) return;
  const JointKind kind = bone.hold.cone > 0.0 ? JointKind::Ball : JointKind::Hinge;
  constexpr double kRad = std::numbers::pi / 180.0;
  SceneJoint& joint = scene.add_joint(kind, parent, body, frame.to_world(bone.hold.joint));
  joint.axis_w = frame.orientation * bone.hold.axis.normalized();
  joint.limited = true;
  joint.lower = kRad * bone.hold.lower;
  joint.upper = kRad * bone.hold.upper;
  if (bone.hold.cone > 0.0) joint.cone = kRad * bone.hold.cone;
  joint.friction = kDollFriction * bone.hold.friction;
  joint.touch = false;
}

}  // namespace

void add_doll(Scene& scene, const Pose& frame) {
  const int first = static_cast<int>(scene.bodies.size());
  const auto& all = bones();
  const int count = static_cast<int>(all.size());
  for (int i = 0; i < count; ++i) {
    const Bone& bone = all[static_cast<std::size_t>(i)];
    add_bone(scene, frame, bone, bone.hold.parent < 0 ? -1 : first + bone.hold.parent);
  }
  // A right limb is attached to a right one if there is one.
  for (int i = kMiddle; i < count; ++i) {
    const Bone bone = mirrored(all[static_cast<std::size_t>(i)]);
    const int parent =
        bone.hold.parent < kMiddle ? bone.hold.parent : bone.hold.parent + count - kMiddle;
    add_bone(scene, frame, bone, first + parent);
  }
  const int left = first + kMiddle;
  const int right = first + count;
  scene.apart.insert(scene.apart.end(),
                     {{left, right}, {first + kBelly, left}, {first + kBelly, right}});
}

}  // namespace tandem::bench
