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

/// What the others say of each body becomes a target of the step to come: estimates, their mean,
/// the mean replayed to now, the share of the gap that is closed.
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

  /// Before a step.
  void aggregate();
  /// Of the step to come, and whose they are; until the next aggregate() or clear().
  std::span<const pbd::PoseTarget> targets() const { return targets_; }
  std::span<SharedBody* const> targeted() const { return targeted_; }
  void clear() { targets_.clear(), targeted_.clear(); }

 private:
  /// Take over the fused estimates as what agreement wants.
  /// @param replayed  they are brought to the present by the replay
  void want(SharedBody& shared, const pbd::Vec3& asked, bool replayed);
  /// What stands is still where its mean with the own state `then`, of the oldest stamp, was. In
  /// the demos the same bits where it is replayed instead, but what two owned in turn then stays 20
  /// um apart (tests/consensus/peer_owner_test.cpp).
  void stay(const pbd::BodyState& then, pbd::PoseTarget& target);
  /// Lessen the share of a correction that begins.
  void ease_in(const pbd::BodyState& own, Wanted& wanted) const;
  /// Make a target of what is wanted.
  void aim(Wanted& wanted);
  bool replays() const { return replay_ != nullptr && replay_->possible(); }

  PeerData& data_;
  Replay* replay_;
  Trust& trust_;
  Latecomers& latecomers_;
  Estimator& estimator_;
  HardInputs& hard_;
  bool apart_ = false;  ///< something is to be replayed for
  Estimates found_;     ///< of the body that is looked at
  std::vector<Wanted> wanted_;
  std::vector<pbd::PoseTarget> targets_;
  std::vector<SharedBody*> targeted_;  ///< of targets_
};

}  // namespace tandem::consensus
