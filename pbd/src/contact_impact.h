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

/// Blows that pass on from contact to contact within a substep.
///
/// The pass stops what approaches in all rows together, as if bodies that touch were one. A blow is
/// not shared like that: it hits those rows alone that approach. Rows that are hit at once share it
/// as geometry says, and what they hit then passes on what it got. So rounds of simultaneous
/// impacts follow each other, from the velocities before the substep, until no row approaches
/// faster than what bounces, and the velocity pass starts from the impulses that came out. A round
/// cannot add energy, as each row that pushes had approached and parts no faster than that.
/// Source: [smith2012], generalised reflections. Differs: a round asks each row for its own
/// restitution, and what approaches more slowly than its neighbour waits.
class ContactImpacts {
 public:
  /// Room for a step with so many bodies, and groups of so many blocks.
  void reserve(std::size_t bodies, std::size_t blocks);
  /// Velocities as they are before the substep, and impulses as it begins with them.
  /// @param slow  m/s, slower impacts do not bounce
  /// @param order  of blocks; empty: as they lie     @pre what it views lasts until run()
  void begin(std::span<const ContactRows> rows, std::span<const std::uint32_t> order,
             std::span<const SolverBody> bodies, double slow);
  /// Once in a substep, after the pass: rows that carry nothing did not close and are not hit.
  /// @param most  rows struck; what is left then approaches without a bounce
  void run(std::span<ContactRows> rows, const ContactKernels& kernels, std::span<SolverBody> bodies,
           int most);

 private:
  struct Open {
    std::uint32_t block = 0;
    LaneMask lanes = 0;
  };

  /// Rows that are hit next, at once or after others.
  void find_open(std::span<const ContactRows> rows, const ContactKernels& kernels,
                 BodyNumbers bodies, double slow, bool first);
  /// Leave those that make up the next round.
  /// @return whether some body has two rows in it
  bool take_round(std::span<ContactRows> rows);

  bool any_ = false;  ///< some row bounces in this substep
  double slow_ = 0.0;
  std::vector<Blow> blows_;            ///< by block
  detail::SparseArray<Twist> before_;  ///< by body
  detail::SparseArray<double>
      reached_;  ///< m/s, by body: fastest approach in open rows; 0, in none
  detail::SparseArray<std::uint8_t> moved_;  ///< by body: in this round
  std::vector<Open> open_;                   ///< in order
  std::span<const std::uint32_t> order_;     ///< of blocks; empty: as they lie
};

}  // namespace tandem::pbd
