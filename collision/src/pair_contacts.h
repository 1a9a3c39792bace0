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

/// What is known of each pair of colliders, and the manifolds that are made of it in a step.
class PairContacts {
 public:
  /// Have at least so many slots; see ColliderPair::cache.
  void grow(std::size_t slots) {
    if (slots > caches_.size()) caches_.resize(slots);
  }
  /// Append the manifolds of all pairs, in their order.
  /// @param recycle_angle  see CollisionOptions
  void collect(std::span<const Collider> colliders, std::span<ColliderPair> pairs,
               double recycle_angle, double dt, pbd::Workers& workers,
               std::vector<pbd::Manifold>& out);
  /// Of the last collect(): see CollisionStats.
  std::size_t queries() const;
  std::size_t recycled() const;

  void save(pbd::ByteWriter& out, std::uint32_t slot) const;
  /// @param boxes  whether the pair is of two boxes
  /// @return false where the bytes are no pair's; the slot is then of no use
  bool load(pbd::ByteReader& in, std::uint32_t slot, bool boxes);
  /// Become a copy with memory of its own.
  void assign(const PairContacts& source);

 private:
  /// What one worker needs and finds.
  struct Worker {
    QueryScratch scratch;
    std::size_t queries = 0;
    std::size_t recycled = 0;
    std::vector<pbd::Manifold> found;
    std::vector<FixedNeighbour> fixed;  ///< `first` counts from the worker's own manifolds
  };
  /// Where the manifolds of a chunk of pairs are, and its neighbours that are fixed.
  struct Chunk {
    int worker = 0;
    std::size_t begin = 0;
    std::size_t end = 0;
    std::size_t fixed_begin = 0;
    std::size_t fixed_end = 0;
    std::size_t to = 0;  ///< in what is put together
  };
  /// What a step is about.
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
