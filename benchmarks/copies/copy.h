// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <memory>
#include <vector>

#include "tandem/collision/contact_source.h"
#include "tandem/pbd/joint.h"
#include "tandem/pbd/world.h"

/// Worlds for benchmarks of peers without a demo.
namespace tandem::peers_bench {

/// A box, shared or fixed; fixed ones are not in `Copy::bodies`.
struct BoxBody {
  pbd::BodyId body;
  pbd::Vec3 half;  ///< m
};

/// One peer's world and its contents. Everything that moves is shared.
struct Copy {
  std::unique_ptr<pbd::World> world;
  std::unique_ptr<collision::CollisionScene> contacts;
  std::vector<pbd::BodyId> bodies;  ///< moving ones, in order of creation
  std::vector<BoxBody> boxes;       ///< moving ones with contacts
  std::vector<BoxBody> walls;
  pbd::JointBlock* joints = nullptr;  ///< null if there are none
  std::vector<pbd::JointId> joint_ids;
};

/// Fills a Copy. Bodies never sleep: sleep would hide instability.
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
