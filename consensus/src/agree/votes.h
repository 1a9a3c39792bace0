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

/// What three and more peers say of a body: how much each counts, who gives way, who leads.
namespace tandem::consensus {

/// A state of a body as seen from the local one, in metres: its 12 components are the way, what the
/// rotation moves at kLever, and what velocities do to both in kHorizon.
using StateOffset = std::array<double, 12>;

inline constexpr double kLever = 0.3;    ///< m
inline constexpr double kHorizon = 0.1;  ///< s

StateOffset offset_of(const pbd::Correction& apart);

/// What one peer says of a body.
struct Vote {
  StateOffset at = {};
  double weight = 0.0;   ///< >= 0
  double cost = 0.0;     ///< set: sum of weighted distances to all votes
  double central = 0.0;  ///< set: 1 for the vote of the least cost, 0 from periphery() times that
};

/// A vote counts in full up to `full` times the cost of the best one, and nothing from `none` times
/// that on.
struct Periphery {
  double full = 1.05;
  double none = 1.18;
};
/// Of three votes in a row none is outside: they may be neighbours in a chain of many.
constexpr Periphery periphery(std::size_t votes) {
  return votes > 3 ? Periphery{} : Periphery{.full = 1.7, .none = 1.85};
}

/// How much each vote counts beside the others, by how far it is to all of them from there; in
/// between on a line. No vote is outside because the others are few or far apart: of two clusters
/// of the same weight both count, of three votes far apart all. Votes that are moved or turned
/// together count the same. docs/protocol.md ("Who is believed") says what it is worth. Cost
/// O(N^2), no allocation.
void weigh_centrality(std::span<Vote> votes);

/// Where another peer has a body, as seen from where it is here: m, rad, or both in metres.
struct Claim {
  PeerId peer = 0;
  pbd::Vec3 way = pbd::Vec3::Zero();
  pbd::Vec3 turn = pbd::Vec3::Zero();
};

/// Who gives way where no average makes sense: those who are fewer, and of equally many those
/// without the lowest id; so of two peers the higher id. All who see the same states come to the
/// same. Whoever is within half of the distance between two of them is on that one's side.
/// @return whether this peer gives way to claims[i]
bool outvoted(std::span<const Claim> claims, std::size_t i, PeerId self);

/// Who leads a body with a reason: those who hold it, or have let go of it lately.
class LeadClaims {
 public:
  /// @param holds  that peer acts on the body now, as far as is known here
  /// @return whether it is believed that it leads
  bool founded(PeerId peer, bool holds, SessionTime now);

 private:
  /// ns: longer than anything flies that was thrown.
  static constexpr SessionTime kLongest = 5'000'000'000;
  std::vector<std::pair<PeerId, SessionTime>> held_;
};

}  // namespace tandem::consensus
