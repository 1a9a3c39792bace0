// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "contact_order.h"
#include "contact_row.h"
#include "tandem/pbd/sparse_array.h"

namespace tandem::pbd {

/// Sweeps again over the rows that one sweep has not solved: rows with a body that the last sweep
/// still moved. Resting contacts with warm start have none; impacts, cold starts and heavy loads
/// have. The work is bounded by a number of rows and goes to the fastest bodies: impacts are
/// solved, residual jitter around them is left alone. Choosing rows is better than choosing
/// islands: a pyramid of 30 rows, swept whole or not at all, shears by 0.2 m at twice the cost. All
/// rows of the same island in a block are swept with an open one, as the other lanes cost nothing:
/// single rows filled 1 lane of 2 (katamari) and took 5 % more time for the same overlap. Other
/// islands keep their bits as long as the budget lasts.
class ContactConvergence {
 public:
  struct Rule {
    double tolerance = 0.0;      ///< m/s, a smaller change of a normal velocity counts as solved
    int rows = 0;                ///< budget of rows to sweep again
    int sweeps = 0;              ///< limit
    bool first_substep = false;  ///< see normal_friction_iterations()
  };
  struct Outcome {
    int swept = 0;  ///< rows, counted once per sweep
    int open = 0;   ///< rows above the tolerance, in blocks, that were left
  };

  /// Reserves for groups of so many blocks.
  void reserve(std::size_t blocks, std::size_t bodies);
  /// @param rows  rows of the group     @param reverse  direction of the first sweep
  Outcome run(const Rule& rule, ContactOrder& order, std::uint32_t group, bool reverse,
              std::span<ContactRows> rows, const ContactKernels& kernels,
              std::span<SolverBody> bodies, Workers& workers);

 private:
  /// Rows of a block to solve in a sweep.
  struct Open {
    LaneMask lanes = 0;       ///< 0: the block is skipped
    std::uint8_t octave = 0;  ///< largest motion of a body of its rows
  };
  /// The movable bodies of a block's rows; a row with one has it twice. Compact, as all blocks are
  /// scanned again and again and one of rows is dozens of cache lines.
  struct Ends {
    std::array<std::uint32_t, kLanes> a;
    std::array<std::uint32_t, kLanes> b;
    std::array<std::uint32_t, kLanes> island;
    LaneMask lanes;  ///< in use
  };
  /// Largest change of a row since the body was swept.
  struct Moved {
    float speed = 0.0f;       ///< m/s
    std::uint32_t sweep = 0;  ///< sweep of that change
  };
  static Ends ends_of(const ContactRows& rows, std::span<const SolverBody> bodies);
  /// Called in a sweep, which has the bodies of a block to itself.
  void note(std::uint32_t block, const ContactRows& rows, LaneMask lanes);
  /// The rows of a block in islands that have a row here with a body that moved faster than
  /// `tolerance`, m/s.
  Open open_rows(const Ends& ends, float tolerance) const;
  /// Finds the blocks with such rows.
  void find_open(float tolerance, Workers& workers);
  /// Keeps the open blocks with the fastest bodies, at most `most` rows.
  /// @param lowest  set to the lowest octave kept
  /// @return the number of rows
  int keep_most_moved(int most, std::size_t& lowest) const;

  detail::SparseArray<Moved> moved_;  ///< by body
  std::uint32_t sweep_ = 0;           ///< sequence number, over all steps
  std::vector<Ends> ends_;            ///< by block of the group
  std::vector<Open> open_;            ///< by block
  std::array<int, 256> octaves_{};    ///< rows of open blocks by the binary exponent of their speed
};

}  // namespace tandem::pbd
