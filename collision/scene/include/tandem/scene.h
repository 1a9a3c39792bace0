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

// Names that most programs need.
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

/// A body with one or several shapes.
struct TANDEM_API SolidDef {
  BodyType type = BodyType::Dynamic;
  double density = 1000.0;  ///< kg/m^3, > 0; parts of a compound have their own
  /// kg, > 0, overrides the density; neither is read unless dynamic.
  std::optional<double> mass = {};
  Pose pose = {};                     ///< of the shape's frame, see Scene::pose()
  pbd::Twist twist = {};              ///< of the centre of mass
  collision::Material material = {};  ///< surface properties
  collision::Filter filter = {};  ///< which colliders it meets; collision::Layers names categories
  bool sensor = false;            ///< has no contacts, and reports the colliders inside it
  double gravity_scale = 1.0;
  double linear_damping = 0.0;   ///< 1/s, >= 0
  double angular_damping = 0.0;  ///< 1/s, >= 0
  pbd::AxisLocks locks = {};
  bool bullet = false;  ///< CCD for small and fast bodies, see pbd::BodyDef
  bool can_sleep = true;
  std::optional<double> sleep_speed = {};       ///< m/s, see pbd::BodyDef
  std::optional<double> sleep_spin = {};        ///< rad/s, see pbd::BodyDef
  std::optional<std::uint64_t> stable_id = {};  ///< see pbd::BodyOrder
  std::uint64_t user_data = 0;  ///< a number for the application, of body and colliders
};

/// A world with its shapes and its solver:
///
///     Scene scene;
///     scene.add(HalfSpace{}, {.type = BodyType::Static});
///     const BodyId cube = scene.add(Box{0.1, 0.1, 0.1}, {.pose = {.position = {0.0, 0.0, 1.0}}});
///     while (running) scene.step(1.0 / 60.0);
///
/// It adds nothing to its parts, which may be used directly: the same calls on parts that were
/// assembled by hand give the same bits, except for steps below pbd::kShortestStep.
///
/// Errors: std::invalid_argument naming field, value and rule, from everything that adds or sets;
/// the scene is then unchanged. A moved-from scene may only be assigned to or destroyed; the
/// addresses of its parts stay the same.
/// @par Thread safety  Distinct scenes: safe. One scene: one thread at a time.
class TANDEM_API Scene {
 public:
  explicit Scene(const SceneOptions& options = {});
  ~Scene();
  Scene(Scene&&) noexcept;
  Scene& operator=(Scene&&) noexcept;

  BodyId add(const collision::Shape& shape, const SolidDef& def = {});
  BodyId add(std::span<const collision::CompoundPart> parts, const SolidDef& def = {});
  /// A collision::Filter::group that nobody else has or gets: its colliders do not meet each other.
  /// The first is the lowest number, and they ascend from there.
  /// @see collision::CollisionScene::new_group
  std::int32_t new_group();
  /// Disables or enables contacts between two bodies. @see collision::CollisionScene::set_apart
  void set_apart(BodyId a, BodyId b, bool apart = true) {
    shapes().set_apart(world(), a, b, apart);
  }
  /// Removes a body with its shapes and joints.
  void remove(BodyId body) { world().remove_body(body); }
  /// Adds a joint of any kind: scene.add_joint(pbd::hinge_joint_at(scene.world(), frame, door,
  /// point, axis)).
  pbd::JointId add_joint(const pbd::SixDofJointDef& def);

  /// Pose of the shape, as in SolidDef::pose. World::pose() is that of the centre of mass, which
  /// differs for cones, and for hulls, meshes and compounds that are not centred. The offset is
  /// BodyProps::origin, and so part of snapshots.
  Pose pose(BodyId body) const;
  void set_pose(BodyId body, const Pose& pose);
  /// Velocity of the centre of mass.
  const pbd::Twist& twist(BodyId body) const { return world().twist(body); }
  void set_twist(BodyId body, const pbd::Twist& twist) { world().set_twist(body, twist); }
  /// Changes a dynamic body's velocity at once. @param impulse  N s, world
  void apply_impulse(BodyId body, const Vec3& impulse) { world().apply_impulse(body, impulse); }
  /// @param at  m, world, point of application
  void apply_impulse(BodyId body, const Vec3& impulse, const Vec3& at) {
    world().apply_impulse(body, impulse, at);
  }

  /// Never throws; @see pbd::Solver::step. Steps shorter than pbd::kShortestStep are accumulated:
  /// nothing moves and the status is InvalidStep until their sum is long enough, or a longer step
  /// includes it. The sum is not part of snapshots. @param dt  s
  const pbd::StepReport& step(double dt) noexcept;

  /// Contacts that began, ended or hit in the last step. At the first call all touching pairs
  /// begin; without calls a scene does not look for events.
  const collision::ContactEvents& events();
  /// Rays, casts, overlaps and nearest points at the current poses. Updates all bodies if one was
  /// added, removed or moved since the last call.
  const collision::SceneQuery& query();

  // The parts. world().contact_source() stays shapes().
  pbd::World& world();
  const pbd::World& world() const;
  collision::CollisionScene& shapes();
  const collision::CollisionScene& shapes() const;
  const pbd::Solver& solver() const;
  /// Made on demand. A snapshot only fits worlds that have it too.
  pbd::JointBlock& joints();

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tandem
