// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <span>

#include "agree/estimates.h"
#include "agree/placement.h"
#include "agree/remote_states.h"
#include "agree/trust.h"
#include "peer_data.h"

namespace tandem::consensus {

/// What the others' states of a body are worth beside the own one.
class Estimator {
 public:
  Estimator(PeerData& data, Trust& trust, RemoteStates& remote, Placement& placement)
      : data_(data), trust_(trust), remote_(remote), placement_(placement) {}

  /// Every peer's newest state of one body, as what is between it and the own one of its stamp, or
  /// carried to now where nothing is replayed. A body that its owner says has jumped, or that this
  /// peer knows for the first time, is put there by `placement` before the next peer's state is
  /// looked at; what was made of those before is a place of the world, and stays.
  void estimate(SharedBody& shared, std::span<const Inbox::Received> newest, bool replays,
                Estimates& out);

 private:
  /// How this peer stands to the others in one body.
  struct Listening {
    bool several = false;  ///< others may be outvoted
    bool carried = false;  ///< their states are guessed for now, and not replayed
    bool hands = false;    ///< what is said to be by hand is believed
    double own_lead = 0.0;
    double own_announced = 0.0;
    double own_confidence = 0.0;
  };
  /// How one peer's state of a body is heard.
  struct Hearing {
    bool owner = false;
    bool leads = false;
    double claimed = 0.0;  ///< the announced share
    double age = 0.0;      ///< s
    double share = 0.0;    ///< what counts of it now
  };

  Listening listening_to(const SharedBody& shared, std::span<const Inbox::Received> newest,
                         bool replays, bool by_hand) const;
  /// Then nothing is to be agreed on.
  bool rests_where_all_have_it(const SharedBody& shared,
                               std::span<const Inbox::Received> newest) const;
  void hear(SharedBody& shared, std::span<const Inbox::Received> newest, std::size_t i,
            const Listening& listening, bool replays, Estimates& out);
  /// What the `share` of newest[i], whose sender does not own the body, is beside the own state.
  /// @param angle  rad, between the two at its stamp
  double share_beside(const SharedBody& shared, std::span<const Inbox::Received> newest,
                      std::size_t i, const Hearing& hearing, double angle,
                      const Listening& listening);
  /// Follow a jump of the body's owner, or take over what an established peer says.
  void follow(SharedBody& shared, const StateUpdate& update, const pbd::BodyState& there,
              const Prediction& prediction, bool teleports);
  /// Where somebody leads, of the estimates only those of leaders and owners.
  static void keep_leaders(Estimates& out);
  /// The state of whoever owns the body, carried to now.
  void estimate_owner(SharedBody& shared, std::span<const Inbox::Received> newest, Estimates& out);
  bool hard_at_sender(const StateUpdate& update) const;

  PeerData& data_;
  Trust& trust_;
  RemoteStates& remote_;
  Placement& placement_;
  double heaviest_ = 0.0;  ///< share, of the body that is estimated
};

}  // namespace tandem::consensus
