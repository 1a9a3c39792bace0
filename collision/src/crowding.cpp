// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/collision/crowding.h"

#include <vector>

#include "aabb_tree.h"
#include "collider.h"

namespace tandem::collision {

bool is_crowded(const CollisionScene& scene, const pbd::World& world, std::size_t most) {
  std::vector<Collider> all;
  AabbTree tree;
  std::vector<std::uint32_t> stack;
  std::size_t pairs = 0;
  for (std::uint32_t i = 0; i < scene.slot_count(); ++i) {
    const ColliderId id = scene.collider_at(i);
    if (!scene.contains(id) || !world.contains(scene.collider(id).body)) continue;
    Collider collider = make_collider(scene.collider(id), scene.options());
    update_collider(collider, world, 0.0);
    if (collider.is_half_space() || !collider.finite) continue;
    tree.query(collider.needed, stack, [&](std::uint32_t at) {
      const Collider& other = all[at];
      const bool meet = (collider.dynamic || other.dynamic) &&
                        collider.def.body != other.def.body &&
                        may_meet(collider.def.filter, other.def.filter);
      pairs += meet ? 1 : 0;
    });
    if (pairs > most) return true;
    tree.insert(collider.needed, static_cast<std::uint32_t>(all.size()));
    all.push_back(std::move(collider));
  }
  return false;
}

}  // namespace tandem::collision
