// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "broad_phase.h"
#include "collider.h"
#include "give_back.h"
#include "tandem/pbd/constraint.h"

namespace tandem::collision {

/// Finds the bodies that would get through something: see CollisionScene::limit_motion().
class MotionLimiter {
 public:
  /// Colliders that are near what is thin are guarded for a while.
  static void guard(std::span<Collider> colliders, std::span<const ColliderPair> near);
  /// @param watched  those of bodies that may move are among them, ascending
  void find(std::span<Collider> colliders, std::span<const std::uint32_t> watched,
            const BroadPhase& broad, const pbd::World& world, std::span<const pbd::Pose> after,
            pbd::Workers& workers, std::vector<pbd::MotionLimit>& limits);

  /// Give back memory that the last find() did not need.
  void trim() { give_back(paced_); }

  struct Step;

 private:
  /// Two that may stop each other: the inside of the first one and the surface of the second.
  struct FastPair {
    std::uint32_t first = 0;
    std::uint32_t second = 0;
    double share = 1.0;  ///< of the step after which they meet
    bool old = true;     ///< one of them stops elsewhere than when this was asked
  };
  /// What one worker needs and finds.
  struct Worker {
    std::vector<pbd::MotionLimit> limits;
    std::vector<FastPair> pairs;
    std::vector<std::uint32_t> stack;
    std::vector<std::uint32_t> list;
    std::vector<Vec3> arms;
  };
  void mark_chained(const pbd::World& world, std::span<const std::uint32_t> watched);
  void limit_one(const Step& step, std::uint32_t index, Worker& worker);
  void stop_pairs(const Step& step, std::vector<pbd::MotionLimit>& limits);
  void sort_pairs(const Step& step);
  bool stop_first(const Step& step, std::vector<Vec3>& arms);

  std::vector<Worker> workers_;
  /// By collider: how it goes in this step; what lies still stays idle.
  std::vector<std::uint8_t> pace_;
  std::vector<std::uint32_t> paced_;  ///< where that may not be idle
  /// By body slot: rows hold it to another movable body, which would not stop with it.
  std::vector<std::uint8_t> chained_;
  std::vector<std::uint32_t> links_;  ///< where that is set
  std::vector<pbd::ConstraintEdge> edges_;
  std::vector<FastPair> pairs_;
  std::vector<double> stops_;  ///< by body slot: share of the step
};

}  // namespace tandem::collision
