// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "cache_io.h"

#include <cmath>
#include <utility>

namespace tandem::collision {
namespace {

/// More patches than any pair has (keys keep 12 bits for them).
constexpr std::uint32_t kMaxPatches = 4096;

}  // namespace

void save_cache(pbd::ByteWriter& out, const PairCache& cache) {
  out.u8(cache.valid ? 1 : 0);
  out.u8(cache.axis);
  out.f32(cache.margin);
  out.vec3(cache.position);
  for (const float q : cache.orientation) out.f32(q);
  std::uint32_t count = 0;
  for (const ContactPatch* p = cache.patches; p != nullptr; p = p->next) ++count;
  out.u32(count);
  for (const ContactPatch* p = cache.patches; p != nullptr; p = p->next) {
    out.vec3(p->normal_l);
    out.u8(p->in_a ? 1 : 0);
    out.f64(p->radius_a);
    out.f64(p->radius_b);
    out.u32(p->cluster);
    out.u8(p->count);
    for (int i = 0; i < p->count; ++i) {
      out.vec3(p->anchor_a_l[i]);
      out.vec3(p->anchor_b_l[i]);
      out.u32(p->features[i]);
    }
  }
}

bool load_cache(pbd::ByteReader& in, PairCache& cache, PatchPool& pool) {
  pool.give(std::exchange(cache.patches, nullptr));
  cache.valid = in.u8() != 0;
  cache.axis = in.u8();
  cache.margin = in.f32();
  cache.position = in.vec3();
  bool finite = std::isfinite(cache.margin) && cache.position.allFinite();
  for (float& q : cache.orientation) {
    q = in.f32();
    finite = finite && std::isfinite(q);
  }
  const std::uint32_t count = in.u32();
  if (in.failed() || count > kMaxPatches || !finite) return false;
  ContactPatch** link = &cache.patches;
  for (std::uint32_t k = 0; k < count; ++k) {
    ContactPatch* patch = pool.take();
    *link = patch;
    link = &patch->next;
    patch->normal_l = in.vec3();
    patch->in_a = in.u8() != 0;
    patch->radius_a = in.f64();
    patch->radius_b = in.f64();
    const std::uint32_t cluster = in.u32();
    patch->cluster = static_cast<std::uint16_t>(cluster);
    patch->count = in.u8();
    if (in.failed() || patch->count > ContactPatch::kMaxPoints || cluster >= kMaxPatches ||
        !patch->normal_l.allFinite()) {
      patch->count = 0;
      return false;
    }
    for (int i = 0; i < patch->count; ++i) {
      patch->anchor_a_l[i] = in.vec3();
      patch->anchor_b_l[i] = in.vec3();
      patch->features[i] = in.u32();
    }
  }
  return !in.failed();
}

}  // namespace tandem::collision
