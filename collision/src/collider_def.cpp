// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// The rules of what a scene is given.
#include <cmath>
#include <sstream>
#include <stdexcept>

#include "contact_source_impl.h"
#include "refuse.h"

namespace tandem::collision {

void check_def(const pbd::World& world, const ColliderDef& def) {
  if (!world.contains(def.body)) {
    refuse("ColliderDef: body", static_cast<double>(def.body.index), "a body of this world");
  }
  std::string error;
  if (!validate(def.shape, &error)) throw std::invalid_argument("ColliderDef: shape: " + error);
  for (int i = 0; i < 3; ++i) {
    const double value = def.local.position[i];
    if (!std::isfinite(value)) refuse("ColliderDef: local.position", value, "finite");
  }
  const double norm = def.local.orientation.norm();
  if (!(std::abs(norm - 1.0) < 1e-3)) {
    refuse("ColliderDef: local.orientation", norm, "a quaternion of unit norm (within 1e-3)");
  }
  if (!def.material.validate(&error)) throw std::invalid_argument("ColliderDef: " + error);
}

bool CollisionOptions::validate(std::string* error) const {
  const auto in = [&](const char* field, double value, double low, double high) {
    if (value >= low && value <= high) return true;
    if (error != nullptr) {
      std::ostringstream text;
      text << "CollisionOptions." << field << " = " << value << " breaks the rule: " << low
           << " to " << high;
      *error = text.str();
    }
    return false;
  };
  return in("speculative_margin", speculative_margin, 0.0, 10.0) &&
         in("speculative_size_share", speculative_size_share, 1e-6, 1.0) &&
         in("aabb_margin", aabb_margin, 1e-6, 100.0) &&
         in("recycle_distance", recycle_distance, 0.0, 1.0) &&
         in("recycle_size_share", recycle_size_share, 0.0, 0.1) &&
         in("recycle_angle", recycle_angle, 0.0, 0.2);
}

}  // namespace tandem::collision
