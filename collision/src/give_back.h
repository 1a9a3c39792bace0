// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace tandem::collision {

/// Tells when lists may free memory. The first step after colliders were added looks at all of
/// them, and so does the second, which finds that they rest; later steps look at a few. True once
/// per addition: a step of an unchanged scene allocates nothing.
class Beginning {
 public:
  /// Call once per step.
  /// @param added  colliders added in the life of the scene
  bool is_over(std::uint64_t added) {
    if (added != added_) {
      added_ = added;
      steps_ = 0;
    }
    return ++steps_ == kSteps;
  }

 private:
  static constexpr std::uint64_t kSteps = 3;
  std::uint64_t added_ = 0;
  std::uint64_t steps_ = kSteps;  ///< since the last addition
};

/// Shrinks the list's memory if little of it is used.
template <class T>
void give_back(std::vector<T>& list) {
  constexpr std::size_t kKeep = 4096;
  if (list.capacity() > kKeep + 4 * list.size()) std::vector<T>(list).swap(list);
}

}  // namespace tandem::collision
