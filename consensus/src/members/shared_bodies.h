// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "agree/votes.h"
#include "input/hard_input.h"
#include "input/initiative.h"
#include "tandem/consensus/peer.h"
#include "tandem/pbd/world.h"

namespace tandem::consensus {

/// A predictor's memory of another peer's states of one body.
struct Heard {
  PeerId peer = 0;
  SessionTime last = 0;  ///< ns, when a state was last used
  PredictorMemory memory;
};

/// Ownership of a body that passes from owner to owner, as far as is known here: see Ownership.
struct Tenure {
  PeerId owner = 0;       ///< 0 = nobody
  SessionTime since = 0;  ///< ns, stamp of the last grant: earlier claims are outdated
  SessionTime heard = 0;  ///< ns, when a peer last claimed to own it; 0 = never asked
  SessionTime began = 0;  ///< ns, when this peer's user began to act; 0 = has not requested it
  SessionTime acted = 0;  ///< ns, when this peer's user last acted
  SessionTime asked = 0;  ///< ns
};

/// A shared body, and what the stages store for it between steps.
struct SharedBody {
  /// Number of states that announce a jump, as some get lost.
  static constexpr int kJumpTold = 3;
  static constexpr std::uint32_t kNoIndex = 0xffffffff;

  ShareDef def;
  bool held = false;
  bool coupled = false;    ///< held, joined to something or touched by it
  bool stands = false;     ///< elected, or its elected copy is being taken over: it ignores others
  bool joined = false;     ///< a newcomer's first state was taken over from an established peer
  int jumped = 0;          ///< states still to be sent that announce a jump
  unsigned placed = 0;     ///< number of times it was placed
  SessionTime landed = 0;  ///< ns, stamp of the owner's last jump that was followed
  Initiative initiative = {};
  LeadClaims lead_claims = {};
  std::vector<Heard> heard = {};  ///< by peer; empty if the predictor has no memory
  HardInput hard = {};
  Tenure tenure = {};
  pbd::Correction averaged = {};        ///< correction before the step, outside of the pass
  double still = 0.0;                   ///< s, at rest and in agreement, see rests()
  std::uint32_t index = kNoIndex;       ///< the outbox's index
  pbd::Pose rest_pose = {};             ///< approximate pose since rest_since
  SessionTime rest_since = 0;           ///< ns; 0 = moving
  pbd::Vec3 asked = pbd::Vec3::Zero();  ///< m, correction that agreement wanted in this step
};

/// The shared bodies by ascending id, in the order of the inbox.
class SharedBodies {
 public:
  explicit SharedBodies(const pbd::World& world) : world_(world) {}

  /// @param most  largest number of bodies @throws std::invalid_argument as Peer::share
  SharedBody& add(const ShareDef& def, std::size_t most);
  void remove(SharedBody& body);
  void set_owner(SharedBody& body, std::optional<PeerId> owner);

  /// Null if it is not shared.
  SharedBody* find(const SharedId& id);
  /// @throws std::invalid_argument if it is not shared
  SharedBody& at(const SharedId& id);
  std::size_t index_of(const SharedBody& body) const {
    return static_cast<std::size_t>(&body - bodies_.data());
  }
  SharedBody& operator[](std::size_t index) { return bodies_[index]; }
  std::size_t size() const { return bodies_.size(); }
  auto begin() { return bodies_.begin(); }
  auto end() { return bodies_.end(); }

  /// Whether any body has an owner, and whether `peer` owns one.
  bool have_owners() const { return !owners_.empty(); }
  bool owns_any(PeerId peer) const;

 private:
  /// Count a body that gains or loses an owner; nullopt = none.
  void count_owner(std::optional<PeerId> owner, bool comes);

  const pbd::World& world_;
  std::vector<SharedBody> bodies_;
  std::vector<std::pair<PeerId, std::size_t>> owners_;  ///< by id, with the number of their bodies
};

}  // namespace tandem::consensus
