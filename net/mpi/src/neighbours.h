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

/// Of two ranks, the one that solves the contacts between them. Odd sums and even ones take turns,
/// so that no rank solves all of its borders.
inline int solver_of(int one, int other) {
  return (one + other) % 2 == 0 ? std::min(one, other) : std::max(one, other);
}

/// Which neighbours are exchanged with.
enum class With : std::uint8_t { All, WhoDisplaces };

/// What this rank has to do with another one.
struct Neighbour {
  int rank = 0;
  /// Bodies that one of the two knows copies of, by slot here, in an order that both know: copies
  /// of its bodies here where this rank solves what is between them, else own bodies.
  std::vector<std::uint32_t> bodies;
  /// Beside them, where they are own: the other rank knows it as asleep, and where it is.
  std::vector<std::uint8_t> told_asleep;
  /// In this step: those of them that a contact between the two touches.
  std::vector<std::uint32_t> touched;
  bool solves = false;     ///< this rank does
  bool displaces = false;  ///< in this step targets may press one's bodies on the other's

  bool takes_part(With with) const { return with == With::All || displaces; }
};

/// Which bodies are copied where, and that copies are as their owners have them.
class Neighbours {
 public:
  Neighbours(Part& part, Ranks& ranks, int refresh_every)
      : part_(part), ranks_(ranks), refresh_every_(refresh_every) {}

  std::vector<Neighbour>& all() { return all_; }
  std::size_t copy_count() const;

  /// Look anew for bodies that may touch another rank's within the next steps of dt (s).
  /// @param carried  contacts of the last step that may go on between other ranks
  void refresh(double dt, std::vector<NamedContact>& carried);
  /// Forget all copies.
  void clear();
  /// Before a step: poses and twists from the owners.
  void update();
  /// At the end of a step, with the bodies as they are then.
  void note_motion(std::span<const pbd::SolverBody> bodies);
  /// Whether some own body has left the room for which refresh() looked.
  bool outdated() const { return outdated_; }
  /// A body has come, in no room that was foreseen.
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
  /// Which of the candidates an own body may touch.
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
  std::vector<Box> boxes_;      ///< by slot: where an own body may be until the next refresh()
};

}  // namespace tandem::mpi
