// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <span>

#include "scenes/inputs.h"
#include "scenes/scene.h"
#include "session/options.h"
#include "tandem/consensus/peer.h"

namespace tandem::demos {

/// Receives all external events of a peer in order, for recorders. Calls come from the thread that
/// steps the peer's world.
class StepWatch {
 public:
  virtual ~StepWatch() = default;
  /// Before all others, and again after rules(). Both outlive the calls that follow.
  virtual void attach(Scene& scene, consensus::Peer& peer) = 0;
  /// A user is about to join. @param epoch  ns, of the script's beginning
  virtual void user(std::size_t /*user*/, consensus::SessionTime /*epoch*/) {}
  /// The peer is replaced by another. @param options  of the new one
  virtual void rules(const DemoOptions& /*options*/) {}
  /// A step may begin; may repeat before the step. @param now  ns, session time
  virtual void begin(consensus::SessionTime /*now*/) {}
  /// One user's inputs since the last call; before the peer processes its packets.
  virtual void inputs(std::span<const Input> /*inputs*/) {}
  /// The peer has processed its packets.
  virtual void told() = 0;
  /// The step starts. @param end  ns
  virtual void step(consensus::SessionTime /*end*/) {}
  virtual void solved() = 0;
  /// The step's end has come: the peer may send. @param now  ns
  virtual void finish(consensus::SessionTime /*now*/) {}
  /// The peer leaves. @param now  ns
  virtual void leave(consensus::SessionTime /*now*/) {}
  /// After the packets of finish() or leave().
  virtual void sent() = 0;
};

}  // namespace tandem::demos
