// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "agree/latecomers.h"
#include "agree/placement.h"
#include "agree/trust.h"
#include "input/activity.h"
#include "peer_data.h"

namespace tandem::consensus {

/// Ends disagreements between copies that rest. A mean exists within one well: halfway between two
/// ways to lie a body need not lie at all, and averaging lifts what falls back for ever. So of each
/// island (all that touches or is jointed) one peer's copy is elected, which stops listening and
/// comes to rest; the others take it over as a whole. docs/method.md ("Between wells an election").
class Settlement {
 public:
  Settlement(PeerData& data, Trust& trust, const Latecomers& latecomers, const Activity& activity,
             Placement& placement)
      : data_(data),
        trust_(trust),
        latecomers_(latecomers),
        activity_(activity),
        placement_(placement) {}

  /// Before a step, once the news is in. Sets SharedBody::stands.
  void settle();

 private:
  /// One peer's copy of a body, and how long it has stayed about there.
  struct Copy {
    PeerId peer = 0;
    pbd::Pose about = {};   ///< where it has been lately, on average
    SessionTime since = 0;  ///< ns, that it has been near there; 0 = not known
  };
  /// What is known of a shared body, in the order of PeerData::bodies.
  struct Body {
    pbd::BodyId id = {};
    std::vector<Copy> copies = {};  ///< the own one first, then those of whose word counts
    double gap = 0.0;               ///< m, to the copy that is furthest away
    /// m, the largest gap of its island: what moves within it is moved by agreement alone.
    double slack = 0.0;
    SessionTime touched = 0;   ///< ns, when it was last beside something
    SessionTime together = 0;  ///< ns, since when no copy is apart; 0 = one is
    bool free = false;         ///< nobody acts on it
    PeerId elected = 0;
    SessionTime elected_since = 0;  ///< ns
    /// What was last taken over; where that did not last it is not tried for ever.
    pbd::Pose taken_pose = {};
    SessionTime taken_at = 0;  ///< ns; 0: never, or somebody has acted on it since
    int tries = 0;
    std::uint64_t trial = 0;  ///< taken over with others, and not looked at since; 0 = it is not
    bool asleep = false;      ///< it slept at the elected peer's
    bool misplaced = false;   ///< it overlaps what was not taken over with it
    pbd::Pose before = {};    ///< where it was

    void forget_times();
  };
  struct Candidate {
    PeerId peer = 0;
    double cost = 0.0;  ///< m, sum of distances to all others
  };

  /// Into bodies_, as they are in PeerData::bodies now.
  void find_bodies();
  void look_at(std::size_t index);
  void find_islands();
  /// Whether what that peer says of a body counts here.
  bool counts(const Inbox::Received& received) const;
  std::uint32_t root_of(std::uint32_t slot);
  void settle_island();
  /// The peer whose copies the island is to take; 0 where none is elected.
  PeerId elect();
  void follow(PeerId elected);
  bool may_take_over(PeerId elected, bool asleep) const;
  /// Put the island where that peer has it, asleep, so that nothing is solved before it was looked
  /// at.
  void take_over(PeerId elected, bool asleep);
  /// Put back what was taken over where some of it lies on nothing here, or within something.
  void look_at_taken();
  bool moves(std::uint32_t slot) const;
  void join(std::uint32_t a, std::uint32_t b);
  bool rests(const Body& body, PeerId peer) const;
  /// What a peer has said of a body; null where it has said nothing.
  const Inbox::Received* said(std::size_t index, PeerId peer) const;
  /// Where that peer's copy is, and where the own one was then.
  pbd::Pose pose_of(std::size_t index, const Inbox::Received& received) const;
  pbd::Pose own_at(std::size_t index, const Inbox::Received& received) const;
  /// m, between two peers' copies.
  double apart(std::size_t index, PeerId a, PeerId b) const;

  PeerData& data_;
  Trust& trust_;
  const Latecomers& latecomers_;
  const Activity& activity_;
  Placement& placement_;
  SessionTime looked_ = 0;  ///< ns
  std::uint64_t trials_ = 0;
  std::vector<Body> bodies_;
  std::vector<std::uint32_t> parents_;                          ///< by slot, of islands
  std::vector<std::size_t> in_slot_;                            ///< which of bodies_
  std::vector<std::pair<std::uint32_t, std::size_t>> islands_;  ///< roots and bodies
  std::vector<std::size_t> members_;                            ///< of the one that is looked at
  std::vector<Candidate> candidates_;
  std::vector<std::uint64_t> misplaced_;  ///< trials
  std::vector<std::uint64_t> acted_on_;   ///< trials
};

}  // namespace tandem::consensus
