// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "agree/estimates.h"
#include "peer_data.h"

namespace tandem::consensus {

/// What a state of another peer stands for here: at its stamp, and now.
class RemoteStates {
 public:
  explicit RemoteStates(PeerData& data);

  /// Of what rests one that is as new as the last word of its sender, of what was rounded the one
  /// nearest to the own copy, of what is stamped ahead one of now. Valid until the next call.
  const StateUpdate& as_meant(const Inbox::Received& received, const SharedBody& shared);
  /// A state, and what the own one of its stamp misses to it.
  Stamped compare(const SharedBody& shared, const StateUpdate& update,
                  pbd::Correction& missing) const;
  /// What each peer says of a body, brought to now by the own motion since, with what it counts
  /// now; appended.
  void as_of_now(const SharedBody& shared, std::span<const Inbox::Received> newest,
                 std::vector<StateUpdate>& out);
  /// A state carried to now by the predictor.
  Prediction carry(SharedBody& shared, PeerId from, const StateUpdate& update);
  /// Tell the observer of an estimate.
  void observe(SharedBody& shared, PeerId from, const StateUpdate& update,
               const Prediction& prediction);
  void set_observer(PeerObserver* observer) { observer_ = observer; }

 private:
  PredictionContext context_of(SharedBody& shared, PeerId from);
  Heard& heard_from(SharedBody& shared, PeerId peer) const;

  PeerData& data_;
  std::shared_ptr<const Predictor> predictor_;
  std::unique_ptr<Predictor> as_stamped_;
  PeerObserver* observer_ = nullptr;
  StateUpdate meant_;
};

}  // namespace tandem::consensus
