// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "contact_support.h"
#include "tandem/pbd/sparse_array.h"

namespace tandem::pbd {

/// Where contacts of large islands are: in one of 16 x 16 columns with about as many contacts each,
/// numbered along a Z curve, so that columns whose numbers are near lie near each other. What lies
/// upon something lies in its column or near it.
class ContactCells {
 public:
  static constexpr std::uint32_t kCells = 256;
  /// Contacts of a group that is one island, from which on it has cells.
  static constexpr std::uint32_t kLarge = 4096;

  /// @param links  all that are awake
  void find(std::span<const ContactLink> links, const SubstepContext& ctx);
  /// Contacts of a group that has cells; 0 of others.
  std::uint32_t contacts(std::uint32_t group) const {
    return group < contacts_.size() ? contacts_[group] : 0;
  }
  bool any() const { return any_; }
  /// 0 in groups without cells.
  std::uint32_t of(const ContactLink& link) const {
    if (!any_ || contacts_[link.group] == 0) return 0;
    return cell_of_[link.moves_a ? link.a : link.b];
  }

 private:
  static constexpr std::size_t kSide = 16;

  struct Body {
    std::array<double, 2> place;  ///< m, along the axes that gravity is least along
    std::uint32_t index = 0;
    std::uint32_t contacts = 0;
    std::uint8_t slab = 0;  ///< along the first axis
  };
  void divide_group();

  bool any_ = false;
  std::vector<std::uint32_t> contacts_;             ///< by group; 0 where it has no cells
  detail::SparseArray<std::uint32_t> contacts_of_;  ///< by mover
  detail::SparseArray<std::uint8_t> cell_of_;       ///< by mover, where the group has cells
  std::vector<Body> bodies_;                        ///< of a group
};

}  // namespace tandem::pbd
