// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "cache_io.h"

#include <cmath>
#include <utility>

#include "contact_source_impl.h"
#include "material_io.h"

namespace tandem::collision {
namespace {

/// More patches than any pair has (keys keep 12 bits for them).
constexpr std::uint32_t kMaxPatches = 4096;
/// Three faces of either box and nine pairs of edges.
constexpr std::uint8_t kBoxAxes = 15;

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
  // The slot may have been another pair's.
  if (cache.triangles != nullptr) cache.triangles->filled = false;
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
      finite = finite && patch->anchor_a_l[i].allFinite() && patch->anchor_b_l[i].allFinite();
    }
    finite = finite && std::isfinite(patch->radius_a) && std::isfinite(patch->radius_b);
  }
  return finite && !in.failed();
}

void CollisionScene::Impl::save(pbd::ByteWriter& out) const {
  out.u32(kCacheMagic);
  out.u32(static_cast<std::uint32_t>(colliders_.size()));
  for (std::uint32_t i = 0; i < colliders_.size(); ++i) {
    const Collider& collider = colliders_[i];
    out.u8(collider.alive ? 1 : 0);
    if (!collider.alive) continue;
    out.u32(collider.def.body.index);
    out.u8(static_cast<std::uint8_t>(collider.kind));
    save_surface(out, collider.def.material, collider.def.filter);
    out.u8(collider.guarded);
    out.u8(broad_.placed_fixed(i) ? 2 : broad_.placed(i) ? 1 : 0);
    out.vec3(broad_.fat_box(i).min);
    out.vec3(broad_.fat_box(i).max);
  }
  out.u32(static_cast<std::uint32_t>(broad_.pairs().size()));
  for (const ColliderPair& pair : broad_.pairs()) {
    out.u32(pair.low);
    out.u32(pair.high);
    save_cache(out, caches_[pair.cache]);
  }
}

bool CollisionScene::Impl::load(pbd::ByteReader& in) {
  order_is_old_ = true;
  restored_ = true;
  if (in.u32() != kCacheMagic || in.u32() != colliders_.size()) return false;
  for (std::uint32_t i = 0; i < colliders_.size(); ++i) {
    Collider& collider = colliders_[i];
    if ((in.u8() != 0) != collider.alive) return false;
    if (!collider.alive) continue;
    if (in.u32() != collider.def.body.index || in.u8() != static_cast<std::uint8_t>(collider.kind))
      return false;
    if (!load_surface(in, collider.def.material, collider.def.filter)) return false;
    collider.guarded = in.u8();
    const std::uint8_t place = in.u8();
    const Aabb fat{in.vec3(), in.vec3()};
    const bool sound = fat.min.allFinite() && fat.max.allFinite();
    if (in.failed() || !sound || place > 2 || (place != 0 && collider.is_half_space()))
      return false;
    if (place != 0) {
      broad_.place(i, fat, place == 2);
    } else {
      broad_.remember_plane(i, fat);
    }
  }
  const std::uint32_t count = in.u32();
  for (std::uint32_t k = 0; k < count && !in.failed(); ++k) {
    const std::uint32_t low = in.u32();
    const std::uint32_t high = in.u32();
    if (low >= high || high >= colliders_.size() || !may_touch(colliders_[low], colliders_[high])) {
      return false;
    }
    if (!broad_.pairs().empty() && !(broad_.pairs().back() < ColliderPair{low, high, 0, false})) {
      return false;
    }
    const ColliderPair& pair = broad_.append_pair(low, high);
    if (caches_.size() <= pair.cache) caches_.resize(pair.cache + 1);
    if (!load_cache(in, caches_[pair.cache], pool_)) return false;
    const bool boxes = colliders_[low].kind == Kind::Box && colliders_[high].kind == Kind::Box;
    const std::uint8_t axis = caches_[pair.cache].axis;
    if (axis != PairCache::kNoAxis && !(boxes && axis < kBoxAxes)) return false;
  }
  return !in.failed();
}

void CollisionScene::Impl::forget() {
  broad_.reset();
  for (Collider& collider : colliders_) collider.asleep = false;
}

}  // namespace tandem::collision
