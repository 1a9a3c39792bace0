// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "watched_colliders.h"

#include <algorithm>
#include <utility>

namespace tandem::collision {

void WatchedColliders::add(std::uint32_t collider) {
  if (collider >= listed_.size()) listed_.resize(collider + std::size_t{1}, 0);
  if (std::exchange(listed_[collider], std::uint8_t{1}) != 0) return;
  in_order_ = in_order_ && (list_.empty() || list_.back() < collider);
  list_.push_back(collider);
}

void WatchedColliders::update(const pbd::World& world, std::span<const Collider> colliders,
                              const pbd::ByBody& by_body) {
  const bool known = world.body_log().read(seen_, [&](std::uint32_t body) {
    by_body.for_rows(body, [&](std::uint32_t row, std::uint32_t) { add(row); });
  });
  if (!known) {
    list_.clear();
    listed_.assign(colliders.size(), 0);
    in_order_ = true;
    for (std::uint32_t i = 0; i < colliders.size(); ++i) {
      if (colliders[i].alive) add(i);
    }
  }
  if (!std::exchange(in_order_, true)) std::sort(list_.begin(), list_.end());
}

void WatchedColliders::leave_still(const pbd::World& world, std::span<const Collider> colliders) {
  std::erase_if(list_, [&](std::uint32_t i) {
    const Collider& c = colliders[i];
    const bool moves =
        c.alive && (!c.finite || !c.still ||
                    world.all_props()[c.def.body.index].type != pbd::BodyType::Static);
    listed_[i] = moves ? 1 : 0;
    return !moves;
  });
}

}  // namespace tandem::collision
