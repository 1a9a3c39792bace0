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

/// A part of the agreement that can be left out to see what it is worth.
enum class Part : std::uint8_t {
  Channels,    ///< the displacement channel: what agreement moves becomes velocity as well
  Velocities,  ///< agreement of velocities: targets move as the body here does
  Initiative,  ///< who acted last leads
  Leading,     ///< a leader's higher share, but not that it leads
};
inline constexpr std::size_t kParts = 4;
std::string_view to_string(Part part);

/// The parts that a run does without.
class Ablation {
 public:
  bool lacks(Part part) const { return parts_.test(static_cast<std::size_t>(part)); }
  bool any() const { return parts_.any(); }
  void leave_out(Part part) { parts_.set(static_cast<std::size_t>(part)); }

  void apply(consensus::PeerOptions& options) const;
  /// The physics, or what leaves Part::Channels out around it.
  std::unique_ptr<Physics> around(std::unique_ptr<Physics> physics) const;
  /// A source to be asked in place of `source`, which must outlive it; null where nothing is left
  /// out of targets.
  std::unique_ptr<pbd::TargetSource> around(pbd::TargetSource& source) const;

 private:
  std::bitset<kParts> parts_;
};

}  // namespace tandem::demos
