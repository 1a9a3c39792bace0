// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <string>

#include "tandem/pbd/export.h"

namespace tandem::collision {

/// How the values of two colliders combine in their contact. If two rules differ, the later one in
/// this list applies; `Default` yields to every other rule.
enum class Combine : std::uint8_t {
  Default,        ///< friction: GeometricMean; restitution: Maximum
  GeometricMean,  ///< sqrt(a b)
  Average,        ///< (a + b) / 2
  Minimum,
  Multiply,
  Maximum,
};

/// Surface properties of a collider.
struct TANDEM_API Material {
  double friction = 0.5;     ///< Coulomb, >= 0
  double restitution = 0.0;  ///< 0 to 1
  Combine friction_rule = Combine::Default;
  Combine restitution_rule = Combine::Default;

  /// Whether all fields are valid; if not, `error` names field, value and rule.
  bool validate(std::string* error = nullptr) const;
};

/// Friction of the contact between two materials, >= 0.
TANDEM_API double combined_friction(const Material& a, const Material& b);
/// Restitution of the contact between two materials, 0 to 1.
TANDEM_API double combined_restitution(const Material& a, const Material& b);

/// Which colliders meet. Equal groups other than 0 decide alone, else category and mask do.
struct TANDEM_API Filter {
  std::uint32_t category = 1;  ///< categories of the collider, as bits
  std::uint32_t mask = ~0u;    ///< categories that it meets, as bits
  std::int32_t group = 0;      ///< equal and > 0: always meet; equal and < 0: never; 0: no group
};

/// Whether two filters let their colliders meet; symmetric.
inline bool may_meet(const Filter& a, const Filter& b) {
  if (a.group == b.group && a.group != 0) return a.group > 0;
  return (a.category & b.mask) != 0 && (b.category & a.mask) != 0;
}

}  // namespace tandem::collision
