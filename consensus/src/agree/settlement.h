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

/// Ends disagreements between copies that rest. A mean exists only within one well: halfway between
/// two resting poses a body need not rest at all, and averaging keeps lifting a body that falls
/// back. So for each island (all bodies that touch or are jointed) one peer's copy is elected. That
/// peer stops listening and comes to rest; the others take over its island as a whole.
/// docs/method.md ("Between wells an election").
class Settlement {
 public:
  Settlement(PeerData& data, Trust& trust, const Latecomers& latecomers, const Activity& activity,
             Placement& placement)
      : data_(data),
        trust_(trust),
        latecomers_(latecomers),
        activity_(activity),
        placement_(placement) {}

  /// Call before a step, after packets were received. Sets SharedBody::stands.
  void settle();

 private:
  /// One peer's copy of a body, and how long it has stayed near one place.
  struct Copy {
    PeerId peer = 0;
    pbd::Pose about = {};   ///< average of its recent poses
    SessionTime since = 0;  ///< ns, when it came near there; 0 = unknown
  };
  /// State of a shared body, in the order of PeerData::bodies.
  struct Body {
    pbd::BodyId id = {};
    std::vector<Copy> copies = {};  ///< the local one first, then those that count
    double gap = 0.0;               ///< m, to the furthest copy
    /// m, the largest gap of its island: motion within it is due to agreement alone.
    double slack = 0.0;
    SessionTime touched = 0;   ///< ns, when it last touched something
    SessionTime together = 0;  ///< ns, since when all copies are together; 0 = one is apart
    bool free = false;         ///< nobody acts on it
    PeerId elected = 0;
    SessionTime elected_since = 0;  ///< ns
    /// The pose last taken over; one that did not last is not tried for ever.
    pbd::Pose taken_pose = {};
    SessionTime taken_at = 0;  ///< ns; 0 = never, or somebody has acted on the body since
    int tries = 0;
    std::uint64_t trial = 0;  ///< number of a takeover that was not examined yet; 0 = none
    bool asleep = false;      ///< whether it slept at the elected peer's
    bool misplaced = false;   ///< whether it overlaps a body that was not taken over with it
    pbd::Pose before = {};    ///< pose before the takeover

    void forget_times();
  };
  struct Candidate {
    PeerId peer = 0;
    double cost = 0.0;  ///< m, sum of distances to all others
  };

  /// Update bodies_ to those of PeerData::bodies.
  void find_bodies();
  void look_at(std::size_t index);
  void find_islands();
  /// Whether that peer's state of a body counts here.
  bool counts(const Inbox::Received& received) const;
  std::uint32_t root_of(std::uint32_t slot);
  void settle_island();
  /// The peer whose copies the island takes over; 0 = none.
  PeerId elect();
  void follow(PeerId elected);
  bool may_take_over(PeerId elected, bool asleep) const;
  /// Place the island where that peer has it, asleep, so that nothing is solved before it is
  /// examined.
  void take_over(PeerId elected, bool asleep);
  /// Put an island back if part of it has no support here, or overlaps something.
  void look_at_taken();
  bool moves(std::uint32_t slot) const;
  void join(std::uint32_t a, std::uint32_t b);
  bool rests(const Body& body, PeerId peer) const;
  /// A peer's newest state of a body; null if there is none.
  const Inbox::Received* said(std::size_t index, PeerId peer) const;
  /// Poses of that peer's copy, and of the local one at its stamp.
  pbd::Pose pose_of(std::size_t index, const Inbox::Received& received) const;
  pbd::Pose own_at(std::size_t index, const Inbox::Received& received) const;
  /// m, distance between two peers' copies.
  double apart(std::size_t index, PeerId a, PeerId b) const;

  PeerData& data_;
  Trust& trust_;
  const Latecomers& latecomers_;
  const Activity& activity_;
  Placement& placement_;
  SessionTime looked_ = 0;  ///< ns
  std::uint64_t trials_ = 0;
  std::vector<Body> bodies_;
  std::vector<std::uint32_t> parents_;                          ///< by slot, union-find of islands
  std::vector<std::size_t> in_slot_;                            ///< index into bodies_, by slot
  std::vector<std::pair<std::uint32_t, std::size_t>> islands_;  ///< roots and bodies
  std::vector<std::size_t> members_;                            ///< of the current island
  std::vector<Candidate> candidates_;
  std::vector<std::uint64_t> misplaced_;  ///< takeovers with an overlap
  std::vector<std::uint64_t> acted_on_;   ///< takeovers whose body was acted on since
};

}  // namespace tandem::consensus
