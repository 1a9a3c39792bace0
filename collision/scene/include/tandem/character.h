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
  Vec3 position = Vec3(0.0, 0.0, 1.0);  ///< m, world, of the capsule's middle
  double mass = 70.0;                   ///< kg, > 0: its weight, and what it carries into a blow
  double max_push = 400.0;              ///< N, >= 0, against what stands in its way
  double max_slope = 0.87;              ///< rad, 0 to 1.5: steeper ground is slid down
  double max_step = 0.35;               ///< m, >= 0, up and down without leaving the ground
  double air_acceleration = 10.0;       ///< m/s^2, >= 0, that the user has in the air
  double padding = 0.02;  ///< m, > 0, below the radius: gap that it keeps to everything
  collision::Filter filter = {};
  std::uint64_t user_data = 0;  ///< of its body and its collider
};

enum class Footing : std::uint8_t {
  Ground,  ///< stands, or walks
  Steep,   ///< slides down something steeper than max_slope
  Air,
};

/// A capsule that walks, climbs steps and slopes, jumps, is carried by what it stands on, pushes
/// and is pushed:
///
///     Character hero(scene, {.position = {0.0, 0.0, 1.0}});
///     hero.walk(stick * 4.0, dt);  // before each step
///     scene.step(dt);
///
/// Its way is found by casts of the capsule, not by forces, as Jolt's CharacterVirtual and Rapier's
/// controller do it. What it has in the world is an upright kinematic body, which everything else
/// meets as such; walk() moves that and exchanges impulses with dynamic bodies that it is about to
/// touch:
/// - what runs into it shares its momentum with the character's mass, without bounce;
/// - what it runs into gets as much, but no more than max_push in each step;
/// - what it stands on bears its weight.
/// So bodies and character together never gain energy but by what max_push and jumps do.
///
/// Up is against gravity. To share it, share body() with this peer as its owner; the others have a
/// kinematic capsule by that name (see consensus::Peer::share).
/// Errors: std::invalid_argument naming field, value and rule.
/// @par Thread safety  As its scene.
class TANDEM_API Character {
 public:
  /// Adds its body to the scene, which outlives it and stays where it is. Scene::remove() takes the
  /// body away; the character is then dead.
  Character(Scene& scene, const CharacterDef& def);
  ~Character();
  Character(Character&&) noexcept;
  Character& operator=(Character&&) noexcept;

  /// Before each step, and after what carries it has its target; else it goes on as it went.
  /// Allocates nothing once sizes are known.
  /// @param velocity  m/s, wanted, relative to the ground; what is along up does not count. It is
  ///   the horizontal velocity on slopes as well.
  /// @param dt  s, > 0, of that step
  void walk(const Vec3& velocity, double dt);
  /// The next walk() leaves the ground, where it stands on some. @param speed  m/s, >= 0
  void jump(double speed);

  BodyId body() const;
  Footing footing() const;     ///< after the last walk()
  BodyId ground() const;       ///< what it stands on or slides down; the invalid id in the air
  Vec3 ground_normal() const;  ///< unit, world; up in the air
  Vec3 velocity() const;       ///< m/s, world, what carries it included

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tandem
