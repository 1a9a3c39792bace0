// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "clipping.h"
#include "tandem/pbd/manifold.h"
#include "tandem/pbd/types.h"

namespace tandem::collision {

/// A manifold as it is kept between steps: fixed in the frames of the two bodies. a and b are in
/// the order of the query (kinds ascending), not of the colliders' indices.
struct ContactPatch {
  Vec3 normal_l = Vec3::UnitZ();  ///< from a to b, in the frame of the body that `in_a` names
  bool in_a = false;
  /// Two spheres: the normal follows from the anchors (their centres) at any time.
  bool central = false;
  double radius_a = 0.0;  ///< m
  double radius_b = 0.0;  ///< m
  std::uint32_t cluster = 0;
  int count = 0;
  std::array<pbd::ManifoldPoint, pbd::Manifold::kMaxPoints> points;
};

/// What is known of one pair of colliders.
struct PairCache {
  bool valid = false;
  /// m: surfaces further apart than this were left out.
  double margin = 0.0;
  /// Pose of the measured body (see PairMotion) in the frame of the other one at the last query.
  pbd::Pose relative;
  std::vector<ContactPatch> patches;
};

}  // namespace tandem::collision
