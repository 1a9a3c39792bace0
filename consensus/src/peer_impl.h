// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <memory>

#include "agree/agreement.h"
#include "couple/ownership.h"
#include "input/activity.h"
#include "members/connections.h"
#include "peer_data.h"
#include "receive/receiver.h"
#include "replay/replay.h"
#include "send/sender.h"

namespace tandem::consensus {

/// The stages of one peer, in the order of docs/ARCHITECTURE.md; what they do is in their files,
/// and in which order, in peer.cpp.
class __attribute__((visibility("hidden"))) Peer::Impl {
 public:
  Impl(pbd::World& world, Transport& transport, const PeerOptions& options);

  PeerData data;
  Connections connections;
  std::unique_ptr<Replay> replay;  ///< null: a predictor carries all states to now
  Trust trust;
  Activity activity;
  Receiver receiver;
  Ownership ownership;
  RemoteStates remote;
  Placement placement;
  Estimator estimator;
  HardInputs hard;
  Agreement agreement;
  Sender sender;
  SessionTime last_before = 0;  ///< ns, of the last before_step()
};

}  // namespace tandem::consensus
