// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <memory>

#include "body_state.h"
#include "session_time.h"
#include "tandem/consensus/predictor.h"

/// What the predictors have in common.
namespace tandem::consensus::detail {

/// Neither touches, is joined nor held at the stamp.
inline bool is_free(const StateUpdate& update) {
  return !update.flags.in_contact && !update.flags.held && !update.flags.owner_driven;
}

/// What misses to a state that was carried on by itself.
Prediction to_state(const StateUpdate& update, const MotionSample& own, const pbd::Vec3& position,
                    const pbd::Twist& twist, double age);

/// That one, and where what it says is not finite the state as it was stamped.
std::unique_ptr<Predictor> make_guarded(std::shared_ptr<const Predictor> own);
}  // namespace tandem::consensus::detail
