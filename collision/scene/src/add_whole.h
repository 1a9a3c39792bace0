// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <vector>

#include "tandem/scene.h"

namespace tandem::detail {

/// Adds several bodies to a scene, all or nothing. If `add` throws, the bodies that it has put into
/// `parts` are removed with everything that names them, last one first, so that their slots are
/// reused in the same order; blocks of rows added meanwhile are removed too.
template <class Add>
void add_whole(Scene& scene, const std::vector<BodyId>& parts, Add&& add) {
  pbd::World& world = scene.world();
  std::vector<const pbd::ConstraintBlock*> before;
  for (const auto& block : world.blocks()) before.push_back(block.get());
  try {
    add();
  } catch (...) {
    for (std::size_t i = parts.size(); i-- > 0;) world.remove_body(parts[i]);
    std::vector<const pbd::ConstraintBlock*> fresh;
    for (const auto& block : world.blocks()) {
      if (std::find(before.begin(), before.end(), block.get()) == before.end()) {
        fresh.push_back(block.get());
      }
    }
    for (const pbd::ConstraintBlock* block : fresh) world.remove_block(*block);
    throw;
  }
}

}  // namespace tandem::detail
