// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "contact_order.h"
#include "contact_row.h"

namespace tandem::pbd {

/// Decides which islands one sweep has not solved and sweeps those on: cold starts and tall or
/// unevenly loaded islands need it, what rests on carried impulses does not, and what flies about
/// is not worth it. Nor is a heap that goes on trembling however often it is swept: after a while
/// it is given up, until it is solved without that.
class ContactConvergence {
 public:
  struct Rule {
    int sweeps = 0;        ///< at most, after the first
    double resting = 0.0;  ///< m/s: rms change below which an island is solved
    bool fresh = false;    ///< friction starts anew in this substep
  };

  /// Once per step: how fast the islands move, and which island each place is of.
  void begin_step(std::span<const SolverBody> bodies, const BodyOrder& order,
                  std::span<const ContactRow> rows);
  /// Once per step, after the last sweep.
  void end_step(std::span<const SolverBody> bodies);
  void remove_body(std::uint32_t slot);
  void save(ByteWriter& out) const;
  void load(ByteReader& in);
  /// What the next step depends on, as save() and load() do.
  void assign(const ContactConvergence& source) { unsolved_ = source.unsolved_; }

  /// Sweep what needs it of the places.
  /// @param reverse  the direction of the first sweep
  /// @param changes  m/s, by place: what that sweep changed
  /// Returns the number of rows swept again.
  int run(const Rule& rule, const ContactOrder::Places& places, bool reverse,
          std::span<ContactRow> rows, std::span<double> changes, std::span<SolverBody> bodies);

  /// Whether the island stood when the step began: it pays to solve it well.
  bool stands(std::uint32_t island) const { return !islands_[island].faster_than(kStanding); }
  /// What its last sweep still changed, rms over its rows, m/s; 0 where it moves.
  double unrest(std::uint32_t island) const {
    if (!islands_[island].pays()) return 0.0;
    return std::sqrt(islands_[island].change2 / std::max(1u, islands_[island].rows));
  }
  /// Whether the island was not solved by the first sweep at some time in this step, and is not
  /// given up.
  bool was_hard(std::uint32_t island) const {
    return islands_[island].hard && !islands_[island].given_up();
  }

 private:
  static constexpr double kStanding = 0.5;  ///< m/s, rms
  /// m/s, rms: an island of more than kSmall rows that moves faster is not swept on.
  static constexpr double kAtRest = 0.15;
  static constexpr std::uint32_t kSmall = 100;
  /// Steps that such a large island may stay unsolved before it is given up, and how many more are
  /// counted.
  static constexpr std::uint32_t kPatience = 30;
  static constexpr std::uint32_t kGrudge = 10;

  struct Island {
    double speed2 = 0.0;   ///< m^2/s^2, sum over bodies
    double change2 = 0.0;  ///< m^2/s^2, sum over rows
    std::uint32_t bodies = 0;
    std::uint32_t rows = 0;
    std::uint32_t unsolved = 0;  ///< steps, sum over bodies
    bool hard = false;
    bool open = false;  ///< not solved by all of its sweeps in some substep

    bool pays() const { return worth_it() && !given_up(); }
    bool worth_it() const { return !faster_than(rows > kSmall ? kAtRest : kStanding); }
    bool given_up() const { return rows > kSmall && unsolved >= kPatience * bodies; }
    bool faster_than(double speed) const { return speed2 > speed * speed * bodies; }
  };

  bool is_open(const Rule& rule, const Island& island) const {
    return island.change2 > rule.resting * rule.resting * island.rows;
  }

  std::vector<Island> islands_;           ///< by the index of the island's lowest body
  std::vector<std::uint32_t> island_of_;  ///< by place
  std::vector<std::uint8_t> unsolved_;    ///< by body: steps, of late
  std::vector<std::uint32_t> places_;     ///< of open islands, ascending
};

}  // namespace tandem::pbd
