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

/// Guesses the loads of new contacts: the weight of a body and of what rests on it, less the part
/// that is already supported, in equal shares. From the top of a pile downwards this is statics.
/// Gauss-Seidel propagates load by one contact per sweep; without the guess a pile built at rest
/// sinks before its forces build up: a pyramid of 30 rows by 31 mm, with it by 1 mm.
class ContactStatics {
 public:
  /// Sets the forces of contacts without predecessor that touch and do not hit.
  /// @param arranged  from ContactSupport::arrange()
  /// @param reach     m: points with a wider gap do not touch
  /// @param h         s, length of a substep
  void guess(std::span<Contact> contacts, std::span<const ContactLink> arranged,
             const ContactSupport& support, std::span<const SolverBody> bodies,
             std::span<const std::uint32_t> movers, const Vec3& gravity, double reach, double h);

 private:
  /// Which body a contact supports, and which one carries it.
  struct Rest {
    std::uint32_t upper = 0;
    std::uint32_t lower = 0;
    double cosine = 0.0;  ///< between its force and up; <= 0: it supports nothing
  };
  Rest rest_of(const Contact& contact, const ContactSupport& support) const;

  Vec3 up_ = Vec3::UnitZ();
  std::vector<std::uint32_t> new_contacts_;   ///< contacts to guess, in arranged order
  detail::SparseArray<double> missing_;       ///< N, by body: weight and load without support
  detail::SparseArray<std::uint32_t> count_;  ///< by body: contacts to guess that support it
};

}  // namespace tandem::pbd
