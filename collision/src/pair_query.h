// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "collider.h"
#include "contact_patch.h"
#include "mesh_manifold.h"
#include "sphere_surface.h"
#include "tandem/pbd/manifold.h"
#include "tandem/pbd/math.h"

namespace tandem::collision {

/// Two colliders in the order of the query: kinds ascending, then in the order of their bodies, so
/// that results do not depend on the order in which they were added.
struct QueryPair {
  const Collider* a = nullptr;
  const Collider* b = nullptr;
  bool swapped = false;  ///< b comes first in the order of colliders
};

QueryPair order_pair(const Collider& one, const Collider& other);

/// Range within which a pair is searched in this step.
struct PairReach {
  double margin = 0.0;        ///< m, smaller gaps matter in any direction
  double recycle = 0.0;       ///< m, motion that keeps the last contacts; 0 = never
  double speculative = 0.0;   ///< m
  double turning = 0.0;       ///< m, what rotation may close
  Vec3 sweep = Vec3::Zero();  ///< m, motion of b's origin relative to a's
  /// m, motion on which the two are to meet: zero if rotation matters too, as for a bat.
  Vec3 way = Vec3::Zero();
  /// m, own motion of either origin, zero if it does not count: two bodies that fly together
  /// approach each other by that if one of them is stopped within the step.
  Vec3 alone_a = Vec3::Zero();
  Vec3 alone_b = Vec3::Zero();

  /// m: gaps up to this along the unit normal from a to b matter.
  double along(const Vec3& normal) const {
    const double closing = std::max(
        {0.0, -pbd::dot(normal, sweep), pbd::dot(normal, alone_a), -pbd::dot(normal, alone_b)});
    return speculative + closing + turning;
  }
};

PairReach reach_of(const QueryPair& pair, double dt);
/// The range of two colliders at rest.
PairReach reach_at_rest(const QueryPair& pair);

/// A sphere with a convex shape or a half-space has a closed form that is cheaper than reading a
/// cache; see sphere_contact.h.
bool is_direct(const QueryPair& pair);

/// Whether two boxes are still apart in the direction of the last step.
bool still_apart(const QueryPair& pair, const PairReach& reach, const PairCache& cache);

/// Whether the last contacts still hold.
bool can_recycle(const QueryPair& pair, const PairReach& reach, const PairCache& cache,
                 double max_angle);

/// Scratch of the narrow phase, one per worker, kept from pair to pair.
struct QueryScratch {
  MeshScratch mesh;
  SphereScratch sphere;
  std::vector<RawManifold> raw;
  std::vector<PatchTrace> before;
};

/// Queries the narrow phase and updates the cache. The cache's old patches, if valid, give ids.
/// @return number of narrow-phase queries
std::size_t query_pair(const QueryPair& pair, const PairReach& reach, PairCache& cache,
                       PatchPool& pool, QueryScratch& scratch);

/// Appends the pair's manifolds at the current poses; points too far away are skipped.
/// @param key_base  key of cluster 0
void emit(const QueryPair& pair, const PairReach& reach, const PairCache& cache,
          std::uint64_t key_base, std::vector<pbd::Manifold>& out);
/// Like emit(), for a pair that is_direct().
void emit_direct(const QueryPair& pair, const PairReach& reach, std::uint64_t key_base,
                 std::vector<pbd::Manifold>& out);

/// Bits of keys for the clusters of one pair.
inline constexpr int kClusterBits = 12;
inline constexpr int kIndexBits = 26;

}  // namespace tandem::collision
