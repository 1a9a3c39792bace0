// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "engine/tandem_joints.h"

#include <cmath>

#include "tandem/pbd/distance_joint.h"
#include "tandem/pbd/joint.h"

namespace tandem::bench {
namespace {

pbd::SixDofJointDef definition(const pbd::World& world, const SceneJoint& joint, pbd::BodyId a,
                               pbd::BodyId b) {
  const Vec3 anchor_w = a.valid() ? world.pose(a).to_world(joint.anchor_a_l) : joint.anchor_a_l;
  if (joint.kind == JointKind::Hinge) {
    auto hinge = pbd::hinge_joint_at(world, a, b, anchor_w, joint.axis_w);
    if (joint.limited) {
      hinge.axis.freedom = pbd::Freedom::Limited;
      hinge.axis.lower = joint.lower;
      hinge.axis.upper = joint.upper;
    }
    if (joint.driven) {
      hinge.axis.motor = {
          .mode = pbd::MotorMode::Velocity, .target = joint.speed, .max_force = joint.max_torque};
    }
    hinge.axis.friction = joint.friction;
    hinge.collide_connected = joint.touch;
    return hinge;
  }
  if (joint.kind == JointKind::Slider) {
    return pbd::slider_joint_at(world, a, b, anchor_w, joint.axis_w);
  }
  pbd::BallJointDef ball{.a = a, .b = b};
  if (joint.limited || std::isfinite(joint.cone) || joint.friction > 0.0) {
    ball = pbd::ball_joint_at(world, a, b, anchor_w, joint.axis_w);
    ball.cone = joint.cone;
    ball.limit_twist = joint.limited;
    ball.lower_twist = joint.lower;
    ball.upper_twist = joint.upper;
  }
  ball.frame_a.anchor = joint.anchor_a_l;
  ball.frame_b.anchor = joint.anchor_b_l;
  ball.drive.friction = joint.friction;
  ball.collide_connected = joint.touch;
  ball.compliance = joint.compliance;
  ball.damping = joint.damping;
  return ball;
}

}  // namespace

void add_joints(pbd::World& world, const Scene& scene, std::span<const pbd::BodyId> ids) {
  const auto id = [&](int body) {
    return body < 0 ? pbd::BodyId{} : ids[static_cast<std::size_t>(body)];
  };
  pbd::JointBlock* joints = nullptr;
  pbd::DistanceJoints* rods = nullptr;
  for (const SceneJoint& joint : scene.joints) {
    if (joint.kind == JointKind::Distance) {
      if (rods == nullptr) rods = &world.add_block<pbd::DistanceJoints>();
      rods->add(world, {.a = id(joint.a),
                        .b = id(joint.b),
                        .anchor_a_l = joint.anchor_a_l,
                        .anchor_b_l = joint.anchor_b_l,
                        .rest_length = joint.rest_length,
                        .compliance = joint.compliance,
                        .damping = joint.damping});
      continue;
    }
    if (joints == nullptr) joints = &world.add_block<pbd::JointBlock>();
    joints->add(world, definition(world, joint, id(joint.a), id(joint.b)));
  }
}

}  // namespace tandem::bench
