// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "tandem/pbd/cloth_block.h"
#include "tandem/scene.h"

namespace tandem::detail {

/// Common properties of the particles of a cloth or rope.
struct ParticleKind {
  double radius = 0.0;   ///< m
  double damping = 0.0;  ///< 1/s
  collision::Material material;
  collision::Filter filter;
};

/// @throws std::invalid_argument naming field, value and rule
void check(const ParticleKind& kind, std::string_view name);
/// A point mass with a ball for contacts. @param position  m, world     @param mass  kg
pbd::BodyId add_particle(Scene& scene, const ParticleKind& kind, const pbd::Vec3& position,
                         double mass);
/// The world's block of cloth; added if there is none.
pbd::ClothBlock& cloth_of(pbd::World& world);
/// Attaches a particle to the host at its current place. It touches nothing from then on, as it is
/// inside its host.
pbd::ClothRowId attach(pbd::World& world, collision::CollisionScene& shapes, pbd::BodyId particle,
                       pbd::BodyId host);
/// Bending row of a point between two. @param stiffness  N/m, of C = x_a - 2 x_m + x_b
void add_bending(pbd::World& world, pbd::BodyId a, pbd::BodyId middle, pbd::BodyId b,
                 double stiffness);

}  // namespace tandem::detail
