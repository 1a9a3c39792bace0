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

/// Hashes of a step's input and result, by body. It sits between a world and its target source. No
/// allocation in the steady state.
/// @par Thread safety  One object: the thread that steps the world.
class StageHashes final : private pbd::TargetSource {
 public:
  /// Both must outlive it, or its last call.
  void attach(Scene& scene, consensus::Peer& peer);

  /// Call after before_step: hashes users' springs, and bodies as placed by the coupling.
  void told();
  /// Call after the solver's step.
  void solved();

  /// States and springs before the last step, and the solver's targets.
  const StageHash& targets() const { return targets_; }
  /// States after the last step.
  const StageHash& poses() const { return poses_; }

 private:
  void collect(const pbd::World& world, double dt, const pbd::SolverOptions& options,
               std::vector<pbd::PoseTarget>& out) override;
  /// The hash of a body; all unshared bodies have one in common.
  std::uint64_t& of(const pbd::BodyId& body);
  void start();
  void fold(StageHash& result);

  Scene* scene_ = nullptr;
  consensus::Peer* peer_ = nullptr;
  pbd::TargetSource* inner_ = nullptr;
  BodiesBySlot bodies_;
  std::vector<std::uint64_t> hashes_;  ///< by body; the last for all others
  std::vector<pbd::Tether::Def> springs_;
  StageHash targets_, poses_;
};

/// Running hash of a peer's calls of its transport.
class SentHash {
 public:
  void post(consensus::PeerId to, std::span<const std::byte> bytes, consensus::Delivery delivery);
  void drop(consensus::PeerId peer);
  /// The hash of all calls since the last take().
  std::uint64_t take();

 private:
  std::uint64_t hash_ = 0;
};

}  // namespace tandem::demos
