// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "tandem/collision/material.h"
#include "tandem/collision/shape.h"
#include "tandem/pbd/constraint.h"
#include "tandem/pbd/export.h"
#include "tandem/pbd/manifold.h"

namespace tandem::collision {

/// Names one collider of one scene; stale ids are errors.
struct TANDEM_API ColliderId {
  static constexpr std::uint32_t kNone = 0xffffffffu;
  std::uint32_t index = kNone;
  std::uint32_t generation = 0;

  bool valid() const { return index != kNone; }
  friend auto operator<=>(const ColliderId&, const ColliderId&) = default;
};

/// A shape on a body. A body may have any number of colliders; they do not touch each other.
/// Contacts are taken in the order of bodies (pbd::BodyOrder), then in the order in which a body
/// got its colliders. If motion must not depend on how a scene was built, add the colliders of each
/// body in a fixed order.
struct TANDEM_API ColliderDef {
  pbd::BodyId body = {};
  Shape shape = {};
  pbd::Pose local = {};  ///< pose of the shape in the body's frame
  Material material = {};
  Filter filter = {};
  /// Makes no contacts: ContactEvents reports colliders that pass through it.
  bool sensor = false;
  /// Meets only colliders of dynamic bodies that are not passive. For copies of bodies whose other
  /// contacts are found by the owner of the body.
  bool passive = false;
  std::uint64_t user_data = 0;  ///< a number for the application; Tandem does not read it
};

/// How contacts are found. The defaults suit bodies from centimetres to tens of metres.
struct TANDEM_API CollisionOptions {
  /// m: gaps below this, plus what the motion of the step may close, are reported. Capped at a
  /// quarter of the smaller shape's least extent.
  double speculative_margin = 0.02;
  /// m: a pair keeps its contacts (normal and anchors; only gaps are updated) until its parts have
  /// moved against each other by this much; capped at a fiftieth of the least extent. The normal
  /// turns with the body that owns the reference face, else with the body that does not move, else
  /// with the second one. 0 switches recycling off.
  double recycle_distance = 0.005;
  double recycle_angle = 0.035;  ///< rad, 0 to 0.2

  /// Whether all fields are valid; if not, `error` names field, value and rule.
  bool validate(std::string* error = nullptr) const;
};

/// Statistics of the last collect().
struct TANDEM_API CollisionStats {
  std::size_t colliders = 0;
  std::size_t looked_at = 0;  ///< colliders visited: resting ones on static bodies are skipped
  std::size_t searches = 0;   ///< lookups of a box in the tree
  std::size_t pairs = 0;      ///< pairs of overlapping fat boxes
  std::size_t queries = 0;    ///< narrow-phase queries, one per candidate triangle
  std::size_t recycled = 0;   ///< pairs whose contacts were kept, without a query
  std::size_t manifolds = 0;
  std::size_t points = 0;
};

/// Finds the contacts between the shapes of a world's bodies.
///
/// Broad phase: a tree of fat boxes, updated only for colliders that left theirs. Narrow phase: one
/// query of the collision library per new contact gives direction and depth; the manifold is then
/// clipped from the features that face each other. Pairs that hardly moved are not queried again.
/// Manifolds are ordered by key: (lower collider, higher collider, cluster of a mesh); body_a is
/// the lower collider's body. Mesh pairs and half-space pairs do not touch.
///
/// Limits: 2^26 colliders. Results do not depend on addresses, so equal scenes give equal bytes.
/// @par Thread safety  Distinct scenes: safe. One scene: one thread at a time.
class TANDEM_API CollisionScene : public pbd::ContactSource {
 public:
  /// @throws std::invalid_argument if the options are not valid
  explicit CollisionScene(const CollisionOptions& options = {});
  ~CollisionScene() override;
  CollisionScene(CollisionScene&&) noexcept;
  CollisionScene& operator=(CollisionScene&&) noexcept;

  /// Reserves memory for so many colliders in all, before a large scene is built.
  void reserve(std::size_t colliders);
  /// @throws std::invalid_argument  naming field, value and rule; the scene is then unchanged
  ColliderId add(const pbd::World& world, const ColliderDef& def);
  /// @throws std::invalid_argument if the id names no collider
  void remove(ColliderId id);
  /// Takes effect in the next step.
  /// @throws std::invalid_argument if the id names no collider or a value is not valid
  void set_material(ColliderId id, const Material& material);
  void set_filter(ColliderId id, const Filter& filter);
  void set_user_data(ColliderId id, std::uint64_t value);
  /// Disables or enables contacts between two bodies from the next step on, whatever their filters
  /// are; sensors and queries are not affected. For jointed bodies use
  /// pbd::SixDofJointDef::collide_connected. Saved in snapshots and copies, until one of the bodies
  /// is removed.
  /// @throws std::invalid_argument if one is no body of the world, or both are the same
  void set_apart(const pbd::World& world, pbd::BodyId a, pbd::BodyId b, bool apart = true);
  /// Whether set_apart() disabled contacts between the two bodies.
  bool is_apart(pbd::BodyId a, pbd::BodyId b) const;
  /// All pairs set apart, by slot, ascending.
  std::vector<pbd::BodyPair> apart() const;
  bool contains(ColliderId id) const;
  /// The reference is valid until the next add(), remove(), load() or assign().
  /// @throws std::invalid_argument if the id names no collider
  const ColliderDef& collider(ColliderId id) const;
  /// The collider in slot `index`, or an invalid id; indices are below slot_count().
  ColliderId collider_at(std::uint32_t index) const;
  std::uint32_t slot_count() const;
  std::size_t sensor_count() const;
  /// A new Filter::group < 0, whose colliders do not meet each other: used by no collider and not
  /// returned before. Looks at all colliders. Groups given out by a copy are not known here.
  /// @throws std::invalid_argument if all groups are given out or in use
  std::int32_t new_group();
  /// Changes whenever a collider may have been added, removed or filtered differently.
  std::uint64_t changes() const;

  const CollisionOptions& options() const;
  /// Statistics of the last collect().
  const CollisionStats& stats() const;

  void collect(const pbd::World& world, double dt, pbd::Workers& workers,
               std::vector<pbd::Manifold>& out) override;
  /// False in derived classes.
  bool repeats() const override;
  /// The final CCD clamp: stops bodies that would tunnel, whatever the contacts did. If the middle
  /// of a collider moved further than a quarter of its least extent, its core (the shape without a
  /// layer of that thickness) is swept along its path, rotation included, and stopped by immovable
  /// colliders. If far points turned further than its thickness, or its body is a bullet, moving
  /// colliders stop it too. The body stays where the surfaces meet, for the contact of the next
  /// step. Instead of the core, a ball in the middle is cast for spheres, slow bodies near thin
  /// walls, bodies that rows join to other movable ones, and against meshes, height fields and
  /// half-spaces. Paths start at the poses of the last collect().
  /// @param after   poses at the end of the step, by body slot; not read for static bodies
  /// @param limits  set to the bodies that must stop on the way, ascending, each once
  /// Allocates only if `limits` or scratch grow.
  void limit_motion(const pbd::World& world, std::span<const pbd::Pose> after,
                    pbd::Workers& workers, std::vector<pbd::MotionLimit>& limits) override;

  /// Removes the body's colliders.
  void remove_body(pbd::BodyId body) override;
  void save(pbd::ByteWriter& out) const override;
  /// Needs a scene with the same colliders; otherwise `in` fails and the caches are empty.
  void load(pbd::ByteReader& in) override;
  bool fits(const pbd::World& world) const override;
  /// Null in derived classes, which must define themselves how they are copied.
  std::unique_ptr<pbd::ContactSource> make_empty() const override;
  /// Meshes, hulls and height fields are shared.
  bool assign(const pbd::ContactSource& source) override;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tandem::collision
