// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <optional>
#include <vector>

#include "tandem/pbd/cloth_block.h"
#include "tandem/pbd/export.h"
#include "tandem/scene.h"

namespace tandem {

struct TANDEM_API RopeDef {
  Vec3 from = Vec3::Zero();  ///< m, world
  Vec3 to = Vec3::UnitX();   ///< m, world
  /// m, at least the distance, which is the default. A longer rope starts as two straight halves
  /// that hang.
  std::optional<double> length = {};
  int particles = 20;       ///< at least 2, the ends included; an odd number if it hangs
  double mass = 0.5;        ///< kg, > 0, in total
  double radius = 0.01;     ///< m, > 0: contact radius of particles
  double compliance = 0.0;  ///< 1/N, >= 0: strain per newton
  double bending = 0.0;     ///< N m^2, >= 0: moment per curvature
  double damping = 0.1;     ///< 1/s, >= 0, air drag
  collision::Material material = {};
  collision::Filter filter = {};  ///< group 0: a new group, so that it does not touch itself
};

/// A rope of point masses, each a body of the world:
///
///     Rope rope(scene, {.from = hook, .to = crate_top, .mass = 2.0});
///     rope.attach(0, ceiling);
///     rope.attach(rope.particles().size() - 1, crate);
///     scene.step(dt);
///
/// It is one strand (pbd::StrandDef), solved as a whole with its load: a light rope holds a heavy
/// crate. There are no contacts between its particles: their distance should not exceed the
/// thickness of bodies that it must hang over. Errors: std::invalid_argument naming field, value
/// and rule; the scene is then unchanged.
/// @par Thread safety  As its scene.
class TANDEM_API Rope {
 public:
  /// Adds bodies and rows, which outlive it.
  Rope(Scene& scene, const RopeDef& def);

  /// From one end to the other; the ends have half a particle's mass.
  const std::vector<BodyId>& particles() const { return particles_; }
  /// Attaches a particle to a body at its current place, until ClothBlock::remove(). It touches
  /// nothing from then on, as it is inside its host.
  pbd::ClothRowId attach(std::size_t particle, BodyId host);

 private:
  pbd::World* world_;
  collision::CollisionScene* shapes_;
  std::vector<BodyId> particles_;
};

}  // namespace tandem
