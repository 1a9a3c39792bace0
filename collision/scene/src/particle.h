// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "tandem/pbd/cloth_block.h"
#include "tandem/scene.h"

namespace tandem::detail {

/// What the particles of one cloth or rope have in common.
struct ParticleKind {
  double radius = 0.0;   ///< m
  double damping = 0.0;  ///< 1/s
  collision::Material material;
  collision::Filter filter;
};

/// @throws std::invalid_argument naming field, value and rule
void check(const ParticleKind& kind, std::string_view name);
/// A point mass with a ball about it. @param position  m, world     @param mass  kg
pbd::BodyId add_particle(Scene& scene, const ParticleKind& kind, const pbd::Vec3& position,
                         double mass);
/// The world's block of cloth; made where there is none.
pbd::ClothBlock& cloth_of(pbd::World& world);
/// Hold a particle where it now is on the host. It touches nothing from then on: it lies in what it
/// is attached to.
pbd::ClothRowId attach(pbd::World& world, collision::CollisionScene& shapes, pbd::BodyId particle,
                       pbd::BodyId host);
/// A point between two that resists bending. @param stiffness  N/m, of C = x_a - 2 x_m + x_b
void add_bending(pbd::World& world, pbd::BodyId a, pbd::BodyId middle, pbd::BodyId b,
                 double stiffness);

}  // namespace tandem::detail
