// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/collision/layers.h"

#include <algorithm>

#include "tandem/pbd/validate.h"

namespace tandem::collision {

Layers::Layers(std::initializer_list<std::string_view> names) {
  if (names.size() == 0 || names.size() > kMax) {
    pbd::detail::refuse("Layers: number of names", "from 1 to 32", std::to_string(names.size()));
  }
  for (const std::string_view name : names) {
    if (name.empty() || std::find(names_.begin(), names_.end(), name) != names_.end()) {
      pbd::detail::refuse("Layers: name", "of one layer, and not empty",
                          '"' + std::string(name) + '"');
    }
    names_.emplace_back(name);
  }
  masks_.fill(~0u);
}

std::size_t Layers::find(std::string_view name) const {
  const auto at = std::find(names_.begin(), names_.end(), name);
  if (at != names_.end()) return static_cast<std::size_t>(at - names_.begin());
  std::string known;
  for (const std::string& one : names_) known += (known.empty() ? "" : ", ") + one;
  pbd::detail::refuse("Layers: name", "one of " + known, '"' + std::string(name) + '"');
}

void Layers::ignore(std::string_view a, std::string_view b) {
  const std::size_t first = find(a);
  const std::size_t second = find(b);
  masks_[first] &= ~(1u << second);
  masks_[second] &= ~(1u << first);
}

Filter Layers::operator[](std::string_view name) const {
  const std::size_t layer = find(name);
  return {.category = 1u << layer, .mask = masks_[layer]};
}

}  // namespace tandem::collision
