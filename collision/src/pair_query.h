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

/// Two colliders in the order of the query: kinds ascending, then by the order of their bodies, so
/// that the result does not depend on the order in which they were added.
struct QueryPair {
  const Collider* a = nullptr;
  const Collider* b = nullptr;
  bool swapped = false;  ///< b is the earlier one
};

QueryPair order_pair(const Collider& one, const Collider& other);

/// How near the pair has to be looked at in this step.
struct PairReach {
  double margin = 0.0;        ///< m, gaps below this matter whatever their direction
  double recycle = 0.0;       ///< m, motion that keeps the last contacts; 0 = never
  double speculative = 0.0;   ///< m
  double turning = 0.0;       ///< m, what rotation may close
  Vec3 sweep = Vec3::Zero();  ///< m, motion of b's origin against a's
  /// m, likewise, on which the two are to meet: zero where turning matters as well, as for a bat.
  Vec3 way = Vec3::Zero();
  /// m, of either origin, zero where it does not count: two that fly together close on each other
  /// by that where one of them is stopped within the step.
  Vec3 alone_a = Vec3::Zero();
  Vec3 alone_b = Vec3::Zero();

  /// m, gaps along the unit normal from a to b that matter.
  double along(const Vec3& normal) const {
    const double closing = std::max(
        {0.0, -pbd::dot(normal, sweep), pbd::dot(normal, alone_a), -pbd::dot(normal, alone_b)});
    return speculative + closing + turning;
  }
};

PairReach reach_of(const QueryPair& pair, double dt);
/// The same for two that do not move.
PairReach reach_at_rest(const QueryPair& pair);

/// A sphere with a convex shape or a half-space has a closed form that costs less than looking at
/// a cache; see sphere_contact.h.
bool is_direct(const QueryPair& pair);

/// Whether two boxes are apart in the direction in which they were apart in the last step.
bool still_apart(const QueryPair& pair, const PairReach& reach, const PairCache& cache);

/// Whether the last contacts still hold.
bool can_recycle(const QueryPair& pair, const PairReach& reach, const PairCache& cache,
                 double max_angle);

/// Memory of the narrow phase, one for each worker, kept from pair to pair.
struct QueryScratch {
  MeshScratch mesh;
  SphereScratch sphere;
  std::vector<RawManifold> raw;
  std::vector<PatchTrace> before;
};

/// Ask the narrow phase and renew the cache. The cache's old patches, where valid, give ids.
/// @return number of narrow-phase queries
std::size_t query_pair(const QueryPair& pair, const PairReach& reach, PairCache& cache,
                       PatchPool& pool, QueryScratch& scratch);

/// Append the pair's manifolds as they stand now; points too far away are left out.
/// @param key_base  key of cluster 0
void emit(const QueryPair& pair, const PairReach& reach, const PairCache& cache,
          std::uint64_t key_base, std::vector<pbd::Manifold>& out);
/// The same for a pair that is_direct().
void emit_direct(const QueryPair& pair, const PairReach& reach, std::uint64_t key_base,
                 std::vector<pbd::Manifold>& out);

/// Clusters of one pair, and so the bits that keys keep for them.
inline constexpr int kClusterBits = 12;
inline constexpr int kIndexBits = 26;

}  // namespace tandem::collision
