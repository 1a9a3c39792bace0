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
  Vec3 from = Vec3::Zero();           ///< m, world
  Vec3 to = Vec3::UnitX();            ///< m, world
  std::optional<double> length = {};  ///< m, at least the distance, which it is where not given: a
                                      ///< longer one starts as two straight halves that hang
  int particles = 20;                 ///< at least 2, the ends included; an odd number if it hangs
  double mass = 0.5;                  ///< kg, > 0, of all of it
  double radius = 0.01;               ///< m, > 0: it touches others as balls of this size
  double compliance = 0.0;            ///< 1/N, >= 0: strain for each newton
  double bending = 0.0;               ///< N m^2, >= 0: moment for each curvature
  double damping = 0.1;               ///< 1/s, >= 0, by the air
  collision::Material material = {};
  collision::Filter filter = {};  ///< a group of its own where that is 0: it does not touch itself
};

/// A rope of point masses, each a body of the world:
///
///     Rope rope(scene, {.from = hook, .to = crate_top, .mass = 2.0});
///     rope.attach(0, ceiling);
///     rope.attach(rope.particles().size() - 1, crate);
///     scene.step(dt);
///
/// It is one strand (pbd::StrandDef), which is solved as a whole with what hangs on it: a light
/// rope holds a heavy crate. Between its particles it touches nothing: they should not lie further
/// apart than what it is to hang over is thick. Errors: std::invalid_argument naming field, value
/// and rule; the scene is then as it was.
/// @par Thread safety  As its scene.
class TANDEM_API Rope {
 public:
  /// Adds bodies and rows, which outlive it.
  Rope(Scene& scene, const RopeDef& def);

  /// From one end to the other; half a particle's mass at the ends.
  const std::vector<BodyId>& particles() const { return particles_; }
  /// Hold a particle where it now is on a body, until ClothBlock::remove(). It touches nothing from
  /// then on: it lies in what it is attached to.
  pbd::ClothRowId attach(std::size_t particle, BodyId host);

 private:
  pbd::World* world_;
  collision::CollisionScene* shapes_;
  std::vector<BodyId> particles_;
};

}  // namespace tandem
