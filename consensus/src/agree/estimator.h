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

/// Computes how much each peer's state of a body counts.
class Estimator {
 public:
  Estimator(PeerData& data, Trust& trust, RemoteStates& remote, Placement& placement)
      : data_(data), trust_(trust), remote_(remote), placement_(placement) {}

  /// Collect every peer's newest state of one body, relative to the local state at its stamp, or
  /// extrapolated to now if nothing is replayed. If the body's owner says that it has jumped, or
  /// this peer hears of it for the first time, `placement` puts the body there before the next
  /// peer's state is looked at. Placements by earlier states remain.
  void estimate(SharedBody& shared, std::span<const Inbox::Received> newest, bool replays,
                Estimates& out);

 private:
  /// How this peer listens to the others for one body.
  struct Listening {
    bool several = false;  ///< there are enough peers to outvote one
    bool carried = false;  ///< their states are extrapolated to now instead of replayed
    bool hands = false;    ///< claims of motion by hand are believed
    double own_lead = 0.0;
    double own_announced = 0.0;
    double own_confidence = 0.0;
  };
  /// How one peer's state of a body counts.
  struct Hearing {
    bool owner = false;
    bool leads = false;
    double claimed = 0.0;  ///< the announced share
    double age = 0.0;      ///< s
    double share = 0.0;    ///< share that counts now
  };

  Listening listening_to(const SharedBody& shared, std::span<const Inbox::Received> newest,
                         bool replays, bool by_hand) const;
  /// Whether all copies agree at rest, so that nothing is to be done.
  bool rests_where_all_have_it(const SharedBody& shared,
                               std::span<const Inbox::Received> newest) const;
  void hear(SharedBody& shared, std::span<const Inbox::Received> newest, std::size_t i,
            const Listening& listening, bool replays, Estimates& out);
  /// The share of newest[i], whose sender does not own the body, relative to the local state.
  /// @param angle  rad, between the two states at its stamp
  double share_beside(const SharedBody& shared, std::span<const Inbox::Received> newest,
                      std::size_t i, const Hearing& hearing, double angle,
                      const Listening& listening);
  /// Follow a jump of the body's owner, or take over an established peer's state.
  void follow(SharedBody& shared, const StateUpdate& update, const pbd::BodyState& there,
              const Prediction& prediction, bool teleports);
  /// If a peer leads, drop all estimates but those of leaders and owners.
  static void keep_leaders(Estimates& out);
  /// The owner's state, extrapolated to now.
  void estimate_owner(SharedBody& shared, std::span<const Inbox::Received> newest, Estimates& out);
  bool hard_at_sender(const StateUpdate& update) const;

  PeerData& data_;
  Trust& trust_;
  RemoteStates& remote_;
  Placement& placement_;
  double heaviest_ = 0.0;  ///< largest share so far, of the current body
};

}  // namespace tandem::consensus
