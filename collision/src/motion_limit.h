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

/// Finds the bodies that would tunnel: see CollisionScene::limit_motion().
class MotionLimiter {
 public:
  /// Guards colliders near thin ones for a number of steps.
  static void guard(std::span<Collider> colliders, std::span<const ColliderPair> near);
  /// @param watched  ascending, includes the colliders of all bodies that may move
  void find(std::span<Collider> colliders, std::span<const std::uint32_t> watched,
            const BroadPhase& broad, const pbd::World& world, std::span<const pbd::Pose> after,
            pbd::Workers& workers, std::vector<pbd::MotionLimit>& limits);

  /// Frees memory that the last find() did not need.
  void trim() { give_back(paced_); }

  struct Step;

 private:
  /// Two colliders that may stop each other: the core of the first and the surface of the second.
  struct FastPair {
    std::uint32_t first = 0;
    std::uint32_t second = 0;
    double share = 1.0;  ///< of the step, at which they meet
    bool old = true;     ///< outdated: one of them has a new stop
  };
  /// Scratch and results of one worker.
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
  /// By collider: pace in this step; resting ones stay idle.
  std::vector<std::uint8_t> pace_;
  std::vector<std::uint32_t> paced_;  ///< colliders that may not be idle
  /// By body slot: rows join it to another movable body, which would not stop with it.
  std::vector<std::uint8_t> chained_;
  std::vector<std::uint32_t> links_;  ///< bodies set in chained_
  std::vector<pbd::ConstraintEdge> edges_;
  std::vector<FastPair> pairs_;
  std::vector<double> stops_;  ///< by body slot, share of the step
};

}  // namespace tandem::collision
