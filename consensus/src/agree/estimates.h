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

/// A remote state that counts, relative to the local state at its stamp.
struct Stamped {
  SessionTime stamp = 0;  ///< ns
  pbd::BodyState state;
  bool apart = false;  ///< beyond ReplayOptions::tolerance
};

/// The peers' states of one body, in a form that can be averaged.
struct Estimates {
  std::vector<PeerEstimate> states;  ///< as estimated for now
  std::vector<Stamped> stamped;      ///< of `states`; empty if those were extrapolated to now
  std::vector<Claim> claims;         ///< of peers that do not own the body and have a share
  std::vector<PeerId> leaders;
  /// Owners' states that a replay takes over unchanged.
  std::vector<Stamped> prescribed;
  pbd::TargetMotion motion = pbd::TargetMotion::WithBody;
  bool votes = false;  ///< `states` are fused as votes
  /// A hand that only its own peer knows moves the body: its present pose has to be extrapolated.
  bool by_hand = false;

  /// Keep the states that pass the test, and their stamped counterparts.
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

/// The target that agreement wants for one body.
struct Wanted {
  SharedBody* shared = nullptr;
  unsigned placed = 0;                  ///< of `shared`, when the states were compared with it
  PeerId heaviest = 0;                  ///< the peer with the largest share
  bool replayed = false;                ///< the replay determines the pose
  SessionTime oldest = 0;               ///< ns, oldest stamp used
  pbd::Vec3 asked = pbd::Vec3::Zero();  ///< m, correction of the last step
  pbd::PoseTarget target;
};

}  // namespace tandem::consensus
