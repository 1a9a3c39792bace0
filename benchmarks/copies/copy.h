// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <memory>
#include <vector>

#include "tandem/collision/contact_source.h"
#include "tandem/pbd/joint.h"
#include "tandem/pbd/world.h"

/// What benchmarks of peers without a demo have in common.
namespace tandem::peers_bench {

/// A box, shared or fixed; what is fixed has no body of `Copy::bodies`.
struct BoxBody {
  pbd::BodyId body;
  pbd::Vec3 half;  ///< m
};

/// One peer's world and what is in it. Everything that moves is shared.
struct Copy {
  std::unique_ptr<pbd::World> world;
  std::unique_ptr<collision::CollisionScene> contacts;
  std::vector<pbd::BodyId> bodies;  ///< what moves, in the order in which it was made
  std::vector<BoxBody> boxes;       ///< what moves and may touch
  std::vector<BoxBody> walls;
  pbd::JointBlock* joints = nullptr;  ///< null where there are none
  std::vector<pbd::JointId> joint_ids;
};

/// Fills a Copy. Bodies never sleep: what sleeps says nothing of stability.
class CopyBuilder {
 public:
  CopyBuilder();

  struct BoxDef {
    pbd::Pose pose;
    pbd::Vec3 half = pbd::Vec3::Constant(0.25);  ///< m
    double mass = 1.0;                           ///< kg, of a solid box
    bool collides = true;
    pbd::Twist twist = {};
  };
  pbd::BodyId box(const BoxDef& def);
  /// A fixed box.
  void wall(const pbd::Vec3& centre, const pbd::Vec3& half);
  /// A fixed body without a shape.
  pbd::BodyId hook();
  void joint(const pbd::SixDofJointDef& def);
  pbd::World& world() { return *copy_.world; }
  Copy done();

 private:
  Copy copy_;
};

}  // namespace tandem::peers_bench
