// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "contact_order.h"
#include "contact_row.h"
#include "tandem/pbd/sparse_array.h"

namespace tandem::pbd {

/// Impacts that propagate from contact to contact within a substep.
///
/// The velocity pass stops all approaching rows together, as if touching bodies were one. An impact
/// acts only on the rows that approach. Rows that are hit at once share it by their geometry, and
/// the bodies that they hit then pass it on. So rounds of simultaneous impacts follow each other,
/// starting from the velocities before the substep, until no row approaches faster than the bounce
/// threshold. The velocity pass then starts from their impulses. A round cannot add energy, as each
/// row that pushes had approached and separates no faster than that.
/// Source: [smith2012], generalised reflections. Differs: a round uses the restitution of each row,
/// and slower approaches wait for faster neighbours.
class ContactImpacts {
 public:
  /// Reserves for so many bodies, and groups of so many blocks.
  void reserve(std::size_t bodies, std::size_t blocks);
  /// Stores the velocities before the substep, and the impulses that it begins with.
  /// @param slow  m/s, slower impacts do not bounce
  /// @param order  of blocks; empty: ascending     @pre the views outlive run()
  void begin(std::span<const ContactRows> rows, std::span<const std::uint32_t> order,
             std::span<const SolverBody> bodies, double slow);
  /// Once in a substep, after the pass: unloaded rows did not close and are not hit.
  /// @param most  budget of rows struck; the rest approaches without a bounce
  void run(std::span<ContactRows> rows, const ContactKernels& kernels, std::span<SolverBody> bodies,
           int most);

 private:
  struct Open {
    std::uint32_t block = 0;
    LaneMask lanes = 0;
  };

  /// Finds the rows that approach, hit at once or later.
  void find_open(std::span<const ContactRows> rows, const ContactKernels& kernels,
                 BodyNumbers bodies, double slow, bool first);
  /// Keeps only the rows of the next round.
  /// @return whether some body has two rows in it
  bool take_round(std::span<ContactRows> rows);

  bool any_ = false;  ///< some row bounces in this substep
  double slow_ = 0.0;
  std::vector<Blow> blows_;            ///< by block
  detail::SparseArray<Twist> before_;  ///< by body
  detail::SparseArray<double>
      reached_;  ///< m/s, by body: fastest approach in open rows; 0, in none
  detail::SparseArray<std::uint8_t> moved_;  ///< by body: 1 = in this round
  std::vector<Open> open_;                   ///< in order
  std::span<const std::uint32_t> order_;     ///< of blocks; empty: ascending
};

}  // namespace tandem::pbd
