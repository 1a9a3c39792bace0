// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "agree/estimates.h"
#include "peer_data.h"

namespace tandem::consensus {

/// Interprets other peers' states, at their stamps and now.
class RemoteStates {
 public:
  explicit RemoteStates(PeerData& data);

  /// A resting body's state is restamped to its sender's newest message, a rounded one is the
  /// nearest to the local copy that rounds alike, and one stamped ahead is moved back to now. Valid
  /// until the next call.
  const StateUpdate& as_meant(const Inbox::Received& received, const SharedBody& shared);
  /// A state, and the difference of the local one at its stamp to it.
  Stamped compare(const SharedBody& shared, const StateUpdate& update,
                  pbd::Correction& missing) const;
  /// Each peer's state of a body, brought to now by the local motion since, with its present share;
  /// appended.
  void as_of_now(const SharedBody& shared, std::span<const Inbox::Received> newest,
                 std::vector<StateUpdate>& out);
  /// A state extrapolated to now by the predictor.
  Prediction carry(SharedBody& shared, PeerId from, const StateUpdate& update);
  /// Report an estimate to the observer.
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
