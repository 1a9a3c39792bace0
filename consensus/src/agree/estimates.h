// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <vector>

#include "agree/votes.h"
#include "members/shared_bodies.h"
#include "tandem/consensus/aggregate.h"
#include "tandem/pbd/pose_target.h"

namespace tandem::consensus {

/// A state of another peer that counts, against the own one of its stamp.
struct Stamped {
  SessionTime stamp = 0;  ///< ns
  pbd::BodyState state;
  bool apart = false;  ///< beyond ReplayOptions::tolerance
};

/// What the others say of one body, in a form that can be averaged.
struct Estimates {
  std::vector<PeerEstimate> states;  ///< taken to be so now
  std::vector<Stamped> stamped;      ///< of `states`; empty where these are carried to now
  std::vector<Claim> claims;         ///< of those who do not own the body and count at all
  std::vector<PeerId> leaders;
  /// States of owners that a replay takes as they are.
  std::vector<Stamped> prescribed;
  pbd::TargetMotion motion = pbd::TargetMotion::WithBody;
  bool votes = false;  ///< `states` are to be fused as votes
  /// A hand that only its own peer knows moves the body: where it is now has to be guessed.
  bool by_hand = false;

  /// Those of which the test says so, and what belongs to them.
  template <class Test>
  void keep(Test test) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < states.size(); ++i) {
      if (!test(states[i])) continue;
      states[kept] = states[i];
      stamped[kept++] = stamped[i];
    }
    states.resize(kept);
    stamped.resize(kept);
  }
  void clear() {
    states.clear();
    stamped.clear();
    claims.clear();
    leaders.clear();
    prescribed.clear();
    motion = pbd::TargetMotion::WithBody;
    votes = by_hand = false;
  }
};

/// What agreement wants of one body.
struct Wanted {
  SharedBody* shared = nullptr;
  unsigned placed = 0;                  ///< of `shared`, when the others were compared with it
  PeerId heaviest = 0;                  ///< who has the most say in it
  bool replayed = false;                ///< where it is to be is the replay's to say
  SessionTime oldest = 0;               ///< ns, stamp of the oldest news
  pbd::Vec3 asked = pbd::Vec3::Zero();  ///< m, in the last step
  pbd::PoseTarget target;
};

}  // namespace tandem::consensus
