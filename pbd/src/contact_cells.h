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

/// Spatial order of the contacts of large islands: 16 x 16 columns with about as many contacts
/// each, numbered along a Z curve, so that columns with near numbers are near each other. A body
/// and its support are in the same column or neighbouring ones.
class ContactCells {
 public:
  static constexpr std::uint32_t kCells = 256;
  /// Contacts from which on a group of one island has cells.
  static constexpr std::uint32_t kLarge = 4096;

  /// @param links  all awake contacts
  void find(std::span<const ContactLink> links, const SubstepContext& ctx);
  /// Contacts of a group with cells; 0 for others.
  std::uint32_t contacts(std::uint32_t group) const {
    return group < contacts_.size() ? contacts_[group] : 0;
  }
  bool any() const { return any_; }
  /// Cell of a contact; 0 in groups without cells.
  std::uint32_t of(const ContactLink& link) const {
    if (!any_ || contacts_[link.group] == 0) return 0;
    return cell_of_[link.moves_a ? link.a : link.b];
  }

 private:
  static constexpr std::size_t kSide = 16;

  struct Body {
    std::array<double, 2> place;  ///< m, along the two axes with the smallest part of gravity
    std::uint32_t index = 0;
    std::uint32_t contacts = 0;
    std::uint8_t slab = 0;  ///< along the first axis
  };
  void divide_group();

  bool any_ = false;
  std::vector<std::uint32_t> contacts_;             ///< by group; 0 = no cells
  detail::SparseArray<std::uint32_t> contacts_of_;  ///< by mover
  detail::SparseArray<std::uint8_t> cell_of_;       ///< by mover, in groups with cells
  std::vector<Body> bodies_;                        ///< of one group
};

}  // namespace tandem::pbd
