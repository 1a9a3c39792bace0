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

/// Names for the categories of filters. All layers meet each other and themselves unless ignore()
/// is called. A filter reflects the calls up to the moment it was made.
///
///     collision::Layers layers{"room", "players", "debris"};
///     layers.ignore("debris", "debris");
///     scene.add(Sphere{0.02}, {.filter = layers["debris"]});
///
/// @par Thread safety  A value: safe.
class TANDEM_API Layers {
 public:
  static constexpr std::size_t kMax = 32;

  /// @throws std::invalid_argument for no name, an empty one, duplicates, or more than kMax
  Layers(std::initializer_list<std::string_view> names);

  /// Colliders of layer a do not meet those of layer b; a may be b.
  /// @throws std::invalid_argument naming the unknown layer and the known ones
  void ignore(std::string_view a, std::string_view b);
  /// The filter for a collider in the layer. @throws as ignore()
  Filter operator[](std::string_view name) const;

 private:
  std::size_t find(std::string_view name) const;

  std::vector<std::string> names_;
  std::array<std::uint32_t, kMax> masks_{};
};

}  // namespace tandem::collision
