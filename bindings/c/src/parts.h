// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <span>

#include "convert.h"
#include "guard.h"
#include "world_impl.h"

namespace tandem::c {

inline collision::Filter from_c(const tandem_filter& filter) {
  return {.category = filter.category, .mask = filter.mask, .group = filter.group};
}
inline tandem_filter to_c(const collision::Filter& filter) {
  return {.category = filter.category, .mask = filter.mask, .group = filter.group};
}

/// Removes existing bodies, the last one first, so that the next ones get their slots in order.
inline void remove_all(tandem_world& world, std::span<const pbd::BodyId> bodies) noexcept {
  for (std::size_t i = bodies.size(); i-- > 0;) {
    if (world.world.contains(bodies[i])) {
      guarded(nullptr, [&] { world.world.remove_body(bodies[i]); });
    }
  }
}

/// @throws std::invalid_argument if one of its bodies was removed
inline void require_all(const tandem_world& world, std::span<const pbd::BodyId> bodies,
                        const char* name) {
  for (const pbd::BodyId body : bodies) {
    if (!world.world.contains(body)) pbd::detail::refuse(name, "one whose bodies are all there");
  }
}

inline size_t copied(std::span<const pbd::BodyId> from, tandem_body* to, size_t capacity) {
  for (size_t i = 0; i < from.size() && i < capacity && to != nullptr; ++i) to[i] = to_c(from[i]);
  return from.size();
}

}  // namespace tandem::c
