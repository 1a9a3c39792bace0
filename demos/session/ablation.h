// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <bitset>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "session/physics.h"
#include "tandem/consensus/peer.h"
#include "tandem/pbd/pose_target.h"

namespace tandem::demos {

/// A part of the agreement that can be switched off to measure its effect.
enum class Part : std::uint8_t {
  Channels,    ///< the displacement channel: without it corrections become velocity
  Velocities,  ///< agreement of velocities: without it targets have the local body's velocity
  Initiative,  ///< the last user to act leads
  Leading,     ///< a leader's higher share, without its lead
};
inline constexpr std::size_t kParts = 4;
std::string_view to_string(Part part);

/// The parts that a run omits.
class Ablation {
 public:
  bool lacks(Part part) const { return parts_.test(static_cast<std::size_t>(part)); }
  bool any() const { return parts_.any(); }
  void leave_out(Part part) { parts_.set(static_cast<std::size_t>(part)); }

  void apply(consensus::PeerOptions& options) const;
  /// Wraps the physics to omit Part::Channels.
  std::unique_ptr<Physics> around(std::unique_ptr<Physics> physics) const;
  /// A source that replaces `source`, which must outlive it; null if targets are complete.
  std::unique_ptr<pbd::TargetSource> around(pbd::TargetSource& source) const;

 private:
  std::bitset<kParts> parts_;
};

}  // namespace tandem::demos
