// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/collision/contact_source.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "contact_source_impl.h"
#include "sphere_contact.h"
#include "tandem/pbd/validate.h"

namespace tandem::collision {
namespace {

/// Pairs that one worker takes at a time.
constexpr std::size_t kPairGrain = 64;
/// Pairs ahead whose memory is asked for: to see whether they are near, and of those that were.
constexpr std::size_t kPrefetch = 6;
constexpr std::size_t kPrefetchAll = 3;

template <class T>
void prefetch(const T& object) {
  const auto* bytes = reinterpret_cast<const char*>(&object);
  for (std::size_t at = 0; at < sizeof(T); at += 64) __builtin_prefetch(bytes + at);
}

}  // namespace

ColliderId CollisionScene::Impl::add(const pbd::World& world, const ColliderDef& def) {
  check_def(world, def);
  std::uint32_t index = 0;
  if (free_.empty()) {
    index = static_cast<std::uint32_t>(colliders_.size());
    if (index >= (1u << kIndexBits)) {
      pbd::detail::refuse("ColliderDef: count", "below 2^26", index);
    }
    colliders_.emplace_back();
    free_.reserve(colliders_.capacity());
  } else {
    index = free_.back();
    free_.pop_back();
  }
  const std::uint32_t generation = colliders_[index].generation;
  colliders_[index] = make_collider(def, options_);
  colliders_[index].generation = generation;
  colliders_[index].added = added_++;
  colliders_[index].dynamic = world.all_props()[def.body.index].type == pbd::BodyType::Dynamic;
  order_is_old_ = true;
  broad_.add(index, colliders_[index]);
  if (def.sensor) ++sensor_count_;
  return {index, generation};
}

const Collider& CollisionScene::Impl::checked(ColliderId id, const char* what) const {
  if (contains(id)) return colliders_[id.index];
  pbd::detail::refuse(std::string("CollisionScene::") + what + ": id", "a collider of this scene",
                      "collider " + std::to_string(id.index) + " (generation " +
                          std::to_string(id.generation) + ")");
}

void CollisionScene::Impl::remove(ColliderId id) {
  checked(id, "remove");
  Collider& collider = colliders_[id.index];
  if (collider.def.sensor) --sensor_count_;
  broad_.remove(id.index, collider);
  const std::uint32_t generation = collider.generation + 1;
  order_is_old_ = true;
  collider = {};
  collider.generation = generation;
  free_.push_back(id.index);
}

void CollisionScene::Impl::set_material(ColliderId id, const Material& material) {
  checked(id, "set_material");
  std::string error;
  if (!material.validate(&error)) {
    throw std::invalid_argument("CollisionScene::set_material: " + error);
  }
  colliders_[id.index].def.material = material;
}

void CollisionScene::Impl::set_filter(ColliderId id, const Filter& filter) {
  checked(id, "set_filter");
  colliders_[id.index].def.filter = filter;
  broad_.look_again(id.index);
}

void CollisionScene::Impl::set_user_data(ColliderId id, std::uint64_t value) {
  checked(id, "set_user_data");
  colliders_[id.index].def.user_data = value;
}

void CollisionScene::Impl::remove_body(pbd::BodyId body) {
  for (std::uint32_t i = 0; i < colliders_.size(); ++i) {
    if (colliders_[i].alive && colliders_[i].def.body == body) {
      remove({i, colliders_[i].generation});
    }
  }
}

void CollisionScene::Impl::collect_pair(ColliderPair& entry, double dt, Worker& worker,
                                        std::vector<pbd::Manifold>& out) {
  const Collider& low = colliders_[entry.low];
  const Collider& high = colliders_[entry.high];
  const bool fresh = std::exchange(entry.fresh, false);
  const bool planar = low.is_half_space() || high.is_half_space();
  const bool apart = !planar && !low.needed.overlaps(high.needed);
  if (!fresh && low.kind == Kind::Sphere && high.kind == Kind::Sphere &&
      (apart || spheres_apart(low, high))) {
    ++worker.stats.recycled;
    return;
  }
  PairCache& cache = caches_[entry.cache];
  if (fresh || apart) {
    if (cache.patches != nullptr) pool_.give(std::exchange(cache.patches, nullptr));
    if (fresh && cache.triangles != nullptr) cache.triangles->filled = false;
    cache.valid = false;
    if (fresh) cache.axis = PairCache::kNoAxis;
  }
  if (apart) {
    ++worker.stats.recycled;
    return;
  }
  const QueryPair pair = order_pair(low, high);
  const std::uint64_t key = (static_cast<std::uint64_t>(entry.low) << (kIndexBits + kClusterBits)) |
                            (static_cast<std::uint64_t>(entry.high) << kClusterBits);
  if (cache.valid && low.still && high.still &&
      std::min(low.margins.recycle, high.margins.recycle) > 0.0) {
    ++worker.stats.recycled;
    if (cache.patches != nullptr) emit(pair, reach_at_rest(pair), cache, key, out);
    return;
  }
  const PairReach reach = reach_of(pair, dt);
  if (is_direct(pair)) {
    ++worker.stats.recycled;
    emit_direct(pair, reach, key, out);
    return;
  }
  if (still_apart(pair, reach, cache) || can_recycle(pair, reach, cache, options_.recycle_angle)) {
    ++worker.stats.recycled;
  } else {
    worker.stats.queries += query_pair(pair, reach, cache, pool_, worker.scratch);
  }
  if (cache.patches != nullptr) emit(pair, reach, cache, key, out);
}

void CollisionScene::Impl::collect_pairs(std::size_t begin, std::size_t end, double dt,
                                         Worker& worker, std::vector<pbd::Manifold>& out) {
  std::vector<ColliderPair>& pairs = broad_.pairs();
  for (std::size_t i = begin; i < end; ++i) {
    // What lies all over the memory is on its way when its turn comes.
    const ColliderPair& soon = pairs[std::min(i + kPrefetch, end - 1)];
    __builtin_prefetch(&colliders_[soon.high].needed);
    __builtin_prefetch(&caches_[soon.cache]);
    const ColliderPair& next = pairs[std::min(i + kPrefetchAll, end - 1)];
    if (const PairCache& cache = caches_[next.cache]; cache.valid) {
      prefetch(colliders_[next.high]);
      if (cache.patches != nullptr) prefetch(*cache.patches);
      if (cache.triangles != nullptr) prefetch(*cache.triangles);
    }
    collect_pair(pairs[i], dt, worker, out);
  }
}

void CollisionScene::Impl::collect(const pbd::World& world, double dt, pbd::Workers& workers,
                                   std::vector<pbd::Manifold>& out) {
  const std::size_t first = out.size();
  update_order(world);
  if (std::exchange(sleepers_moved_, world.sleepers_moved()) != world.sleepers_moved()) {
    for (Collider& collider : colliders_) collider.asleep = false;
  }
  workers_.resize(static_cast<std::size_t>(workers.count()));
  for (Worker& worker : workers_) {
    worker.stats = {};
    worker.found.clear();
  }
  workers.for_chunks(colliders_.size(), kColliderGrain,
                     [&](std::size_t begin, std::size_t end, int w) {
                       std::size_t& count = workers_[static_cast<std::size_t>(w)].stats.colliders;
                       for (std::size_t i = begin; i < end; ++i) {
                         if (!colliders_[i].alive) continue;
                         update_collider(colliders_[i], world, dt);
                         ++count;
                       }
                     });
  broad_.update(colliders_, dt, workers);
  for (const ColliderPair& pair : broad_.found()) {
    guard(pair.low, pair.high);
    guard(pair.high, pair.low);
  }
  const std::size_t slots = broad_.cache_slots();
  if (slots > caches_.size()) caches_.resize(slots);
  // Before there is anything to be copied, or to be there twice.
  const std::size_t expected = first + stats_.manifolds + stats_.manifolds / 16;
  if (expected > out.capacity() && first == 0) out = {};
  if (expected > out.capacity()) out.reserve(2 * expected);

  collect_all_pairs(dt, workers, out);
  sum_stats(std::span(out).subspan(first));
}

void CollisionScene::Impl::collect_all_pairs(double dt, pbd::Workers& workers,
                                             std::vector<pbd::Manifold>& out) {
  const std::vector<ColliderPair>& pairs = broad_.pairs();
  if (workers.count() == 1 || pairs.size() <= kPairGrain) {
    collect_pairs(0, pairs.size(), dt, workers_[0], out);
    return;
  }
  // Each worker writes to a list of its own; the chunks are then put together in order.
  chunks_.resize((pairs.size() + kPairGrain - 1) / kPairGrain);
  workers.for_chunks(pairs.size(), kPairGrain, [&](std::size_t begin, std::size_t end, int w) {
    Worker& worker = workers_[static_cast<std::size_t>(w)];
    Chunk& chunk = chunks_[begin / kPairGrain];
    chunk = {w, worker.found.size(), 0};
    collect_pairs(begin, end, dt, worker, worker.found);
    chunk.end = worker.found.size();
  });
  for (const Chunk& chunk : chunks_) {
    const auto from = workers_[static_cast<std::size_t>(chunk.worker)].found.begin();
    out.insert(out.end(), from + static_cast<std::ptrdiff_t>(chunk.begin),
               from + static_cast<std::ptrdiff_t>(chunk.end));
  }
}

void CollisionScene::Impl::sum_stats(std::span<const pbd::Manifold> found) {
  stats_ = {};
  for (const Worker& worker : workers_) {
    stats_.colliders += worker.stats.colliders;
    stats_.queries += worker.stats.queries;
    stats_.recycled += worker.stats.recycled;
  }
  stats_.pairs = broad_.pairs().size();
  stats_.manifolds = found.size();
  for (const pbd::Manifold& manifold : found) {
    stats_.points += static_cast<std::size_t>(manifold.count);
  }
}

void CollisionScene::Impl::update_order(const pbd::World& world) {
  const pbd::BodyOrder order = world.order();
  if (!order_is_old_ && natural_order_ == order.natural()) return;
  order_is_old_ = false;
  // Two colliders change places only here, and then no cache says which of them was the first.
  if (natural_order_ != order.natural() && !restored_) broad_.reset();
  restored_ = false;
  natural_order_ = order.natural();
  put_in_order(colliders_, order);
}

CollisionScene::CollisionScene(const CollisionOptions& options) {
  std::string error;
  if (!options.validate(&error)) throw std::invalid_argument(error);
  impl_ = std::make_unique<Impl>(options);
}
CollisionScene::~CollisionScene() = default;
CollisionScene::CollisionScene(CollisionScene&&) noexcept = default;
CollisionScene& CollisionScene::operator=(CollisionScene&&) noexcept = default;

ColliderId CollisionScene::add(const pbd::World& world, const ColliderDef& def) {
  return impl_->add(world, def);
}
void CollisionScene::remove(ColliderId id) { impl_->remove(id); }
void CollisionScene::set_material(ColliderId id, const Material& material) {
  impl_->set_material(id, material);
}
void CollisionScene::set_filter(ColliderId id, const Filter& filter) {
  impl_->set_filter(id, filter);
}
void CollisionScene::set_user_data(ColliderId id, std::uint64_t value) {
  impl_->set_user_data(id, value);
}
bool CollisionScene::contains(ColliderId id) const { return impl_->contains(id); }
const ColliderDef& CollisionScene::collider(ColliderId id) const {
  return impl_->checked(id, "collider").def;
}
ColliderId CollisionScene::collider_at(std::uint32_t index) const {
  if (index >= impl_->colliders().size() || !impl_->colliders()[index].alive) return {};
  return {index, impl_->colliders()[index].generation};
}
std::uint32_t CollisionScene::slot_count() const {
  return static_cast<std::uint32_t>(impl_->colliders().size());
}
std::size_t CollisionScene::sensor_count() const { return impl_->sensor_count(); }
const CollisionOptions& CollisionScene::options() const { return impl_->options(); }
const CollisionStats& CollisionScene::stats() const { return impl_->stats(); }
void CollisionScene::collect(const pbd::World& world, double dt, pbd::Workers& workers,
                             std::vector<pbd::Manifold>& out) {
  impl_->collect(world, dt, workers, out);
}
void CollisionScene::limit_motion(const pbd::World& world, std::span<const pbd::Pose> after,
                                  pbd::Workers& workers, std::vector<pbd::MotionLimit>& limits) {
  impl_->limit_motion(world, after, workers, limits);
}
void CollisionScene::remove_body(pbd::BodyId body) { impl_->remove_body(body); }
void CollisionScene::save(pbd::ByteWriter& out) const { impl_->save(out); }
void CollisionScene::load(pbd::ByteReader& in) {
  impl_->forget();
  if (impl_->load(in)) return;
  impl_->forget();
  in.fail();
}
bool CollisionScene::fits(const pbd::World& world) const {
  return std::all_of(impl_->colliders().begin(), impl_->colliders().end(), [&](const Collider& c) {
    return !c.alive || world.body_at(c.def.body.index).valid();
  });
}

}  // namespace tandem::collision
