// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "cache_io.h"

#include <cmath>

namespace tandem::collision {
namespace {

/// More patches than any pair has (keys keep 12 bits for them).
constexpr std::uint32_t kMaxPatches = 4096;

}  // namespace

void save_cache(pbd::ByteWriter& out, const PairCache& cache) {
  out.u8(cache.valid ? 1 : 0);
  out.f64(cache.margin);
  out.vec3(cache.relative.position);
  out.quat(cache.relative.orientation);
  out.u32(static_cast<std::uint32_t>(cache.patches.size()));
  for (const ContactPatch& patch : cache.patches) {
    out.vec3(patch.normal_l);
    out.u8(patch.in_a ? 1 : 0);
    out.u8(patch.central ? 1 : 0);
    out.f64(patch.radius_a);
    out.f64(patch.radius_b);
    out.u32(patch.cluster);
    out.u8(static_cast<std::uint8_t>(patch.count));
    for (int i = 0; i < patch.count; ++i) {
      out.vec3(patch.points[i].anchor_a_l);
      out.vec3(patch.points[i].anchor_b_l);
      out.u32(patch.points[i].feature);
    }
  }
}

bool load_cache(pbd::ByteReader& in, PairCache& cache) {
  cache.valid = in.u8() != 0;
  cache.margin = in.f64();
  cache.relative.position = in.vec3();
  cache.relative.orientation = in.quat();
  cache.patches.clear();
  const std::uint32_t count = in.u32();
  if (in.failed() || count > kMaxPatches || !std::isfinite(cache.margin) ||
      !cache.relative.position.allFinite() || !cache.relative.orientation.coeffs().allFinite()) {
    return false;
  }
  for (std::uint32_t k = 0; k < count; ++k) {
    ContactPatch& patch = cache.patches.emplace_back();
    patch.normal_l = in.vec3();
    patch.in_a = in.u8() != 0;
    patch.central = in.u8() != 0;
    patch.radius_a = in.f64();
    patch.radius_b = in.f64();
    patch.cluster = in.u32();
    patch.count = in.u8();
    if (in.failed() || patch.count > pbd::Manifold::kMaxPoints || patch.cluster >= kMaxPatches ||
        !patch.normal_l.allFinite()) {
      return false;
    }
    for (int i = 0; i < patch.count; ++i) {
      patch.points[i].anchor_a_l = in.vec3();
      patch.points[i].anchor_b_l = in.vec3();
      patch.points[i].feature = in.u32();
    }
  }
  return !in.failed();
}

}  // namespace tandem::collision
