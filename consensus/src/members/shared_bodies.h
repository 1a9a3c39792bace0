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

/// What the predictor keeps of another peer's states of one body.
struct Heard {
  PeerId peer = 0;
  SessionTime last = 0;  ///< ns, when the last one was used
  PredictorMemory memory;
};

/// Who owns a body that passes from owner to owner, as far as is known here: see Ownership.
struct Tenure {
  PeerId owner = 0;       ///< 0 = nobody
  SessionTime since = 0;  ///< ns, stamp of the last grant: earlier claims are old news
  SessionTime heard = 0;  ///< ns, when somebody was last heard to own it; 0 = never asked
  SessionTime began = 0;  ///< ns, when the own user began to act; 0 = has not asked for it
  SessionTime acted = 0;  ///< ns, when the own user last did
  SessionTime asked = 0;  ///< ns
};

/// One body that is shared, and what the stages keep of it from step to step.
struct SharedBody {
  /// States that tell of a jump, for some of them get lost.
  static constexpr int kJumpTold = 3;
  static constexpr std::uint32_t kNoIndex = 0xffffffff;

  ShareDef def;
  bool held = false;
  bool coupled = false;    ///< held, joined to something or touched by it
  bool stands = false;     ///< it has been elected, or what was is taken over: it hears nobody
  bool joined = false;     ///< taken over from an established peer, as a newcomer does once
  int jumped = 0;          ///< states still to be sent that tell of a jump
  unsigned placed = 0;     ///< times that it was put somewhere
  SessionTime landed = 0;  ///< ns, stamp of the owner's last jump that was followed
  Initiative initiative = {};
  LeadClaims lead_claims = {};
  std::vector<Heard> heard = {};  ///< by peer; empty where the predictor does not remember
  HardInput hard = {};
  Tenure tenure = {};
  pbd::Correction averaged = {};        ///< before the step, where the pass does not do it
  double still = 0.0;                   ///< s, at rest and in agreement, see rests()
  std::uint32_t index = kNoIndex;       ///< what the outbox calls it
  pbd::Pose rest_pose = {};             ///< where it has been, about, since rest_since
  SessionTime rest_since = 0;           ///< ns; 0 = it moves
  pbd::Vec3 asked = pbd::Vec3::Zero();  ///< m, what agreement wanted of this step
};

/// Which bodies are shared, by ascending id, as the inbox has them.
class SharedBodies {
 public:
  explicit SharedBodies(const pbd::World& world) : world_(world) {}

  /// @param most  bodies that there may be @throws std::invalid_argument as Peer::share
  SharedBody& add(const ShareDef& def, std::size_t most);
  void remove(SharedBody& body);
  void set_owner(SharedBody& body, std::optional<PeerId> owner);

  /// Null where it is not shared.
  SharedBody* find(const SharedId& id);
  /// @throws std::invalid_argument where it is not shared
  SharedBody& at(const SharedId& id);
  std::size_t index_of(const SharedBody& body) const {
    return static_cast<std::size_t>(&body - bodies_.data());
  }
  SharedBody& operator[](std::size_t index) { return bodies_[index]; }
  std::size_t size() const { return bodies_.size(); }
  auto begin() { return bodies_.begin(); }
  auto end() { return bodies_.end(); }

  /// Whether any body has an owner, and whether that peer owns one.
  bool have_owners() const { return !owners_.empty(); }
  bool owns_any(PeerId peer) const;

 private:
  /// A body comes to an owner, or goes from one; nullopt is nobody.
  void count_owner(std::optional<PeerId> owner, bool comes);

  const pbd::World& world_;
  std::vector<SharedBody> bodies_;
  std::vector<std::pair<PeerId, std::size_t>> owners_;  ///< by id, with the number of their bodies
};

}  // namespace tandem::consensus
