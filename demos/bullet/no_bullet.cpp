// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "session/physics.h"
#include "tandem/pbd/validate.h"

namespace tandem::demos {

bool has_bullet() { return false; }

std::unique_ptr<Physics> make_bullet_physics(const Scene& /*scene*/,
                                             std::optional<int> /*iterations*/) {
  pbd::detail::refuse("engine", "tandem in a build without Bullet (TANDEM_BULLET_PEER)", "bullet");
}

}  // namespace tandem::demos
