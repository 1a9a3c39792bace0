// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "collider.h"
#include "tandem/pbd/manifold.h"
#include "tandem/pbd/workers.h"

namespace tandem::collision {

/// A dynamic collider near a fixed one, and the manifolds of the two.
struct FixedNeighbour {
  std::uint32_t part = 0;   ///< the dynamic collider
  std::uint32_t fixed = 0;  ///< the fixed one
  std::uint32_t first = 0;  ///< first index into the list of manifolds
  std::uint32_t count = 0;
  std::uint32_t cache = 0;  ///< the pair's slot, see ColliderPair
  bool covered = false;     ///< drop_covered() has removed a point
};

/// Removes contacts with edges and sides that the surface of a neighbour covers, so that tiles form
/// one floor, whatever they are made of. A contact stays only if its direction leads away from all
/// fixed colliders: a point a little further out must be nearest to the contact's own collider.
/// Otherwise the neighbour has a nearer contact, unless the contact's collider stands out of the
/// neighbour's surface, like a wall on a floor.
class Seams {
 public:
  void clear() { neighbours_.clear(); }
  void add(const FixedNeighbour& neighbour) { neighbours_.push_back(neighbour); }
  /// @param neighbours  their `first` is `shift` too low
  void add(std::span<const FixedNeighbour> neighbours, std::uint32_t shift);
  /// Removes covered points from `manifolds`, and manifolds without points.
  void drop_covered(std::span<const Collider> colliders, pbd::Workers& workers,
                    std::vector<pbd::Manifold>& manifolds);
  /// After drop_covered(): neighbours of parts that have several.
  std::span<const FixedNeighbour> neighbours() const { return neighbours_; }

 private:
  std::vector<FixedNeighbour> neighbours_;
  /// By worker: triangles near a point.
  std::vector<std::vector<std::uint32_t>> triangles_;
};

}  // namespace tandem::collision
