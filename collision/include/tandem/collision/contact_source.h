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
/// got its colliders: where motion must not depend on how a scene was built, give each body its own
/// ones in a fixed order.
struct TANDEM_API ColliderDef {
  pbd::BodyId body = {};
  Shape shape = {};
  pbd::Pose local = {};  ///< of the shape in the body's frame
  Material material = {};
  Filter filter = {};
  /// Makes no contacts: ContactEvents reports what passes through it.
  bool sensor = false;
  /// Meets colliders of dynamic bodies that are not passive, and nothing else: of a copy of a body
  /// whose other contacts are found where the body itself is.
  bool passive = false;
  std::uint64_t user_data = 0;  ///< the application's own number: nothing here reads it
};

/// How contacts are found. The defaults suit bodies from centimetres to tens of metres.
struct TANDEM_API CollisionOptions {
  /// m: gaps below this (plus what the motion of the step may close) are reported. For small
  /// shapes it is capped at a quarter of the smaller one's least extent.
  double speculative_margin = 0.02;
  /// A pair keeps its contacts (normal and anchors; only gaps change) until its parts have moved
  /// against each other by this much, m; capped at a fiftieth of the least extent. The
  /// normal turns with the body that owns the reference face, else with the body that does not
  /// move, else with the second one. 0 switches recycling off.
  double recycle_distance = 0.005;
  double recycle_angle = 0.035;  ///< rad, 0 to 0.2

  /// Whether all fields are within their rules; if not, `error` names field, value and rule.
  bool validate(std::string* error = nullptr) const;
};

/// What the last collect() did.
struct TANDEM_API CollisionStats {
  std::size_t colliders = 0;
  std::size_t looked_at = 0;  ///< of those: what lies still on a static body is not
  std::size_t searches = 0;   ///< boxes that were looked up among the others
  std::size_t pairs = 0;      ///< whose fat boxes overlap
  std::size_t queries = 0;    ///< asked of the narrow phase (one for each candidate triangle)
  std::size_t recycled = 0;   ///< pairs that needed none
  std::size_t manifolds = 0;
  std::size_t points = 0;
};

/// Finds the contacts between the shapes of a world's bodies.
///
/// Broad phase: a tree of fat boxes, changed only for colliders that left theirs. Narrow phase:
/// one query of the collision library for each new contact gives direction and depth; the manifold
/// is then clipped from the features that face each other. Pairs that hardly moved are not asked
/// again. Manifolds come ordered by key: (lower collider, higher collider, cluster of a mesh);
/// body_a is the lower collider's body. Two meshes, and two half-spaces, do not touch each other.
///
/// Limits: 2^26 colliders. Not moved by collect(): nothing here depends on addresses, so equal
/// scenes give equal bytes.
/// @par Thread safety  Distinct scenes: safe. One scene: one thread at a time.
class TANDEM_API CollisionScene : public pbd::ContactSource {
 public:
  /// @throws std::invalid_argument where the options do not validate
  explicit CollisionScene(const CollisionOptions& options = {});
  ~CollisionScene() override;
  CollisionScene(CollisionScene&&) noexcept;
  CollisionScene& operator=(CollisionScene&&) noexcept;

  /// Make room for so many colliders in all, before a large scene is built.
  void reserve(std::size_t colliders);
  /// @throws std::invalid_argument  naming field, value and rule; the scene is then unchanged
  ColliderId add(const pbd::World& world, const ColliderDef& def);
  /// @throws std::invalid_argument where the id names no collider
  void remove(ColliderId id);
  /// From the next step on.
  /// @throws std::invalid_argument where the id names no collider or a value is not what it must be
  void set_material(ColliderId id, const Material& material);
  void set_filter(ColliderId id, const Filter& filter);
  void set_user_data(ColliderId id, std::uint64_t value);
  /// Two bodies touch each other no more, or again, from the next step on, whatever their filters
  /// say; sensors and queries see both. Joints keep bodies apart by
  /// pbd::SixDofJointDef::collide_connected. Part of snapshots and copies, until one of the two is
  /// removed.
  /// @throws std::invalid_argument where one is no body of the world, or both are the same
  void set_apart(const pbd::World& world, pbd::BodyId a, pbd::BodyId b, bool apart = true);
  /// Whether set_apart() said so.
  bool is_apart(pbd::BodyId a, pbd::BodyId b) const;
  /// All of them by slot, ascending.
  std::vector<pbd::BodyPair> apart() const;
  bool contains(ColliderId id) const;
  /// The reference is good until the next add(), remove(), load() or assign().
  /// @throws std::invalid_argument where the id names no collider
  const ColliderDef& collider(ColliderId id) const;
  /// The collider in slot `index`, or an invalid id; indices are below slot_count().
  ColliderId collider_at(std::uint32_t index) const;
  std::uint32_t slot_count() const;
  std::size_t sensor_count() const;
  /// A Filter::group, below 0, that no collider has and that was not given before: those who get it
  /// do not meet each other. Looks at all colliders. What is given to a copy is not known here.
  /// @throws std::invalid_argument once all of them are given, or in use
  std::int32_t new_group();
  /// Another number than before where a collider may have come or gone, or meets others.
  std::uint64_t changes() const;

  const CollisionOptions& options() const;
  /// Of the last collect().
  const CollisionStats& stats() const;

  void collect(const pbd::World& world, double dt, pbd::Workers& workers,
               std::vector<pbd::Manifold>& out) override;
  /// Not for a class that is derived from this one.
  bool repeats() const override;
  /// The last word against tunnelling: bodies that would get through something, whatever the
  /// contacts did. Of each collider whose middle moved further than a quarter of its least extent
  /// the inside, what is left without a layer as thick as that, is swept along its way, turning
  /// included; immovable colliders stop it. Where far points moved further by turning than it is
  /// thick, or its body is a bullet, moving ones stop it as well. It is left where the surfaces
  /// meet, and the contact of the next step does the rest. Spheres, slow bodies near thin walls,
  /// bodies that rows hold to other movable ones, and all that meets a mesh, height field or
  /// half-space have the ball in their middle cast instead. Where the step began is where the last
  /// collect() saw the bodies.
  /// @param after   poses at the end of the step, by body slot; those of static bodies are not read
  /// @param limits  set to the bodies that have to stop on the way, ascending, each once
  /// Allocates only where `limits` or scratch grow.
  void limit_motion(const pbd::World& world, std::span<const pbd::Pose> after,
                    pbd::Workers& workers, std::vector<pbd::MotionLimit>& limits) override;

  /// Removes the body's colliders.
  void remove_body(pbd::BodyId body) override;
  void save(pbd::ByteWriter& out) const override;
  /// Wants a scene with the same colliders; other bytes leave `in` failed and the caches empty.
  void load(pbd::ByteReader& in) override;
  bool fits(const pbd::World& world) const override;
  /// Null for a class that is derived from this one: it has to say itself how it is copied.
  std::unique_ptr<pbd::ContactSource> make_empty() const override;
  /// Meshes, hulls and height fields are shared.
  bool assign(const pbd::ContactSource& source) override;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tandem::collision
