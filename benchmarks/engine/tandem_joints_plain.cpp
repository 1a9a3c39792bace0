// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Ball and distance joints only.
#include <stdexcept>

#include "engine/tandem_joints.h"
#include "tandem/pbd/ball_joint.h"
#include "tandem/pbd/distance_joint.h"

namespace tandem::bench {

void add_joints(pbd::World& world, const Scene& scene, std::span<const pbd::BodyId> ids) {
  const auto id = [&](int body) {
    return body < 0 ? pbd::BodyId{} : ids[static_cast<std::size_t>(body)];
  };
  pbd::BallJoints* balls = nullptr;
  pbd::DistanceJoints* rods = nullptr;
  for (const SceneJoint& joint : scene.joints) {
    if (joint.kind == JointKind::Ball) {
      if (balls == nullptr) balls = &world.add_block<pbd::BallJoints>();
      balls->add(world, {.a = id(joint.a),
                         .b = id(joint.b),
                         .anchor_a_l = joint.anchor_a_l,
                         .anchor_b_l = joint.anchor_b_l,
                         .compliance = joint.compliance,
                         .damping = joint.damping});
    } else if (joint.kind == JointKind::Distance) {
      if (rods == nullptr) rods = &world.add_block<pbd::DistanceJoints>();
      rods->add(world, {.a = id(joint.a),
                        .b = id(joint.b),
                        .anchor_a_l = joint.anchor_a_l,
                        .anchor_b_l = joint.anchor_b_l,
                        .rest_length = joint.rest_length,
                        .compliance = joint.compliance,
                        .damping = joint.damping});
    } else {
      throw std::invalid_argument("tandem: no hinge and no slider in this build");
    }
  }
}

}  // namespace tandem::bench
