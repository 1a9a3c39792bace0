// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "agree/latecomers.h"
#include "agree/trust.h"
#include "peer_data.h"

namespace tandem::consensus {

/// Who acts on which body in a step, what touches it and what joints hold it to, and what follows
/// from that for who has the initiative.
class Activity {
 public:
  // Beside Springs::Grip, what touched a body in the last step.
  static constexpr std::uint8_t kTouchedByOwn = 8;     ///< a body that this peer owns, or its act
  static constexpr std::uint8_t kTouchedByOther = 16;  ///< one that another peer owns, or its act
  static constexpr std::uint8_t kTouched = 32;         ///< any
  static constexpr std::uint8_t kJoinedToOther = 64;   ///< something that another's user acts on

  Activity(PeerData& data, Trust& trust, const Latecomers& latecomers)
      : data_(data), trust_(trust), latecomers_(latecomers) {}

  /// Two bodies pushed each other in the step of another engine.
  void note_contact(pbd::BodyId a, pbd::BodyId b);
  /// A step has been made: look at the whole world.
  void look();
  /// The same of one body: what touches and holds it, and who has the initiative.
  void look_at(SharedBody& shared, std::span<const Inbox::Received> newest);

  /// Springs::Grip and the above, of a slot; 0 of one that was not there at the last look.
  std::uint8_t bits(std::uint32_t slot) const {
    return slot < acting_.size() ? acting_[slot] : std::uint8_t{0};
  }
  /// Pairs of slots of bodies that move and that joints hold to each other.
  std::span<const std::pair<std::uint32_t, std::uint32_t>> joined() const { return joined_; }

 private:
  void mark_joints();
  void mark_acting();
  void mark_noted_contacts();
  /// Who acts on a body acts on all that joints hold to it.
  void spread_acting();
  void note_grip(SharedBody& shared) const;
  void update_initiative(SharedBody& shared, std::span<const Inbox::Received> newest);

  PeerData& data_;
  Trust& trust_;
  const Latecomers& latecomers_;
  std::vector<pbd::ConstraintEdge> edges_;  ///< of joints and springs
  /// By slot: a joint or a spring, not a contact, holds it to another body or to the world.
  std::vector<std::uint8_t> jointed_;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> joined_;
  std::vector<std::uint8_t> acting_;    ///< by slot
  std::vector<std::uint8_t> touching_;  ///< by slot, what a body is for those that touch it
  /// Slots of a body and of what pushed it in the last step of another engine.
  std::vector<std::pair<std::uint32_t, std::uint32_t>> noted_contacts_;
};

}  // namespace tandem::consensus
