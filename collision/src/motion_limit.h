// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "broad_phase.h"
#include "collider.h"

namespace tandem::collision {

/// Finds the bodies whose middle would get through something: see CollisionScene::limit_motion().
class MotionLimiter {
 public:
  /// Colliders that are near what is thin are guarded for a while.
  static void guard(std::span<Collider> colliders, std::span<const ColliderPair> near);
  void find(std::span<Collider> colliders, const BroadPhase& broad, const pbd::World& world,
            std::span<const pbd::Pose> after, pbd::Workers& workers,
            std::vector<pbd::MotionLimit>& limits);

 private:
  /// What one worker needs and finds.
  struct Worker {
    std::vector<pbd::MotionLimit> limits;
    std::vector<std::uint32_t> stack;
    std::vector<std::uint32_t> list;
  };
  std::vector<Worker> workers_;
};

}  // namespace tandem::collision
