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

/// Is told what happens to a peer from outside, in its order: for recorders. What it does not need
/// to know it leaves as it is. Calls come from the thread that steps the peer's world.
class StepWatch {
 public:
  virtual ~StepWatch() = default;
  /// Before all others, and again after rules(). Both outlive the calls that follow.
  virtual void attach(Scene& scene, consensus::Peer& peer) = 0;
  /// A user is to sit down. @param epoch  ns, of the script's beginning
  virtual void user(std::size_t /*user*/, consensus::SessionTime /*epoch*/) {}
  /// Another peer is put in the place of the one that was. @param options  of the new one
  virtual void rules(const DemoOptions& /*options*/) {}
  /// A step may begin; it may also be said again before it does. @param now  ns, session time
  virtual void begin(consensus::SessionTime /*now*/) {}
  /// What one user did since the last call; before the peer takes in what has come.
  virtual void inputs(std::span<const Input> /*inputs*/) {}
  /// The peer has taken in what has come.
  virtual void told() = 0;
  /// The step is to be computed. @param end  ns
  virtual void step(consensus::SessionTime /*end*/) {}
  virtual void solved() = 0;
  /// Its end has come: the peer may send. @param now  ns
  virtual void finish(consensus::SessionTime /*now*/) {}
  /// The peer leaves. @param now  ns
  virtual void leave(consensus::SessionTime /*now*/) {}
  /// After what finish() or leave() announce.
  virtual void sent() = 0;
};

}  // namespace tandem::demos
