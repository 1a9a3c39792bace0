// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "clipping.h"
#include "tandem/pbd/manifold.h"
#include "tandem/pbd/types.h"

namespace tandem::collision {

/// A manifold as stored between steps, fixed in the frames of the two bodies. a and b are in the
/// order of the query (kinds ascending), not of the colliders' indices.
struct ContactPatch {
  static constexpr int kMaxPoints = pbd::Manifold::kMaxPoints;

  ContactPatch* next = nullptr;    ///< the pair's patch with the next higher cluster
  Vec3 normal_l = Vec3::UnitZ();   ///< from a to b, in the frame of a if `in_a`, else of b
  double radius_a = 0.0;           ///< m
  double radius_b = 0.0;           ///< m
  std::array<Vec3, 4> anchor_a_l;  ///< m, frame of body a
  std::array<Vec3, 4> anchor_b_l;  ///< m, frame of body b
  std::array<std::uint32_t, 4> features{};
  float left_out = HUGE_VALF;  ///< m, see RawManifold
  std::uint16_t cluster = 0;
  std::uint8_t count = 0;
  bool in_a = false;
};

/// Pool of patches, so that contacts that come and go do not allocate. Results do not depend on
/// which memory a pair gets.
/// @par Thread safety  take() and give() may be called from several threads.
class PatchPool {
 public:
  ContactPatch* take() {
    const std::lock_guard lock(mutex_);
    if (free_ == nullptr) grow();
    ContactPatch* patch = free_;
    free_ = patch->next;
    patch->next = nullptr;
    return patch;
  }
  /// Takes back a whole list.
  void give(ContactPatch* first) {
    if (first == nullptr) return;
    ContactPatch* last = first;
    while (last->next != nullptr) last = last->next;
    const std::lock_guard lock(mutex_);
    last->next = free_;
    free_ = first;
  }

 private:
  static constexpr std::size_t kChunk = 64;

  void grow() {
    ContactPatch* chunk = chunks_.emplace_back(std::make_unique<ContactPatch[]>(kChunk)).get();
    for (std::size_t i = 0; i < kChunk; ++i) {
      chunk[i].next = free_;
      free_ = &chunk[i];
    }
  }

  std::mutex mutex_;
  ContactPatch* free_ = nullptr;
  std::vector<std::unique_ptr<ContactPatch[]>> chunks_;
};

/// Triangles that a pair's convex part may meet while it stays within a box. A cache of the search:
/// results do not depend on it.
struct TriangleList {
  bool filled = false;
  Vec3 min = Vec3::Zero();  ///< m, mesh frame
  Vec3 max = Vec3::Zero();
  std::vector<std::uint32_t> triangles;
};

/// Cached data of a pair of colliders. Kept small: a heap has ten per body.
struct alignas(64) PairCache {
  /// Neither a face nor a pair of edges of two boxes.
  static constexpr std::uint8_t kNoAxis = 0xff;

  ContactPatch* patches = nullptr;          ///< ascending clusters
  std::unique_ptr<TriangleList> triangles;  ///< of a mesh or height field
  /// Pose of the measured body (see measures_a()) in the frame of the other one at the last query.
  Vec3 position = Vec3::Zero();
  std::array<float, 4> orientation{};  ///< x, y, z, w; single precision suffices
  float margin = 0.0f;                 ///< m: surfaces further apart than this were not searched
  bool valid = false;
  std::uint8_t axis = kNoAxis;  ///< of two boxes: result of the last query
};

}  // namespace tandem::collision
