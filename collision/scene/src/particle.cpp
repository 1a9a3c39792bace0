// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// A translation unit of its own: programs without cloth and ropes do not link it.
#include "particle.h"

#include <cmath>

#include "tandem/pbd/validate.h"

namespace tandem::detail {

using pbd::BodyId;
using pbd::Vec3;

void check(const ParticleKind& kind, std::string_view name) {
  pbd::detail::require(kind.radius > 0.0 && std::isfinite(kind.radius), name, "radius", kind.radius,
                       "finite and > 0");
  pbd::detail::require(kind.damping >= 0.0 && std::isfinite(kind.damping), name, "damping",
                       kind.damping, "finite and >= 0");
  std::string error;
  if (!kind.material.validate(&error)) throw std::invalid_argument(error);
}

BodyId add_particle(Scene& scene, const ParticleKind& kind, const Vec3& position, double mass) {
  return scene.add(collision::Sphere{kind.radius}, {.mass = mass,
                                                    .pose = {.position = position},
                                                    .material = kind.material,
                                                    .filter = kind.filter,
                                                    .linear_damping = kind.damping,
                                                    .locks = {.angular = {true, true, true}}});
}

pbd::ClothBlock& cloth_of(pbd::World& world) {
  for (const auto& block : world.blocks()) {
    if (auto* cloth = dynamic_cast<pbd::ClothBlock*>(block.get())) return *cloth;
  }
  return world.add_block<pbd::ClothBlock>();
}

pbd::ClothRowId attach(pbd::World& world, collision::CollisionScene& shapes, BodyId particle,
                       BodyId host) {
  const Vec3 anchor = world.pose(host).to_local(world.pose(particle).position);
  const pbd::ClothRowId id = cloth_of(world).add(
      world, pbd::AttachmentDef{.particle = particle, .host = host, .anchor_l = anchor});
  for (std::uint32_t i = 0; i < shapes.slot_count(); ++i) {
    const collision::ColliderId collider = shapes.collider_at(i);
    if (collider.valid() && shapes.collider(collider).body == particle) {
      shapes.set_filter(collider, {.category = 0, .mask = 0});
    }
  }
  return id;
}

void add_bending(pbd::World& world, BodyId a, BodyId middle, BodyId b, double stiffness) {
  cloth_of(world).add(world, pbd::MeanDef{.points = {a, middle, b},
                                          .weights = {1.0, -2.0, 1.0},
                                          .compliance = 1.0 / stiffness});
}

}  // namespace tandem::detail
