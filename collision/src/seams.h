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

/// A dynamic collider near one of a body that is not, and the manifolds of the two.
struct FixedNeighbour {
  std::uint32_t part = 0;   ///< the dynamic collider
  std::uint32_t fixed = 0;  ///< the other one
  std::uint32_t first = 0;  ///< into the list of manifolds
  std::uint32_t count = 0;
  std::uint32_t cache = 0;  ///< the pair's slot, see ColliderPair
  bool covered = false;     ///< drop_covered() took a point away
};

/// Takes contacts with edges and sides away that the surface of a neighbour covers, so that tiles
/// of a floor are one floor, whatever they are made of. A contact may stay only where the way out
/// of it leads away from all that is fixed: a point a little further out must have the contact's
/// own collider nearest. Otherwise what touches there has a nearer contact with the neighbour,
/// unless the contact's collider stands out of the neighbour's surface, as a wall does on a floor.
class Seams {
 public:
  void clear() { neighbours_.clear(); }
  void add(const FixedNeighbour& neighbour) { neighbours_.push_back(neighbour); }
  /// @param neighbours  of which `first` is `shift` too low
  void add(std::span<const FixedNeighbour> neighbours, std::uint32_t shift);
  /// Remove covered points from `manifolds`, and manifolds that have none left.
  void drop_covered(std::span<const Collider> colliders, pbd::Workers& workers,
                    std::vector<pbd::Manifold>& manifolds);
  /// After drop_covered(): of parts that have several.
  std::span<const FixedNeighbour> neighbours() const { return neighbours_; }

 private:
  std::vector<FixedNeighbour> neighbours_;
  /// Of each worker: triangles near a point.
  std::vector<std::vector<std::uint32_t>> triangles_;
};

}  // namespace tandem::collision
