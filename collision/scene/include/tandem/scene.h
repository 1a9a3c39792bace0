// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "tandem/collision/compound.h"
#include "tandem/collision/contact_events.h"
#include "tandem/collision/contact_source.h"
#include "tandem/collision/layers.h"
#include "tandem/collision/scene_query.h"
#include "tandem/pbd/export.h"
#include "tandem/pbd/joint.h"
#include "tandem/pbd/solver.h"
#include "tandem/pbd/world.h"

namespace tandem {

// What programs name all the time.
using collision::Box;
using collision::Capsule;
using collision::Cone;
using collision::Cylinder;
using collision::HalfSpace;
using collision::Sphere;
using pbd::BodyId;
using pbd::BodyType;
using pbd::Pose;
using pbd::Quat;
using pbd::Vec3;

struct TANDEM_API SceneOptions {
  Vec3 gravity = Vec3(0.0, 0.0, -9.81);  ///< m/s^2
  pbd::SolverOptions solver = {};
  collision::CollisionOptions collision = {};
  collision::ContactEventOptions events = {};
};

/// A body with a shape, or with several as one.
struct TANDEM_API SolidDef {
  BodyType type = BodyType::Dynamic;
  double density = 1000.0;  ///< kg/m^3, > 0; of parts, each has its own
  /// kg, > 0, whatever the density; neither is read unless dynamic.
  std::optional<double> mass = {};
  Pose pose = {};                     ///< of the shape's frame, see Scene::pose()
  pbd::Twist twist = {};              ///< of the centre of mass
  collision::Material material = {};  ///< of the surface
  collision::Filter filter = {};      ///< whom it meets; collision::Layers has names for that
  bool sensor = false;                ///< touches nothing and tells what is in it
  double gravity_scale = 1.0;
  double linear_damping = 0.0;   ///< 1/s, >= 0
  double angular_damping = 0.0;  ///< 1/s, >= 0
  pbd::AxisLocks locks = {};
  bool bullet = false;  ///< small and fast
  bool can_sleep = true;
  std::optional<double> sleep_speed = {};       ///< m/s, see pbd::BodyDef
  std::optional<double> sleep_spin = {};        ///< rad/s, likewise
  std::optional<std::uint64_t> stable_id = {};  ///< see pbd::BodyOrder
  std::uint64_t user_data = 0;                  ///< the application's own, of body and colliders
};

/// A world with its shapes and its solver:
///
///     Scene scene;
///     scene.add(HalfSpace{}, {.type = BodyType::Static});
///     const BodyId cube = scene.add(Box{0.1, 0.1, 0.1}, {.pose = {.position = {0.0, 0.0, 1.0}}});
///     while (running) scene.step(1.0 / 60.0);
///
/// It adds nothing to its parts, which may be used beside it: the same calls on parts that were put
/// together by hand give the same bits, but for steps below pbd::kShortestStep.
///
/// Errors: std::invalid_argument naming field, value and rule, from all that adds or sets; the
/// scene is then as it was. One that was moved from may be assigned to or destroyed; its parts stay
/// where they are.
/// @par Thread safety  Distinct scenes: safe. One scene: one thread at a time.
class TANDEM_API Scene {
 public:
  explicit Scene(const SceneOptions& options = {});
  ~Scene();
  Scene(Scene&&) noexcept;
  Scene& operator=(Scene&&) noexcept;

  BodyId add(const collision::Shape& shape, const SolidDef& def = {});
  BodyId add(std::span<const collision::CompoundPart> parts, const SolidDef& def = {});
  /// A collision::Filter::group that nobody else has or is given: those who get it do not meet each
  /// other. The first is the least number there is; they go up from there.
  /// @see collision::CollisionScene::new_group
  std::int32_t new_group();
  /// Two bodies pass through each other, or touch again. @see collision::CollisionScene::set_apart
  void set_apart(BodyId a, BodyId b, bool apart = true) {
    shapes().set_apart(world(), a, b, apart);
  }
  /// With its shapes and joints.
  void remove(BodyId body) { world().remove_body(body); }
  /// Of any kind: scene.add_joint(pbd::hinge_joint_at(scene.world(), frame, door, point, axis)).
  pbd::JointId add_joint(const pbd::SixDofJointDef& def);

  /// Where the shape is, as SolidDef::pose. World::pose() is that of the centre of mass: another
  /// place for cones, and for hulls, meshes and compounds about another point.
  /// It is BodyProps::origin, and so part of snapshots.
  Pose pose(BodyId body) const;
  void set_pose(BodyId body, const Pose& pose);
  /// Of the centre of mass.
  const pbd::Twist& twist(BodyId body) const { return world().twist(body); }
  void set_twist(BodyId body, const pbd::Twist& twist) { world().set_twist(body, twist); }
  /// Change a dynamic body's velocity at once. @param impulse  N s, world
  void apply_impulse(BodyId body, const Vec3& impulse) { world().apply_impulse(body, impulse); }
  /// @param at  m, world, where it is hit
  void apply_impulse(BodyId body, const Vec3& impulse, const Vec3& at) {
    world().apply_impulse(body, impulse, at);
  }

  /// Throws nothing; @see pbd::Solver::step. Steps shorter than pbd::kShortestStep are gathered:
  /// nothing moves and the status is InvalidStep until they are long enough together, or until a
  /// longer one takes them along. What is gathered is part of no snapshot. @param dt  s
  const pbd::StepReport& step(double dt) noexcept;

  /// What began, ended and hit in the last step. The first call has all that touches begin; a scene
  /// that is never asked does not look.
  const collision::ContactEvents& events();
  /// Rays, casts, overlaps and nearest points, with all bodies where they are now. It looks at them
  /// all where one has come, gone or been put elsewhere since it was asked for last.
  const collision::SceneQuery& query();

  // The parts. world().contact_source() stays shapes().
  pbd::World& world();
  const pbd::World& world() const;
  collision::CollisionScene& shapes();
  const collision::CollisionScene& shapes() const;
  const pbd::Solver& solver() const;
  /// Made when it is first asked for. A snapshot fits worlds that have it alike.
  pbd::JointBlock& joints();

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tandem
