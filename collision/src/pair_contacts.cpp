// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "pair_contacts.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sphere_contact.h"

namespace tandem::collision {
namespace {

/// Pairs per chunk of a worker.
constexpr std::size_t kPairGrain = 64;
/// Prefetch distance in pairs: for the test whether they are near, and for the data of near ones.
constexpr std::size_t kPrefetch = 6;
constexpr std::size_t kPrefetchAll = 3;
/// Above the patches of any pair (keys have 12 bits for them).
constexpr std::uint32_t kMaxPatches = 4096;
/// Three faces of either box and nine pairs of edges.
constexpr std::uint8_t kBoxAxes = 15;

template <class T>
void prefetch(const T& object) {
  const auto* bytes = reinterpret_cast<const char*>(&object);
  for (std::size_t at = 0; at < sizeof(T); at += 64) __builtin_prefetch(bytes + at);
}

/// Copies a triangle list; if `to` has none yet, the next search makes it.
void copy_triangles(const PairCache& from, PairCache& to) {
  if (from.triangles == nullptr || !from.triangles->filled) {
    if (to.triangles != nullptr) to.triangles->filled = false;
    return;
  }
  if (to.triangles == nullptr) to.triangles = std::make_unique<TriangleList>();
  *to.triangles = *from.triangles;
}

/// @param may_take  allow patches from the pool; otherwise those without memory in `to` are skipped
/// @return whether none was skipped
bool copy_cache(const PairCache& from, PairCache& to, PatchPool& pool, bool may_take) {
  to.position = from.position;
  to.orientation = from.orientation;
  to.margin = from.margin;
  to.valid = from.valid;
  to.axis = from.axis;
  copy_triangles(from, to);
  ContactPatch** link = &to.patches;
  const ContactPatch* patch = from.patches;
  for (; patch != nullptr; patch = patch->next) {
    if (*link == nullptr && !may_take) break;
    if (*link == nullptr) *link = pool.take();
    ContactPatch* const next = (*link)->next;
    **link = *patch;
    (*link)->next = next;
    link = &(*link)->next;
  }
  pool.give(std::exchange(*link, nullptr));
  return patch == nullptr;
}

}  // namespace

bool PairContacts::collect_pair(const Step& step, ColliderPair& entry, Worker& worker,
                                std::vector<pbd::Manifold>& out) {
  const Collider& low = step.colliders[entry.low];
  const Collider& high = step.colliders[entry.high];
  const bool fresh = std::exchange(entry.fresh, false);
  const bool planar = low.is_half_space() || high.is_half_space();
  const bool apart = !planar && !low.needed.overlaps(high.needed);
  if (!fresh && low.kind == Kind::Sphere && high.kind == Kind::Sphere &&
      (apart || spheres_apart(low, high))) {
    ++worker.recycled;
    return false;
  }
  PairCache& cache = caches_[entry.cache];
  if (fresh || apart) {
    if (cache.patches != nullptr) pool_.give(std::exchange(cache.patches, nullptr));
    if (fresh && cache.triangles != nullptr) cache.triangles->filled = false;
    cache.valid = false;
    if (fresh) cache.axis = PairCache::kNoAxis;
  }
  if (apart) {
    ++worker.recycled;
    return false;
  }
  const QueryPair pair = order_pair(low, high);
  const std::uint64_t key = (static_cast<std::uint64_t>(entry.low) << (kIndexBits + kClusterBits)) |
                            (static_cast<std::uint64_t>(entry.high) << kClusterBits);
  if (cache.valid && low.still && high.still &&
      std::min(low.margins.recycle, high.margins.recycle) > 0.0) {
    ++worker.recycled;
    if (cache.patches != nullptr) emit(pair, reach_at_rest(pair), cache, key, out);
    return true;
  }
  const PairReach reach = reach_of(pair, step.dt);
  if (is_direct(pair)) {
    ++worker.recycled;
    emit_direct(pair, reach, key, out);
    return true;
  }
  if (still_apart(pair, reach, cache) || can_recycle(pair, reach, cache, step.recycle_angle)) {
    ++worker.recycled;
  } else {
    worker.queries += query_pair(pair, reach, cache, pool_, worker.scratch);
  }
  if (cache.patches != nullptr) emit(pair, reach, cache, key, out);
  return true;
}

void PairContacts::collect_pairs(const Step& step, std::size_t begin, std::size_t end,
                                 Worker& worker, std::vector<pbd::Manifold>& out) {
  for (std::size_t i = begin; i < end; ++i) {
    // Prefetch: colliders are scattered in memory.
    const ColliderPair& soon = step.pairs[std::min(i + kPrefetch, end - 1)];
    __builtin_prefetch(&step.colliders[soon.high].needed);
    __builtin_prefetch(&caches_[soon.cache]);
    const ColliderPair& next = step.pairs[std::min(i + kPrefetchAll, end - 1)];
    if (const PairCache& cache = caches_[next.cache]; cache.valid) {
      prefetch(step.colliders[next.high]);
      if (cache.patches != nullptr) prefetch(*cache.patches);
      if (cache.triangles != nullptr) prefetch(*cache.triangles);
    }
    ColliderPair& pair = step.pairs[i];
    const auto first = static_cast<std::uint32_t>(out.size());
    if (!collect_pair(step, pair, worker, out)) continue;
    const bool low = step.colliders[pair.low].dynamic;
    if (low == step.colliders[pair.high].dynamic) continue;
    const auto count = static_cast<std::uint32_t>(out.size()) - first;
    worker.fixed.push_back({.part = low ? pair.low : pair.high,
                            .fixed = low ? pair.high : pair.low,
                            .first = first,
                            .count = count,
                            .cache = pair.cache});
  }
}

void PairContacts::join_chunks(pbd::Workers& workers, std::vector<pbd::Manifold>& out) {
  std::size_t size = out.size();
  for (Chunk& chunk : chunks_) {
    const Worker& worker = workers_[static_cast<std::size_t>(chunk.worker)];
    // Modulo 2^32: a chunk may have been found later than its place in the order.
    const auto shift = static_cast<std::uint32_t>(size - chunk.begin);
    seams_.add(
        std::span(worker.fixed).subspan(chunk.fixed_begin, chunk.fixed_end - chunk.fixed_begin),
        shift);
    chunk.to = size;
    size += chunk.end - chunk.begin;
  }
  out.resize(size);
  workers.for_chunks(chunks_.size(), 1, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t c = begin; c < end; ++c) {
      const Chunk& chunk = chunks_[c];
      const auto from = workers_[static_cast<std::size_t>(chunk.worker)].found.begin();
      std::copy(from + static_cast<std::ptrdiff_t>(chunk.begin),
                from + static_cast<std::ptrdiff_t>(chunk.end),
                out.begin() + static_cast<std::ptrdiff_t>(chunk.to));
    }
  });
}

void PairContacts::collect(std::span<const Collider> colliders, std::span<ColliderPair> pairs,
                           double recycle_angle, double dt, pbd::Workers& workers,
                           std::vector<pbd::Manifold>& out) {
  workers_.resize(static_cast<std::size_t>(workers.count()));
  for (Worker& worker : workers_) {
    worker.queries = worker.recycled = 0;
    worker.found.clear();
    worker.fixed.clear();
  }
  seams_.clear();
  const Step step{colliders, pairs, recycle_angle, dt};
  if (workers.count() == 1 || pairs.size() <= kPairGrain) {
    collect_pairs(step, 0, pairs.size(), workers_[0], out);
    seams_.add(workers_[0].fixed, 0);
  } else {
    // Each worker writes to its own list; the chunks are then joined in order. A few pairs may come
    // as one chunk: the others stay empty then.
    chunks_.assign((pairs.size() + kPairGrain - 1) / kPairGrain, {});
    workers.for_chunks(pairs.size(), kPairGrain, [&](std::size_t begin, std::size_t end, int w) {
      Worker& worker = workers_[static_cast<std::size_t>(w)];
      Chunk& chunk = chunks_[begin / kPairGrain];
      chunk = {w, worker.found.size(), 0, worker.fixed.size(), 0, 0};
      collect_pairs(step, begin, end, worker, worker.found);
      chunk.end = worker.found.size();
      chunk.fixed_end = worker.fixed.size();
    });
    join_chunks(workers, out);
  }
  seams_.drop_covered(colliders, workers, out);
  // When the part has moved on, another place is covered: kept contacts with an edge before the
  // seam must not be used beyond it.
  for (const FixedNeighbour& neighbour : seams_.neighbours()) {
    if (neighbour.covered) caches_[neighbour.cache].margin = 0.0f;
  }
}

std::size_t PairContacts::queries() const {
  std::size_t sum = 0;
  for (const Worker& worker : workers_) sum += worker.queries;
  return sum;
}

std::size_t PairContacts::recycled() const {
  std::size_t sum = 0;
  for (const Worker& worker : workers_) sum += worker.recycled;
  return sum;
}

void PairContacts::save(pbd::ByteWriter& out, std::uint32_t slot) const {
  const PairCache& cache = caches_[slot];
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
    out.f32(p->left_out);
    out.u32(p->cluster);
    out.u8(p->count);
    for (int i = 0; i < p->count; ++i) {
      out.vec3(p->anchor_a_l[i]);
      out.vec3(p->anchor_b_l[i]);
      out.u32(p->features[i]);
    }
  }
}

bool PairContacts::load(pbd::ByteReader& in, std::uint32_t slot, bool boxes) {
  PairCache& cache = caches_[slot];
  pool_.give(std::exchange(cache.patches, nullptr));
  // The slot may have belonged to another pair.
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
    ContactPatch* patch = pool_.take();
    *link = patch;
    link = &patch->next;
    patch->normal_l = in.vec3();
    patch->in_a = in.u8() != 0;
    patch->radius_a = in.f64();
    patch->radius_b = in.f64();
    patch->left_out = in.f32();
    const std::uint32_t cluster = in.u32();
    patch->cluster = static_cast<std::uint16_t>(cluster);
    patch->count = in.u8();
    if (in.failed() || patch->count > ContactPatch::kMaxPoints || cluster >= kMaxPatches ||
        !patch->normal_l.allFinite() || std::isnan(patch->left_out)) {
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
  const bool axis_fits = cache.axis == PairCache::kNoAxis || (boxes && cache.axis < kBoxAxes);
  return finite && axis_fits && !in.failed();
}

void PairContacts::assign(const PairContacts& source) {
  // Slots beyond the source's keep their memory and are reset to the default: nothing reads them,
  // but snapshots contain them.
  for (std::size_t i = source.caches_.size(); i < caches_.size(); ++i) {
    copy_cache(PairCache{}, caches_[i], pool_, false);
  }
  if (caches_.size() < source.caches_.size()) caches_.resize(source.caches_.size());
  // Unneeded patches are given back before others are taken, so that the pool does not grow if only
  // their pairs have changed.
  bool complete = true;
  for (std::size_t i = 0; i < source.caches_.size(); ++i) {
    complete = copy_cache(source.caches_[i], caches_[i], pool_, false) && complete;
  }
  for (std::size_t i = 0; i < source.caches_.size() && !complete; ++i) {
    copy_cache(source.caches_[i], caches_[i], pool_, true);
  }
}

}  // namespace tandem::collision
