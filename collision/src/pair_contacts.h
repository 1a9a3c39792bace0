// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "broad_phase.h"
#include "collider.h"
#include "pair_query.h"
#include "seams.h"
#include "tandem/pbd/bytes.h"
#include "tandem/pbd/workers.h"

namespace tandem::collision {

/// Cached data of each pair of colliders, and the manifolds made of it in a step.
class PairContacts {
 public:
  /// Ensures at least so many slots; see ColliderPair::cache.
  void grow(std::size_t slots) {
    if (slots > caches_.size()) caches_.resize(slots);
  }
  /// Appends the manifolds of all pairs, in order.
  /// @param recycle_angle  see CollisionOptions
  void collect(std::span<const Collider> colliders, std::span<ColliderPair> pairs,
               double recycle_angle, double dt, pbd::Workers& workers,
               std::vector<pbd::Manifold>& out);
  /// Statistics of the last collect(): see CollisionStats.
  std::size_t queries() const;
  std::size_t recycled() const;

  void save(pbd::ByteWriter& out, std::uint32_t slot) const;
  /// @param boxes  whether both colliders are boxes
  /// @return false on invalid input; the slot is then unusable
  bool load(pbd::ByteReader& in, std::uint32_t slot, bool boxes);
  /// Becomes a copy with memory of its own.
  void assign(const PairContacts& source);

 private:
  /// Scratch and results of one worker.
  struct Worker {
    QueryScratch scratch;
    std::size_t queries = 0;
    std::size_t recycled = 0;
    std::vector<pbd::Manifold> found;
    std::vector<FixedNeighbour> fixed;  ///< `first` counts from the worker's own manifolds
  };
  /// Location of a chunk's manifolds, and its fixed neighbours.
  struct Chunk {
    int worker = 0;
    std::size_t begin = 0;
    std::size_t end = 0;
    std::size_t fixed_begin = 0;
    std::size_t fixed_end = 0;
    std::size_t to = 0;  ///< index in the joined list
  };
  /// Input of a step.
  struct Step {
    std::span<const Collider> colliders;
    std::span<ColliderPair> pairs;
    double recycle_angle;
    double dt;
  };

  /// @return whether the two are near each other
  bool collect_pair(const Step& step, ColliderPair& entry, Worker& worker,
                    std::vector<pbd::Manifold>& out);
  void collect_pairs(const Step& step, std::size_t begin, std::size_t end, Worker& worker,
                     std::vector<pbd::Manifold>& out);
  void join_chunks(pbd::Workers& workers, std::vector<pbd::Manifold>& out);

  PatchPool pool_;
  std::vector<PairCache> caches_;  ///< by slot
  std::vector<Worker> workers_;
  std::vector<Chunk> chunks_;
  Seams seams_;
};

}  // namespace tandem::collision
