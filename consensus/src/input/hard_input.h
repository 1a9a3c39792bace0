// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <span>
#include <vector>

#include "input/springs.h"
#include "tandem/consensus/aggregate.h"
#include "tandem/pbd/body.h"

namespace tandem::consensus {

struct PeerData;
struct SharedBody;

/// A body in this peer's hands, [friston] Sec. 4.3: what is sent does not depend on the solver.
struct HardInput {
  bool active = false;
  pbd::BodyState own;    ///< this user's own state of the body, which is sent
  pbd::BodyState shown;  ///< the mean over all users' states
};

/// The pose nearest to `pose` in the body's mass metric that brings the attachments to the hands:
/// one hand moves and swings a body, two turn it. `pose` itself if the body is not dynamic.
pbd::Pose dragged(const pbd::BodyProps& props, const pbd::Pose& pose,
                  std::span<const Springs::Hand> hands);

/// This peer's bodies in hard mode.
class HardInputs {
 public:
  explicit HardInputs(PeerData& data) : data_(data) {}

  /// Call before a step. @param others  reduced to the states of users
  /// @return whether the body is in this user's hands
  bool drag(SharedBody& shared, std::vector<PeerEstimate>& others);
  /// After a step of `dt` s, undo its effect on the body: physics does not act on it, [friston]
  /// Fig. 2.
  void carry_on(SharedBody& shared, double dt);

 private:
  PeerData& data_;
  std::vector<Springs::Hand> hands_;
};

}  // namespace tandem::consensus
