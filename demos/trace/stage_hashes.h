// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "scenes/scene.h"
#include "tandem/consensus/peer.h"
#include "tandem/pbd/pose_target.h"
#include "tandem/pbd/tether.h"
#include "trace/record.h"

namespace tandem::demos {

/// Hashes of what a step is told and of what comes of it, by body. It stands between a world and
/// its target source. No allocation in the steady state.
/// @par Thread safety  One object: the thread that steps the world.
class StageHashes final : private pbd::TargetSource {
 public:
  /// From now on. Both must outlive it, or its last call.
  void attach(Scene& scene, consensus::Peer& peer);

  /// After before_step: users' springs, and bodies where the coupling has put them.
  void told();
  /// After the solver's step.
  void solved();

  /// Of the last step: states and springs before it, and the targets that the solver asked for.
  const StageHash& targets() const { return targets_; }
  /// Of the last step: states after it.
  const StageHash& poses() const { return poses_; }

 private:
  void collect(const pbd::World& world, double dt, const pbd::SolverOptions& options,
               std::vector<pbd::PoseTarget>& out) override;
  /// The hash that goes with a body; one for all that are not shared.
  std::uint64_t& of(const pbd::BodyId& body);
  void start();
  void fold(StageHash& result);

  Scene* scene_ = nullptr;
  consensus::Peer* peer_ = nullptr;
  pbd::TargetSource* inner_ = nullptr;
  BodiesBySlot bodies_;
  std::vector<std::uint64_t> hashes_;  ///< under way, by body; the last one is of all others
  std::vector<pbd::Tether::Def> springs_;
  StageHash targets_, poses_;
};

/// Running hash of what a peer does to its transport.
class SentHash {
 public:
  void post(consensus::PeerId to, std::span<const std::byte> bytes, consensus::Delivery delivery);
  void drop(consensus::PeerId peer);
  /// Of all since the last call.
  std::uint64_t take();

 private:
  std::uint64_t hash_ = 0;
};

}  // namespace tandem::demos
