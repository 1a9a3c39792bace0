// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "tandem/pbd/contact.h"
#include "tandem/pbd/sparse_array.h"

namespace tandem::pbd {

/// Finds islands that want more substeps than the solver's: see ConstraintBlock::end_step().
class ContactRefinement {
 public:
  /// @param sequence  contacts in order; empty: ascending
  /// @param budget    rows of further substeps
  /// @return rows that islands wanted beyond the budget
  int want(std::span<const Contact> contacts, std::span<const std::uint32_t> sequence, int budget,
           const SubstepContext& ctx, std::span<double> wanted);

 private:
  /// How heavily the contacts of an island are loaded.
  struct Load {
    double ratio2 = 0.0;  ///< sum of (load / weight of the lighter body)^2
    double speed2 = 0.0;  ///< m^2/s^2, sum over bodies
    std::uint32_t bodies = 0;
    std::uint32_t contacts = 0;
    double for_size = 0.0;  ///< substeps wanted by its smallest body
    double wanted = 0.0;    ///< substeps
  };
  /// Contribution of a contact to its island.
  struct Share {
    std::uint32_t island = 0;  ///< BodyId::kNone: asleep
    double ratio2 = 0.0;
    double for_size = 0.0;
  };
  static Share share_of(const Contact& contact, const SubstepContext& ctx);

  detail::SparseArray<Load> loads_;  ///< by the island's lowest body
  std::vector<Share> shares_;        ///< by contact
};

}  // namespace tandem::pbd
