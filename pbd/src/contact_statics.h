// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "contact_support.h"
#include "tandem/pbd/contact.h"
#include "tandem/pbd/sparse_array.h"

namespace tandem::pbd {

/// Guesses what contacts carry that were not there before: a body's weight and what rests on it, as
/// far as nothing else holds it up, in equal shares. From the top of a pile downwards that is
/// statics. A sweep takes a load one contact further, so that a pile which is built at rest would
/// sink before it is held: a pyramid of 30 rows by 31 mm, with the guess by 1 mm.
class ContactStatics {
 public:
  /// Sets the forces of contacts that have no predecessor, touch and do not hit.
  /// @param arranged  as ContactSupport has made them
  /// @param reach     m: points with a wider gap do not touch
  /// @param h         s, length of a substep
  void guess(std::span<Contact> contacts, std::span<const ContactLink> arranged,
             const ContactSupport& support, std::span<const SolverBody> bodies,
             std::span<const std::uint32_t> movers, const Vec3& gravity, double reach, double h);

 private:
  /// Which body a contact holds up, and which one carries it.
  struct Rest {
    std::uint32_t upper = 0;
    std::uint32_t lower = 0;
    double cosine = 0.0;  ///< between its force and up; <= 0: it holds nothing up
  };
  Rest rest_of(const Contact& contact, const ContactSupport& support) const;

  Vec3 up_ = Vec3::UnitZ();
  std::vector<std::uint32_t> new_contacts_;   ///< contacts to guess, ascending by place
  detail::SparseArray<double> missing_;       ///< N, by body: weight and load that nothing holds up
  detail::SparseArray<std::uint32_t> count_;  ///< by body: contacts to guess that hold it up
};

}  // namespace tandem::pbd
