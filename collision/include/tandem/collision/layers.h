// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include "tandem/collision/material.h"
#include "tandem/pbd/export.h"

namespace tandem::collision {

/// Names for the categories of filters. All layers meet each other, and their like, until it is
/// said otherwise; a filter is what was said until it was asked for.
///
///     collision::Layers layers{"room", "players", "debris"};
///     layers.ignore("debris", "debris");
///     scene.add(Sphere{0.02}, {.filter = layers["debris"]});
///
/// @par Thread safety  A value: safe.
class TANDEM_API Layers {
 public:
  static constexpr std::size_t kMax = 32;

  /// @throws std::invalid_argument for no name, an empty one, one twice, or more than kMax
  Layers(std::initializer_list<std::string_view> names);

  /// Colliders of the one do not meet those of the other; both may be one layer.
  /// @throws std::invalid_argument naming what is no layer, and those that are
  void ignore(std::string_view a, std::string_view b);
  /// What a collider in the layer is given. @throws as ignore()
  Filter operator[](std::string_view name) const;

 private:
  std::size_t find(std::string_view name) const;

  std::vector<std::string> names_;
  std::array<std::uint32_t, kMax> masks_{};
};

}  // namespace tandem::collision
