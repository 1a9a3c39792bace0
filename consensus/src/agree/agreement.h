// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <span>
#include <vector>

#include "agree/estimates.h"
#include "agree/estimator.h"
#include "agree/latecomers.h"
#include "agree/trust.h"
#include "input/hard_input.h"
#include "peer_data.h"
#include "replay/replay.h"

namespace tandem::consensus {

/// Turns the peers' states of each body into a target of the step to come: estimates, their mean,
/// the mean replayed to now, and the share of the gap to close.
class Agreement {
 public:
  /// @param replay  null: the predictor carries all states to now
  Agreement(PeerData& data, Replay* replay, Trust& trust, Latecomers& latecomers,
            Estimator& estimator, HardInputs& hard)
      : data_(data),
        replay_(replay),
        trust_(trust),
        latecomers_(latecomers),
        estimator_(estimator),
        hard_(hard) {}

  /// Call before a step.
  void aggregate();
  /// Targets of the step to come, and their bodies; until the next aggregate() or clear().
  std::span<const pbd::PoseTarget> targets() const { return targets_; }
  std::span<SharedBody* const> targeted() const { return targeted_; }
  void clear() { targets_.clear(), targeted_.clear(); }

 private:
  /// Use the fused estimates as what agreement wants.
  /// @param replayed  the replay brings them to the present
  void want(SharedBody& shared, const pbd::Vec3& asked, bool replayed);
  /// A body at rest has its mean where it was with the local state `then`, of the oldest stamp. In
  /// the demos replaying instead gives the same bits, but the copies of a body that two peers owned
  /// in turn then stay 20 um apart (tests/consensus/peer_owner_test.cpp).
  void stay(const pbd::BodyState& then, pbd::PoseTarget& target);
  /// Reduce the share of a correction that begins.
  void ease_in(const pbd::BodyState& own, Wanted& wanted) const;
  /// Make a target of `wanted`.
  void aim(Wanted& wanted);
  bool replays() const { return replay_ != nullptr && replay_->possible(); }

  PeerData& data_;
  Replay* replay_;
  Trust& trust_;
  Latecomers& latecomers_;
  Estimator& estimator_;
  HardInputs& hard_;
  bool apart_ = false;  ///< some body needs a replay
  Estimates found_;     ///< of the current body
  std::vector<Wanted> wanted_;
  std::vector<pbd::PoseTarget> targets_;
  std::vector<SharedBody*> targeted_;  ///< the bodies of targets_
};

}  // namespace tandem::consensus
