// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "part.h"
#include "ranks.h"
#include "tandem/pbd/constraint.h"

namespace tandem::mpi {

/// The one of two ranks that solves the contacts between them. It alternates between even and odd
/// sums, so that no rank solves all of its borders.
inline int solver_of(int one, int other) {
  return (one + other) % 2 == 0 ? std::min(one, other) : std::max(one, other);
}

/// Which neighbours take part in an exchange.
enum class With : std::uint8_t { All, WhoDisplaces };

/// This rank's relation to another one.
struct Neighbour {
  int rank = 0;
  /// Bodies copied from one of the two ranks to the other, by slot here, in an order known to both:
  /// copies of its bodies if this rank solves the contacts in between, else own bodies.
  std::vector<std::uint32_t> bodies;
  /// For own bodies: the other rank knows that they are asleep, and their pose.
  std::vector<std::uint8_t> told_asleep;
  /// Those touched by contacts between the two ranks in this step.
  std::vector<std::uint32_t> touched;
  bool solves = false;     ///< whether this rank solves
  bool displaces = false;  ///< whether targets may press one's bodies on the other's in this step

  bool takes_part(With with) const { return with == With::All || displaces; }
};

/// Decides which bodies are copied to which rank, and keeps copies up to date.
class Neighbours {
 public:
  Neighbours(Part& part, Ranks& ranks, int refresh_every)
      : part_(part), ranks_(ranks), refresh_every_(refresh_every) {}

  std::vector<Neighbour>& all() { return all_; }
  std::size_t copy_count() const;

  /// Search anew for bodies that may touch another rank's within the next steps of dt (s).
  /// @param carried  contacts of the last step that may continue between other ranks
  void refresh(double dt, std::vector<NamedContact>& carried);
  /// Drop all copies.
  void clear();
  /// Call before a step: poses and twists from the owners.
  void update();
  /// Call at the end of a step, with the final bodies.
  void note_motion(std::span<const pbd::SolverBody> bodies);
  /// Whether an own body has left the box for which refresh() searched.
  bool outdated() const { return outdated_; }
  /// A body has come outside of any such box.
  void expect_new() { outdated_ = true; }

 private:
  struct Box {
    pbd::Vec3 min = pbd::Vec3::Zero();
    pbd::Vec3 max = pbd::Vec3::Zero();
    bool meets(const Box& other) const {
      return (min.array() <= other.max.array()).all() && (other.min.array() <= max.array()).all();
    }
  };
  struct Candidate {
    BodyName name = 0;
    Box box;
  };

  void set_boxes(double dt);
  std::vector<Box> gather_bounds();
  /// The candidates that an own body may touch.
  std::vector<std::uint8_t> find_wanted(const std::vector<Candidate>& candidates) const;
  void offer(int to, const Box& theirs);
  void answer(int from);
  void lend(Neighbour& neighbour, const std::vector<NamedContact>& carried);
  void borrow(Neighbour& neighbour, std::vector<NamedContact>& carried);

  Part& part_;
  Ranks& ranks_;
  int refresh_every_;
  bool outdated_ = false;
  std::vector<Neighbour> all_;  ///< by rank
  std::vector<Box> boxes_;      ///< by slot: bounds of an own body until the next refresh()
};

}  // namespace tandem::mpi
