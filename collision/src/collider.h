// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "convex_core.h"
#include "tandem/collision/contact_source.h"
#include "tandem/pbd/world.h"

namespace tandem::collision {

/// Kinds in the order in which a query takes them.
enum class Kind : std::uint8_t {
  Sphere,
  Capsule,
  Box,
  Cylinder,
  Cone,
  Polytope,
  Triangles,
  Grid,
  HalfSpace,
};

/// Motion of a collider in a step.
struct ColliderMotion {
  double turn = 0.0;    ///< rad, rotation within the step
  double travel = 0.0;  ///< m, largest motion of any point within the step
  pbd::Twist twist;     ///< of the body
  double span = 0.0;    ///< s, the step used for these
};

/// Allocated on demand: a level has a million colliders that never move.
class OwnMotion {
 public:
  OwnMotion() = default;
  OwnMotion(const OwnMotion& other) { *this = other; }
  OwnMotion(OwnMotion&&) noexcept = default;
  ~OwnMotion() = default;
  OwnMotion& operator=(const OwnMotion& other) {
    if (other.own_ == nullptr) {
      own_.reset();
    } else {
      made() = *other.own_;
    }
    return *this;
  }
  OwnMotion& operator=(OwnMotion&&) noexcept = default;

  /// Null if it has never moved.
  const ColliderMotion* get() const { return own_.get(); }
  ColliderMotion& made() {
    if (own_ == nullptr) own_ = std::make_unique<ColliderMotion>();
    return *own_;
  }

 private:
  std::unique_ptr<ColliderMotion> own_;
};

/// A collider and data derived from it once and per step. The data that the loop over pairs reads
/// comes first: there are many more pairs than fit into the nearest cache.
struct Collider {
  Aabb needed;  ///< bounds, plus all that contacts may need in this step
  Kind kind = Kind::Sphere;
  bool alive = false;
  bool finite = true;  ///< pose and twist are finite
  bool dynamic = false;
  bool active() const { return dynamic && !def.passive; }  ///< meets inactive ones, too
  bool still = false;           ///< at rest, and in the place of the last step
  bool asleep = false;          ///< its body is not solved
  bool local_identity = false;  ///< the shape's frame is the body's
  /// Steps for which every motion is checked by CCD, not only a fast one. Set near thin walls,
  /// where a push out of the wall may go to the wrong side.
  std::uint8_t guarded = 0;
  std::uint32_t generation = 0;
  /// Places in order; see put_in_order().
  struct Ranks {
    std::uint32_t own = 0;   ///< among all colliders
    std::uint32_t body = 0;  ///< of its body
  };
  Ranks rank;

  // Set once.
  double size = 0.0;   ///< m, least extent; huge for half-spaces and meshes
  double reach = 0.0;  ///< m, farthest point from the body's origin; huge for half-spaces
  /// See CollisionOptions.
  struct Margins {
    double speculative = 0.0;  ///< m
    double recycle = 0.0;      ///< m
  };
  Margins margins;
  // Updated in each step.
  OwnMotion own_motion;  ///< none for static bodies
  ColliderMotion motion() const {
    return own_motion.get() != nullptr ? *own_motion.get() : ColliderMotion{};
  }
  Vec3 position = Vec3::Zero();  ///< m, of the shape
  /// Pose of the body; at first invalid.
  pbd::Pose body{Vec3::Zero(), pbd::Quat(0.0, 0.0, 0.0, 0.0)};
  Mat3 rotation = Mat3::Identity();  ///< of the shape, to world

  std::uint64_t added = 0;  ///< number of colliders added before it
  ColliderDef def;

  bool is_half_space() const { return kind == Kind::HalfSpace; }
  bool is_mesh() const { return kind == Kind::Triangles; }
  /// A mesh or a height field: triangles that touch with their fronts.
  bool is_surface() const { return kind == Kind::Triangles || kind == Kind::Grid; }
  bool is_convex() const { return kind < Kind::Triangles; }

  /// m, largest motion of any point within dt.
  double travel_within(double dt) const;
  /// Shape frame to body frame. Rarely needed, so not stored.
  Mat3 local_rotation() const { return def.local.orientation.toRotationMatrix(); }
  Vec3 plane_normal() const { return rotation * std::get<HalfSpace>(def.shape).normal; }
  double plane_offset() const {
    return std::get<HalfSpace>(def.shape).offset + plane_normal().dot(position);
  }
  /// World to body frame, for a point relative to the shape's position and for a direction.
  Vec3 to_body(const Vec3& from_shape) const {
    const Vec3 p = rotation.transpose() * from_shape;
    return local_identity ? p : Vec3(local_rotation() * p + def.local.position);
  }
  Vec3 direction_to_body(const Vec3& n) const {
    const Vec3 p = rotation.transpose() * n;
    return local_identity ? p : Vec3(local_rotation() * p);
  }
  /// Convex shapes only; positions relative to `origin`, to keep precision far from the world's
  /// origin.
  ConvexCore core(const Vec3& origin) const;
};

/// @pre def and options are valid
Collider make_collider(const ColliderDef& def, const CollisionOptions& options);

/// Sets the ranks of colliders: by pbd::BodyOrder, colliders of one body as they were added; by
/// index if bodies have no order of their own.
void put_in_order(std::span<Collider> colliders, const pbd::BodyOrder& order);

/// Whether the collider's body is static.
bool is_static(const Collider& collider, const pbd::World& world);

/// Reads the body's state and updates the data that depends on it.
void update_collider(Collider& collider, const pbd::World& world, double dt);

}  // namespace tandem::collision
