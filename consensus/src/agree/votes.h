// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "tandem/consensus/transport.h"
#include "tandem/pbd/pose_target.h"
#include "tandem/pbd/types.h"

/// Rules for three or more peers' states of a body: how much each counts, who gives way, who leads.
namespace tandem::consensus {

/// A state of a body relative to the local one, as 12 components in metres: translation,
/// displacement by the rotation at kLever, and displacement by both velocities within kHorizon.
using StateOffset = std::array<double, 12>;

inline constexpr double kLever = 0.3;    ///< m
inline constexpr double kHorizon = 0.1;  ///< s

StateOffset offset_of(const pbd::Correction& apart);

/// One peer's vote on a body's state.
struct Vote {
  StateOffset at = {};
  double weight = 0.0;   ///< >= 0
  double cost = 0.0;     ///< set: sum of weighted distances to all votes
  double central = 0.0;  ///< set: 1 at the least cost, 0 from periphery() times that cost
};

/// A vote counts fully up to `full` times the cost of the best one, and not at all from `none`
/// times.
struct Periphery {
  double full = 1.05;
  double none = 1.18;
};
/// Three votes in a row are all accepted: they may be neighbours in a long chain.
constexpr Periphery periphery(std::size_t votes) {
  return votes > 3 ? Periphery{} : Periphery{.full = 1.7, .none = 1.85};
}

/// Compute how central each vote is from its distances to all, linearly between the bounds of
/// periphery(). A vote is not excluded because others are few or far apart: of two clusters of
/// equal weight both count, and so do three votes far apart. Invariant under motion of all votes
/// together. docs/protocol.md ("Who is believed") has its limits. Cost O(N^2), no allocation.
void weigh_centrality(std::span<Vote> votes);

/// Another peer's pose of a body relative to the local one: m, rad, or both in metres.
struct Claim {
  PeerId peer = 0;
  pbd::Vec3 way = pbd::Vec3::Zero();
  pbd::Vec3 turn = pbd::Vec3::Zero();
};

/// Decides who gives way if no average makes sense: the minority, and of equal sides the one
/// without the lowest id; so of two peers the higher id. All who see the same states decide alike.
/// A peer within half of the distance from one of the two is on its side.
/// @return whether this peer gives way to claims[i]
bool outvoted(std::span<const Claim> claims, std::size_t i, PeerId self);

/// Which peers' claims to lead a body are founded: those that hold it, or released it lately.
class LeadClaims {
 public:
  /// @param holds  that peer acts on the body now, as far as is known here
  /// @return whether the claim is believed
  bool founded(PeerId peer, bool holds, SessionTime now);

 private:
  /// ns: longer than any throw flies.
  static constexpr SessionTime kLongest = 5'000'000'000;
  std::vector<std::pair<PeerId, SessionTime>> held_;
};

}  // namespace tandem::consensus
