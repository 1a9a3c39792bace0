// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/collision/contact_source.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "broad_phase.h"
#include "cache_io.h"
#include "collider.h"
#include "core_cast.h"
#include "material_io.h"
#include "pair_query.h"
#include "tandem/pbd/bytes.h"

namespace tandem::collision {
namespace {

using pbd::Vec3;

/// Whether a body may be pushed out on the far side.
bool is_thin(const Collider& target, const Collider& collider) {
  return !target.dynamic && target.is_convex() && target.size < 2.0 * collider.size;
}

/// Colliders and pairs that one worker takes at a time.
constexpr std::size_t kColliderGrain = 128;
constexpr std::size_t kPairGrain = 64;
constexpr std::uint8_t kGuardedSteps = 60;

[[noreturn]] void refuse(const std::string& field, double value, const std::string& rule) {
  std::ostringstream text;
  text << "ColliderDef: " << field << " = " << value << " breaks the rule: " << rule;
  throw std::invalid_argument(text.str());
}

void check(const pbd::World& world, const ColliderDef& def) {
  if (!world.contains(def.body)) {
    refuse("body", static_cast<double>(def.body.index), "a body of this world");
  }
  std::string error;
  if (!validate(def.shape, &error)) throw std::invalid_argument("ColliderDef: shape: " + error);
  for (int i = 0; i < 3; ++i) {
    const double value = def.local.position[i];
    if (!std::isfinite(value)) refuse("local.position", value, "finite");
  }
  const double norm = def.local.orientation.norm();
  if (!(std::abs(norm - 1.0) < 1e-3)) {
    refuse("local.orientation", norm, "a quaternion of unit norm (within 1e-3)");
  }
  if (!def.material.validate(&error)) throw std::invalid_argument("ColliderDef: " + error);
}

}  // namespace

bool CollisionOptions::validate(std::string* error) const {
  const auto in = [&](const char* field, double value, double low, double high) {
    if (value >= low && value <= high) return true;
    if (error != nullptr) {
      std::ostringstream text;
      text << "CollisionOptions." << field << " = " << value << " breaks the rule: " << low
           << " to " << high;
      *error = text.str();
    }
    return false;
  };
  return in("speculative_margin", speculative_margin, 0.0, 10.0) &&
         in("speculative_size_share", speculative_size_share, 1e-6, 1.0) &&
         in("aabb_margin", aabb_margin, 1e-6, 100.0) &&
         in("recycle_distance", recycle_distance, 0.0, 1.0) &&
         in("recycle_size_share", recycle_size_share, 0.0, 0.1) &&
         in("recycle_angle", recycle_angle, 0.0, 0.2);
}

class CollisionScene::Impl {
 public:
  explicit Impl(const CollisionOptions& options) : options_(options), broad_(options.aabb_margin) {}

  ColliderId add(const pbd::World& world, const ColliderDef& def);
  void remove(ColliderId id);
  void set_material(ColliderId id, const Material& material);
  void set_filter(ColliderId id, const Filter& filter);
  bool contains(ColliderId id) const {
    return id.index < colliders_.size() && colliders_[id.index].alive &&
           colliders_[id.index].generation == id.generation;
  }
  const Collider& checked(ColliderId id, const char* what) const;
  void collect(const pbd::World& world, double dt, pbd::Workers& workers,
               std::vector<pbd::Manifold>& out);
  void limit_motion(const pbd::World& world, std::span<const pbd::Pose> after,
                    pbd::Workers& workers, std::vector<pbd::MotionLimit>& limits);
  void remove_body(pbd::BodyId body);
  void save(pbd::ByteWriter& out) const;
  bool load(pbd::ByteReader& in);
  void forget();

  const CollisionOptions& options() const { return options_; }
  const CollisionStats& stats() const { return stats_; }
  const std::vector<Collider>& colliders() const { return colliders_; }
  std::size_t sensor_count() const { return sensor_count_; }

 private:
  /// What one worker needs and finds.
  struct Worker {
    QueryScratch scratch;
    CollisionStats stats;
    std::vector<pbd::Manifold> found;
    std::vector<pbd::MotionLimit> limits;
    std::vector<std::uint32_t> stack;
    std::vector<std::uint32_t> list;
  };
  /// Where the manifolds of a chunk of pairs are.
  struct Chunk {
    int worker = 0;
    std::size_t begin = 0;
    std::size_t end = 0;
  };

  CoreHit first_hit(Collider& collider, bool bullet, std::span<const pbd::Pose> after,
                    Worker& worker) const;
  void guard(std::uint32_t index, std::uint32_t near);
  void update_order(const pbd::World& world);
  void collect_pair(ColliderPair& entry, double dt, Worker& worker,
                    std::vector<pbd::Manifold>& out);

  CollisionOptions options_;
  CollisionStats stats_;
  std::vector<Collider> colliders_;
  std::vector<std::uint32_t> free_;
  std::size_t sensor_count_ = 0;
  std::uint64_t added_ = 0;
  bool order_is_old_ = true;
  bool natural_order_ = true;
  bool restored_ =
      false;  ///< what is known was loaded, in the order of the world that comes with it
  BroadPhase broad_;
  PatchPool pool_;
  std::vector<PairCache> caches_;  ///< by slot
  std::vector<Worker> workers_;
  std::vector<Chunk> chunks_;
};

ColliderId CollisionScene::Impl::add(const pbd::World& world, const ColliderDef& def) {
  check(world, def);
  std::uint32_t index = 0;
  if (free_.empty()) {
    index = static_cast<std::uint32_t>(colliders_.size());
    if (index >= (1u << kIndexBits)) refuse("count", index, "fewer than 2^26 colliders");
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
  order_is_old_ = true;
  broad_.add(index, colliders_[index]);
  if (def.sensor) ++sensor_count_;
  return {index, generation};
}

const Collider& CollisionScene::Impl::checked(ColliderId id, const char* what) const {
  if (contains(id)) return colliders_[id.index];
  throw std::invalid_argument(std::string("CollisionScene::") + what + ": id = collider " +
                              std::to_string(id.index) + " (generation " +
                              std::to_string(id.generation) +
                              ") breaks the rule: names a collider of this scene");
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
  const QueryPair pair = order_pair(low, high);
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
  const PairReach reach = reach_of(pair, dt);
  const std::uint64_t key = (static_cast<std::uint64_t>(entry.low) << (kIndexBits + kClusterBits)) |
                            (static_cast<std::uint64_t>(entry.high) << kClusterBits);
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

void CollisionScene::Impl::collect(const pbd::World& world, double dt, pbd::Workers& workers,
                                   std::vector<pbd::Manifold>& out) {
  const std::size_t first = out.size();
  update_order(world);
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
  if (slots > caches_.capacity()) caches_.reserve(slots + slots / 8);
  if (slots > caches_.size()) caches_.resize(slots);
  // Memory for a few more than last time, instead of twice as many when they do not fit.
  const std::size_t expected = first + stats_.manifolds + stats_.manifolds / 16;
  if (expected > out.capacity()) out.reserve(expected + stats_.manifolds / 16);

  std::vector<ColliderPair>& pairs = broad_.pairs();
  if (workers.count() == 1 || pairs.size() <= kPairGrain) {
    for (ColliderPair& pair : pairs) collect_pair(pair, dt, workers_[0], out);
  } else {
    // Each worker writes to a list of its own; the chunks are then put together in order.
    chunks_.resize((pairs.size() + kPairGrain - 1) / kPairGrain);
    workers.for_chunks(pairs.size(), kPairGrain, [&](std::size_t begin, std::size_t end, int w) {
      Worker& worker = workers_[static_cast<std::size_t>(w)];
      Chunk& chunk = chunks_[begin / kPairGrain];
      chunk = {w, worker.found.size(), 0};
      for (std::size_t i = begin; i < end; ++i) collect_pair(pairs[i], dt, worker, worker.found);
      chunk.end = worker.found.size();
    });
    for (const Chunk& chunk : chunks_) {
      const auto from = workers_[static_cast<std::size_t>(chunk.worker)].found.begin();
      out.insert(out.end(), from + static_cast<std::ptrdiff_t>(chunk.begin),
                 from + static_cast<std::ptrdiff_t>(chunk.end));
    }
  }

  stats_ = {};
  for (const Worker& worker : workers_) {
    stats_.colliders += worker.stats.colliders;
    stats_.queries += worker.stats.queries;
    stats_.recycled += worker.stats.recycled;
  }
  stats_.pairs = pairs.size();
  stats_.manifolds = out.size() - first;
  for (std::size_t i = first; i < out.size(); ++i) {
    stats_.points += static_cast<std::size_t>(out[i].count);
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

void CollisionScene::Impl::guard(std::uint32_t index, std::uint32_t near) {
  Collider& collider = colliders_[index];
  if (collider.dynamic && is_thin(colliders_[near], collider)) collider.guarded = kGuardedSteps;
}

CoreHit CollisionScene::Impl::first_hit(Collider& collider, bool bullet,
                                        std::span<const pbd::Pose> after, Worker& worker) const {
  const double radius = core_radius(collider);
  const Vec3 from = core_centre(collider, collider.body);
  const Vec3 to = core_centre(collider, after[collider.def.body.index]);
  const bool fast = (to - from).squaredNorm() > radius * radius;
  if ((!fast && collider.guarded == 0) || !to.allFinite()) return {};
  CoreHit first;
  const Aabb path{from.cwiseMin(to), from.cwiseMax(to)};
  broad_.query(path.expanded(radius), worker.stack, [&](std::uint32_t index) {
    const Collider& target = colliders_[index];
    if (!target.finite || !may_touch(collider, target)) return;
    if (target.dynamic && !bullet) return;
    if (is_thin(target, collider)) collider.guarded = kGuardedSteps;
    // As seen from the target, which itself moves on (a kinematic one too).
    const Vec3 moved = after[target.def.body.index].position - target.body.position;
    if (!moved.allFinite()) return;
    first.take_first(core_cast(from, to - moved, radius, target, worker.list));
  });
  return first;
}

void CollisionScene::Impl::limit_motion(const pbd::World& world, std::span<const pbd::Pose> after,
                                        pbd::Workers& workers,
                                        std::vector<pbd::MotionLimit>& limits) {
  limits.clear();
  workers_.resize(std::max(workers_.size(), static_cast<std::size_t>(workers.count())));
  for (Worker& worker : workers_) worker.limits.clear();
  workers.for_chunks(colliders_.size(), kColliderGrain,
                     [&](std::size_t begin, std::size_t end, int w) {
                       Worker& worker = workers_[static_cast<std::size_t>(w)];
                       for (std::size_t i = begin; i < end; ++i) {
                         Collider& c = colliders_[i];
                         if (!c.alive || !c.dynamic || !c.finite || !c.is_convex() || c.span <= 0.0)
                           continue;
                         if (c.def.body.index >= after.size()) continue;
                         if (c.guarded > 0) --c.guarded;
                         if (!world.awake_at(c.def.body.index)) continue;
                         const bool bullet = world.all_props()[c.def.body.index].bullet;
                         const CoreHit hit = first_hit(c, bullet, after, worker);
                         if (hit.share >= 1.0) continue;
                         worker.limits.push_back({c.def.body.index, hit.share, hit.normal});
                       }
                     });
  for (const Worker& worker : workers_) {
    limits.insert(limits.end(), worker.limits.begin(), worker.limits.end());
  }
  std::sort(limits.begin(), limits.end(), [](const pbd::MotionLimit& l, const pbd::MotionLimit& r) {
    if (l.body != r.body) return l.body < r.body;
    return l.share != r.share ? l.share < r.share : lies_before(l.normal, r.normal);
  });
  limits.erase(std::unique(limits.begin(), limits.end(),
                           [](const pbd::MotionLimit& l, const pbd::MotionLimit& r) {
                             return l.body == r.body;
                           }),
               limits.end());
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
    out.u8(broad_.placed(i) ? 1 : 0);
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
    const bool placed = in.u8() != 0;
    const Aabb fat{in.vec3(), in.vec3()};
    const bool sound = fat.min.allFinite() && fat.max.allFinite();
    if (in.failed() || !sound || (placed && collider.is_half_space())) return false;
    if (placed) {
      broad_.place(i, fat);
    } else {
      broad_.remember_plane(i, fat);
    }
  }
  const std::uint32_t count = in.u32();
  for (std::uint32_t k = 0; k < count && !in.failed(); ++k) {
    const std::uint32_t low = in.u32();
    const std::uint32_t high = in.u32();
    if (low >= high || high >= colliders_.size() || !colliders_[low].alive ||
        !colliders_[high].alive) {
      return false;
    }
    if (!broad_.pairs().empty() && !(broad_.pairs().back() < ColliderPair{low, high, 0, false})) {
      return false;
    }
    const ColliderPair& pair = broad_.append_pair(low, high);
    if (caches_.size() <= pair.cache) caches_.resize(pair.cache + 1);
    if (!load_cache(in, caches_[pair.cache], pool_)) return false;
  }
  return !in.failed();
}

void CollisionScene::Impl::forget() { broad_.reset(); }

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
  // More than there is: the reader keeps the failure for its owner.
  if (!in.failed()) in.bytes(in.remaining() + 1);
}

}  // namespace tandem::collision
