// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "query_colliders.h"

#include "broad_phase.h"

namespace tandem::collision {
namespace {

bool same_pose(const pbd::Pose& l, const pbd::Pose& r) {
  return l.position == r.position && l.orientation.coeffs() == r.orientation.coeffs();
}

}  // namespace

void QueryColliders::drop(Entry& entry) {
  if (entry.leaf != AabbTree::kNone) tree_.remove(entry.leaf);
  entry.leaf = AabbTree::kNone;
  entry.present = false;
}

void QueryColliders::renew(Entry& entry, const CollisionScene& scene, ColliderId id) {
  drop(entry);
  entry.collider = make_collider(scene.collider(id), scene.options());
  entry.collider.generation = id.generation;
}

void QueryColliders::place(Entry& entry, std::uint32_t index, double margin) {
  const Aabb& needed = entry.collider.needed;
  if (entry.leaf == AabbTree::kNone) {
    entry.leaf = tree_.insert(needed.expanded(margin), index);
  } else if (!tree_.box(entry.leaf).contains(needed)) {
    tree_.move(entry.leaf, needed.expanded(margin));
  }
}

void QueryColliders::update(const pbd::World& world, const CollisionScene& scene) {
  const std::uint32_t slots = scene.slot_count();
  for (std::uint32_t i = slots; i < size(); ++i) drop(entries_[i]);
  entries_.resize(slots);
  half_spaces_.clear();
  for (std::uint32_t i = 0; i < slots; ++i) {
    Entry& entry = entries_[i];
    Collider& c = entry.collider;
    const ColliderId id = scene.collider_at(i);
    if (!id.valid() || !world.contains(scene.collider(id).body)) {
      drop(entry);
      c.alive = false;
      continue;
    }
    const ColliderDef& def = scene.collider(id);
    const bool known = c.alive && c.generation == id.generation && c.def.body == def.body;
    if (!known) renew(entry, scene, id);
    c.def.filter = def.filter;
    if (!known || !entry.present || !same_pose(c.body, world.states()[def.body.index].pose)) {
      c.asleep = false;  // it may have been awake since the last update
      update_collider(c, world, 0.0);
      entry.present = c.finite;
      if (!c.finite) {
        drop(entry);
      } else if (!c.is_half_space()) {
        place(entry, i, kAabbMargin);
      }
    }
    if (entry.present && c.is_half_space()) half_spaces_.push_back(i);
  }
}

}  // namespace tandem::collision
