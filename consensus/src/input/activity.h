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

/// Who acts on each body in a step, what touches it, what joints connect it to, and who has the
/// initiative as a result.
class Activity {
 public:
  // In addition to Springs::Grip: what touched a body in the last step.
  static constexpr std::uint8_t kTouchedByOwn = 8;     ///< a body that this peer owns, or its act
  static constexpr std::uint8_t kTouchedByOther = 16;  ///< another peer's body, or its act
  static constexpr std::uint8_t kTouched = 32;         ///< any body
  static constexpr std::uint8_t kJoinedToOther = 64;   ///< jointed to another user's body

  Activity(PeerData& data, Trust& trust, const Latecomers& latecomers)
      : data_(data), trust_(trust), latecomers_(latecomers) {}

  /// Two bodies pushed each other in a step of another engine.
  void note_contact(pbd::BodyId a, pbd::BodyId b);
  /// Call after a step: examines the whole world.
  void look();
  /// Examine one body: its contacts and joints, and who has the initiative.
  void look_at(SharedBody& shared, std::span<const Inbox::Received> newest);

  /// Springs::Grip and the above, of a slot; 0 if it was empty at the last look().
  std::uint8_t bits(std::uint32_t slot) const {
    return slot < acting_.size() ? acting_[slot] : std::uint8_t{0};
  }
  /// Pairs of slots of moving bodies that joints connect.
  std::span<const std::pair<std::uint32_t, std::uint32_t>> joined() const { return joined_; }

 private:
  void mark_joints();
  void mark_acting();
  void mark_noted_contacts();
  /// An act on a body is an act on all that joints connect to it.
  void spread_acting();
  void note_grip(SharedBody& shared) const;
  void update_initiative(SharedBody& shared, std::span<const Inbox::Received> newest);

  PeerData& data_;
  Trust& trust_;
  const Latecomers& latecomers_;
  std::vector<pbd::ConstraintEdge> edges_;  ///< of joints and springs
  /// By slot: a joint or a spring, not a contact, connects it to another body or to the world.
  std::vector<std::uint8_t> jointed_;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> joined_;
  std::vector<std::uint8_t> acting_;    ///< by slot
  std::vector<std::uint8_t> touching_;  ///< by slot, the bits that a body gives to those it touches
  /// Slots of bodies that pushed each other in the last step of another engine.
  std::vector<std::pair<std::uint32_t, std::uint32_t>> noted_contacts_;
};

}  // namespace tandem::consensus
