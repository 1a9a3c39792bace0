// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <span>

#include "springs.h"
#include "tandem/pbd/body.h"

namespace tandem::consensus {

/// A body in this peer's hands, [friston] Sec. 4.3: what is sent does not depend on the solver.
struct HardInput {
  bool active = false;
  pbd::BodyState own;    ///< this user's own state of the body, which is sent
  pbd::BodyState shown;  ///< the mean over all users' states
};

/// The pose nearest to `pose` in the body's mass metric that brings the attachments to the hands:
/// one hand moves and swings a body, two turn it. As it is where the body is not dynamic.
pbd::Pose dragged(const pbd::BodyProps& props, const pbd::Pose& pose,
                  std::span<const Springs::Hand> hands);

}  // namespace tandem::consensus
