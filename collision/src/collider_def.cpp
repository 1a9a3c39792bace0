// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// The rules of what a scene is given.
#include <stdexcept>
#include <string>

#include "contact_source_impl.h"
#include "tandem/pbd/validate.h"

namespace tandem::collision {

void check_def(const pbd::World& world, const ColliderDef& def) {
  pbd::detail::require_body(world, def.body, "ColliderDef", "body");
  std::string error;
  if (!validate(def.shape, &error)) throw std::invalid_argument("ColliderDef: shape: " + error);
  pbd::detail::require_finite(def.local.position, "ColliderDef", "local.position");
  pbd::detail::require_unit(def.local.orientation, "ColliderDef", "local.orientation");
  if (!def.material.validate(&error)) throw std::invalid_argument("ColliderDef: " + error);
}

bool CollisionOptions::validate(std::string* error) const {
  const auto in = [&](const char* field, double value, double low, double high) {
    return pbd::detail::in_range(value, low, high, std::string("CollisionOptions.") + field, error);
  };
  return in("speculative_margin", speculative_margin, 0.0, 10.0) &&
         in("recycle_distance", recycle_distance, 0.0, 1.0) &&
         in("recycle_angle", recycle_angle, 0.0, 0.2);
}

}  // namespace tandem::collision
