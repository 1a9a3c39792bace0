// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <memory>

#include "tandem/pbd/export.h"
#include "tandem/scene.h"

namespace tandem {

struct TANDEM_API CharacterDef {
  Capsule shape{.radius = 0.3, .half_height = 0.6};
  Vec3 position = Vec3(0.0, 0.0, 1.0);  ///< m, world, centre of the capsule
  double mass = 70.0;                   ///< kg, > 0: for its weight and for impacts
  double max_push = 400.0;              ///< N, >= 0, on bodies in its way
  double max_slope = 0.87;              ///< rad, 0 to 1.5: it slides down steeper ground
  double max_step = 0.35;               ///< m, >= 0, up and down without leaving the ground
  double air_acceleration = 10.0;       ///< m/s^2, >= 0, of control in the air
  double padding = 0.02;                ///< m, > 0, below the radius: gap kept to everything
  collision::Filter filter = {};
  std::uint64_t user_data = 0;  ///< of its body and its collider
};

enum class Footing : std::uint8_t {
  Ground,  ///< stands or walks
  Steep,   ///< slides down ground steeper than max_slope
  Air,
};

/// A capsule that walks, climbs steps and slopes, jumps, is carried by its ground, pushes and is
/// pushed:
///
///     Character hero(scene, {.position = {0.0, 0.0, 1.0}});
///     hero.walk(stick * 4.0, dt);  // before each step
///     scene.step(dt);
///
/// Its path is found by casts of the capsule, not by forces, like Jolt's CharacterVirtual and
/// Rapier's controller. In the world it is an upright kinematic body. walk() moves that body and
/// exchanges impulses with dynamic bodies that it is about to touch:
/// - a body that runs into it shares its momentum with the character's mass, without bounce;
/// - a body that it runs into gets as much, but at most max_push per step;
/// - its ground carries its weight.
/// Bodies and character together gain energy only by max_push and jumps.
///
/// Up is opposite to gravity. To share it, share body() with this peer as its owner; the other
/// peers have a kinematic capsule of that name (see consensus::Peer::share).
/// Errors: std::invalid_argument naming field, value and rule.
/// @par Thread safety  As its scene.
class TANDEM_API Character {
 public:
  /// Adds its body to the scene, which must outlive the character and stay in place. After
  /// Scene::remove() of the body the character is invalid.
  Character(Scene& scene, const CharacterDef& def);
  ~Character();
  Character(Character&&) noexcept;
  Character& operator=(Character&&) noexcept;

  /// Call before each step, after its ground has got its target; without a call it keeps its
  /// velocity. Allocates nothing once sizes are known.
  /// @param velocity  m/s, wanted, relative to the ground; its part along up is ignored. On slopes
  ///   it is the horizontal velocity.
  /// @param dt  s, > 0, of that step
  void walk(const Vec3& velocity, double dt);
  /// Makes the next walk() leave the ground, if it stands on some. @param speed  m/s, >= 0
  void jump(double speed);

  BodyId body() const;
  Footing footing() const;     ///< after the last walk()
  BodyId ground() const;       ///< body that it stands on or slides down; the invalid id in the air
  Vec3 ground_normal() const;  ///< unit, world; up in the air
  Vec3 velocity() const;       ///< m/s, world, including that of its ground

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tandem
