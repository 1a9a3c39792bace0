// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "tandem/pbd/contact.h"
#include "tandem/pbd/sparse_array.h"

namespace tandem::pbd {

/// Summary of an awake contact for ordering. Several passes look at all of them, and contacts and
/// bodies are many cache lines each.
struct ContactLink {
  std::uint32_t contact = 0;  ///< index
  std::uint32_t a = 0;
  std::uint32_t b = 0;
  std::uint32_t group = 0;  ///< group in which it is solved
  bool moves_a = false;     ///< a is movable
  bool moves_b = false;
  bool face = false;    ///< more than one point
  bool is_new = false;  ///< absent in the last step
};

/// Orders contacts as load passes through them: contacts with immovable bodies first, then those of
/// the bodies that rest on them, and so on outwards. A sweep in this order and back takes the
/// weight of a pile down and its support up; in any other order a pile of a few stacks is not
/// solved in eight sweeps, and rocks for ever. The distance of a body, counted in contacts, does
/// not depend on the order in which bodies or contacts were added.
class ContactSupport {
 public:
  /// @param sequence  indices of contacts, which break ties; empty = ascending
  /// @param movers    see SubstepContext::movers
  /// @return the awake contacts. No allocation once the world has had its size.
  std::span<const ContactLink> arrange(std::span<const ContactBrief> contacts,
                                       std::span<const std::uint32_t> sequence,
                                       std::span<const SolverBody> bodies,
                                       std::span<const std::uint32_t> movers);
  /// Number of contacts from a body to the nearest immovable one, for a body that was in an
  /// arranged contact or is immovable.
  std::uint32_t distance(std::uint32_t body) const { return distance_[body]; }

 private:
  void find_awake(std::span<const ContactBrief> contacts, std::span<const std::uint32_t> sequence,
                  std::span<const SolverBody> bodies, std::span<const std::uint32_t> movers);
  void link(std::span<const std::uint32_t> movers);
  /// @return the largest distance
  std::uint32_t measure();

  /// By body; kFixed for immovable ones, and for all between two calls.
  std::vector<std::uint32_t> group_;
  std::vector<ContactLink> awake_;               ///< in sequence
  detail::SparseArray<std::uint32_t> distance_;  ///< by body, in contacts from an immovable one
  detail::SparseArray<std::uint32_t> first_;     ///< by mover, first index into neighbours_
  detail::SparseArray<std::uint32_t> end_;       ///< by mover, end index into neighbours_
  std::vector<std::uint32_t> neighbours_;        ///< movable bodies in contact
  std::vector<std::uint32_t> queue_;
  std::vector<std::uint32_t> start_;  ///< by sum of distances, index into places_
  std::vector<ContactLink> places_;
};

}  // namespace tandem::pbd
