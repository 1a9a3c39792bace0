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

/// Sweeps on over the rows that one sweep has not solved: those with a body that the last sweep
/// still moved. What rests on carried impulses has none of them; impacts, cold starts and heavy
/// loads have. The work is bounded by a number of rows, and it goes to where bodies move most: an
/// impact in a pile is solved, the trembling around it is left. The rows that most need it are a
/// better choice than islands: a pyramid of 30 rows, swept whole or not at all, shears by 0.2 m at
/// twice the cost. In a block with such a row those of its
/// island are swept with it, as the other lanes cost nothing: asked for one by one, rows filled 1
/// lane of 2 (katamari), which took 5 % more time for the same overlap. Other islands keep their
/// bits as long as the budget lasts.
class ContactConvergence {
 public:
  struct Rule {
    double tolerance = 0.0;      ///< m/s, a normal velocity that changes by less is solved
    int rows = 0;                ///< swept again at most
    bool first_substep = false;  ///< friction starts anew in this substep
  };
  struct Outcome {
    int swept = 0;  ///< rows, each as often as it was
    int open = 0;   ///< rows, in blocks above the tolerance that were left
  };

  /// Room for groups of so many blocks.
  void reserve(std::size_t blocks, std::size_t bodies);
  /// @param rows  of the group     @param reverse  the direction of the first sweep
  Outcome run(const Rule& rule, ContactOrder& order, std::uint32_t group, bool reverse,
              std::span<ContactRows> rows, const ContactKernels& kernels,
              std::span<SolverBody> bodies, Workers& workers);

 private:
  /// What is asked of the rows of a block in a sweep.
  struct Open {
    LaneMask lanes = 0;       ///< none: the block is left out
    std::uint8_t octave = 0;  ///< how much a body of its rows moved, at most
  };
  /// The bodies of a block's rows that can move; of a row with one, that one twice. All blocks are
  /// looked at again and again, and one of rows is fifty cache lines.
  struct Ends {
    std::array<std::uint32_t, kLanes> a;
    std::array<std::uint32_t, kLanes> b;
    std::array<std::uint32_t, kLanes> island;
    LaneMask lanes;  ///< in use
  };
  /// Largest change of a row since the body was swept.
  struct Moved {
    float speed = 0.0f;       ///< m/s
    std::uint32_t sweep = 0;  ///< in which it was
  };
  static Ends ends_of(const ContactRows& rows, std::span<const SolverBody> bodies);
  /// In a sweep, which has the bodies of a block to itself.
  void note(std::uint32_t block, const ContactRows& rows, LaneMask lanes);
  /// Of a block: the rows in islands that have a row here with a body that moved by more than this,
  /// m/s.
  Open open_rows(const Ends& ends, float tolerance) const;
  /// The blocks with such rows.
  void find_open(float tolerance, Workers& workers);
  /// The lowest octave of those open blocks whose bodies moved most, with no more than `most` rows.
  /// @return how many rows
  int keep_most_moved(int most, std::size_t& lowest) const;

  detail::SparseArray<Moved> moved_;  ///< by body
  std::uint32_t sweep_ = 0;           ///< number of the sweep, of all steps
  std::vector<Ends> ends_;            ///< by block of the group
  std::vector<Open> open_;            ///< by block
  std::array<int, 256> octaves_{};  ///< rows of open blocks by the exponent of how much they moved
};

}  // namespace tandem::pbd
