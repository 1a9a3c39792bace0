// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "parts.h"
#include "tandem/pbd/cloth_block.h"

using namespace tandem;
using namespace tandem::c;

tandem_result tandem_attachment_remove(tandem_world* world, tandem_attachment attachment,
                                       tandem_error* error) {
  return guarded(error, [&] {
    const pbd::ClothRowId id{attachment.number};
    for (const auto& block : required(world, "world").world.blocks()) {
      auto* const cloth = dynamic_cast<pbd::ClothBlock*>(block.get());
      if (cloth != nullptr && cloth->contains(id)) return cloth->remove(id);
    }
    pbd::detail::refuse("attachment", "one that still holds", std::to_string(id.number));
  });
}
