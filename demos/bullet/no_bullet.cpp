// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <stdexcept>

#include "session/physics.h"

namespace tandem::demos {

bool has_bullet() { return false; }

std::unique_ptr<Physics> make_bullet_physics(const Scene& /*scene*/,
                                             std::optional<int> /*iterations*/) {
  throw std::invalid_argument("engine = bullet breaks: built with Bullet (TANDEM_BULLET_PEER)");
}

}  // namespace tandem::demos
