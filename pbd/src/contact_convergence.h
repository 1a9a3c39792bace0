// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "contact_order.h"
#include "contact_row.h"

namespace tandem::pbd {

/// Sweeps on over the rows that one sweep has not solved: those with a body that the last sweep
/// still moved. What rests on carried impulses has none of them; impacts, cold starts and heavy
/// loads have. The work is bounded by a number of rows, and it goes to where bodies move most: an
/// impact in a pile is solved, the trembling around it is left. The rows that most need it are a
/// better choice than islands: a pyramid of 30 rows, swept whole or not at all, shears by 0.2 m at
/// twice the cost.
class ContactConvergence {
 public:
  struct Rule {
    double tolerance = 0.0;  ///< m/s, a normal velocity that changes by less is solved
    int rows = 0;            ///< swept again at most
    bool fresh = false;      ///< friction starts anew in this substep
  };
  struct Outcome {
    int swept = 0;  ///< rows, each as often as it was
    int open = 0;   ///< rows above the tolerance that were left
  };

  /// @param reverse  the direction of the first sweep
  Outcome run(const Rule& rule, const ContactOrder& order, std::uint32_t group, bool reverse,
              std::span<ContactRows> rows, const ContactKernels& kernels,
              std::span<SolverBody> bodies, Workers& workers);

 private:
  struct Open {
    std::uint32_t block = 0;
    LaneMask lanes = 0;
    std::array<std::uint8_t, kLanes> octave{};  ///< how much each row's bodies moved
  };

  /// The bodies of a block's rows: all blocks are looked at again and again, and one of rows is
  /// fifty cache lines.
  struct Ends {
    std::array<std::uint32_t, kLanes> a;
    std::array<std::uint32_t, kLanes> b;
    LaneMask lanes;  ///< in use
  };
  void note(const ContactRows& rows, LaneMask lanes);
  /// The rows with a body that moved by more than this, m/s.
  /// @param first  block
  void find_open(std::uint32_t first, float tolerance);
  /// Keep those open rows whose bodies moved most, no more than `most`: whole octaves.
  /// @return how many
  int keep_most_moved(int most);
  /// Share out the open rows, level by level.
  void plan(const ContactOrder& order);

  std::vector<float> moved_;        ///< m/s, by body: largest change of a row since it was swept
  std::vector<Ends> ends_;          ///< by block of the group
  std::vector<Open> open_;          ///< by ascending block
  SweepPlan plan_;                  ///< of indices into open_
  std::array<int, 256> octaves_{};  ///< open rows by the exponent of how much they moved
};

}  // namespace tandem::pbd
