// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <vector>

namespace tandem::collision {

/// A scene that begins looks at all that it has, and never again at so much.
/// @param usual  entries that a step may have
template <class T>
void give_back(std::vector<T>& list, std::size_t usual) {
  constexpr std::size_t kKeep = 4096;
  if (list.capacity() > kKeep + 4 * usual && list.size() <= usual) std::vector<T>(list).swap(list);
}

}  // namespace tandem::collision
