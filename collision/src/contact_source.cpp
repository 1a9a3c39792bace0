// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/collision/contact_source.h"

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <typeinfo>
#include <utility>

#include "broad_phase.h"
#include "collider.h"
#include "material_io.h"
#include "motion_limit.h"
#include "pair_contacts.h"
#include "tandem/pbd/by_body.h"
#include "tandem/pbd/change_count.h"
#include "tandem/pbd/validate.h"
#include "watched_colliders.h"

namespace tandem::collision {
namespace {

/// Colliders per chunk of a worker.
constexpr std::size_t kColliderGrain = 128;
constexpr std::uint32_t kCacheMagic = 0x35434354;  // "TCC5"

/// @throws std::invalid_argument naming field, value and rule
void check_def(const pbd::World& world, const ColliderDef& def) {
  pbd::detail::require_body(world, def.body, "ColliderDef", "body");
  std::string error;
  if (!validate(def.shape, &error)) throw std::invalid_argument("ColliderDef: shape: " + error);
  pbd::detail::require_finite(def.local.position, "ColliderDef", "local.position");
  pbd::detail::require_unit(def.local.orientation, "ColliderDef", "local.orientation");
  if (!def.material.validate(&error)) throw std::invalid_argument("ColliderDef: " + error);
}

}  // namespace

bool CollisionOptions::validate(std::string* error) const {
  const auto in = [&](const char* field, double value, double low, double high) {
    return pbd::detail::in_range(value, low, high, std::string("CollisionOptions.") + field, error);
  };
  return in("speculative_margin", speculative_margin, 0.0, 10.0) &&
         in("recycle_distance", recycle_distance, 0.0, 1.0) &&
         in("recycle_angle", recycle_angle, 0.0, 0.2);
}

/// State that a copy takes over as it is.
struct __attribute__((visibility("hidden"))) SceneState {
  CollisionOptions options;
  CollisionStats stats;
  std::vector<Collider> colliders;
  pbd::ByBody by_body;  ///< index of colliders
  std::vector<std::uint32_t> free;
  WatchedColliders watched;
  std::size_t sensor_count = 0;
  pbd::ChangeCount changes;
  std::uint64_t collected = 0;  ///< its value in the last collect()
  std::uint64_t added = 0;
  std::int32_t next_group = std::numeric_limits<std::int32_t>::min();
  bool order_is_old = true;
  bool natural_order = true;
  /// The state was loaded, in the order of the world that comes with it.
  bool restored = false;
  std::uint64_t sleepers_moved = 0;  ///< see World::sleepers_moved()
};

/// The colliders of a scene, and the stages that find pairs, contacts and tunnelling.
class __attribute__((visibility("hidden"))) CollisionScene::Impl : public SceneState {
 public:
  bool contains(ColliderId id) const {
    return id.index < colliders.size() && colliders[id.index].alive &&
           colliders[id.index].generation == id.generation;
  }
  /// @return the collider's slot
  std::uint32_t checked(ColliderId id, const char* what) const;
  void update_order(const pbd::World& world);
  void look_again_at(std::uint32_t body);
  void look_again(std::uint32_t index) {
    broad.look_again(index);
    watched.add(index);
  }
  void sum_stats(std::span<const pbd::Manifold> found);
  bool load(pbd::ByteReader& in);
  void forget();

  BroadPhase broad;
  PairContacts contacts;
  MotionLimiter limiter;
  Beginning beginning;
};

std::uint32_t CollisionScene::Impl::checked(ColliderId id, const char* what) const {
  if (contains(id)) return id.index;
  pbd::detail::refuse(std::string("CollisionScene::") + what + ": id", "a collider of this scene",
                      "collider " + std::to_string(id.index) + " (generation " +
                          std::to_string(id.generation) + ")");
}

void CollisionScene::Impl::update_order(const pbd::World& world) {
  const pbd::BodyOrder order = world.order();
  if (!order_is_old && natural_order == order.natural()) return;
  order_is_old = false;
  // Only here colliders change places; a cache does not store which of two was the first.
  if (natural_order != order.natural() && !restored) {
    broad.reset();
    watched.forget();
  }
  restored = false;
  natural_order = order.natural();
  put_in_order(colliders, order);
}

void CollisionScene::Impl::look_again_at(std::uint32_t body) {
  by_body.for_rows(body, [&](std::uint32_t row, std::uint32_t) { look_again(row); });
}

void CollisionScene::Impl::sum_stats(std::span<const pbd::Manifold> found) {
  stats = {.colliders = colliders.size() - free.size(),
           .looked_at = watched.list().size(),
           .searches = broad.searches(),
           .pairs = broad.pairs().size(),
           .queries = contacts.queries(),
           .recycled = contacts.recycled(),
           .manifolds = found.size()};
  for (const pbd::Manifold& manifold : found) {
    stats.points += static_cast<std::size_t>(manifold.count);
  }
}

CollisionScene::CollisionScene(const CollisionOptions& options) {
  std::string error;
  if (!options.validate(&error)) throw std::invalid_argument(error);
  impl_ = std::make_unique<Impl>();
  impl_->options = options;
}
CollisionScene::~CollisionScene() = default;
CollisionScene::CollisionScene(CollisionScene&&) noexcept = default;
CollisionScene& CollisionScene::operator=(CollisionScene&& other) noexcept {
  if (impl_ != nullptr && other.impl_ != nullptr) other.impl_->changes = impl_->changes;
  impl_ = std::move(other.impl_);
  return *this;
}

void CollisionScene::reserve(std::size_t colliders) { impl_->colliders.reserve(colliders); }

ColliderId CollisionScene::add(const pbd::World& world, const ColliderDef& def) {
  Impl& m = *impl_;
  check_def(world, def);
  Collider made = make_collider(def, m.options);  // the def may belong to a collider of this scene
  std::uint32_t index = 0;
  if (m.free.empty()) {
    index = static_cast<std::uint32_t>(m.colliders.size());
    if (index >= (1u << kIndexBits)) {
      pbd::detail::refuse("ColliderDef: count", "below 2^26", index);
    }
    m.colliders.emplace_back();
    m.free.reserve(m.colliders.capacity());
  } else {
    index = m.free.back();
    m.free.pop_back();
  }
  made.generation = m.colliders[index].generation;
  made.added = m.added++;
  made.rank = {index, made.def.body.index};
  const pbd::BodyType type = world.all_props()[made.def.body.index].type;
  made.dynamic = type == pbd::BodyType::Dynamic;
  if (type != pbd::BodyType::Static) made.own_motion.made();
  if (made.def.sensor) ++m.sensor_count;
  Collider& collider = m.colliders[index] = std::move(made);
  m.order_is_old = m.order_is_old || !m.natural_order;
  m.changes.note();
  m.by_body.add(index, collider.def.body.index);
  m.broad.add(index, collider);
  m.watched.add(index);
  return {index, collider.generation};
}

void CollisionScene::remove(ColliderId id) {
  Impl& m = *impl_;
  Collider& collider = m.colliders[m.checked(id, "remove")];
  if (collider.def.sensor) --m.sensor_count;
  m.broad.remove(id.index, collider);
  m.by_body.remove(id.index);
  const std::uint32_t generation = collider.generation + 1;
  m.order_is_old = m.order_is_old || !m.natural_order;
  m.changes.note();
  collider = {};
  collider.generation = generation;
  m.free.push_back(id.index);
}

void CollisionScene::set_material(ColliderId id, const Material& material) {
  Collider& collider = impl_->colliders[impl_->checked(id, "set_material")];
  std::string error;
  if (!material.validate(&error)) {
    throw std::invalid_argument("CollisionScene::set_material: " + error);
  }
  collider.def.material = material;
  impl_->changes.note();
}

bool CollisionScene::repeats() const {
  return typeid(*this) == typeid(CollisionScene) && impl_->collected == impl_->changes.value();
}

void CollisionScene::set_filter(ColliderId id, const Filter& filter) {
  impl_->colliders[impl_->checked(id, "set_filter")].def.filter = filter;
  impl_->look_again(id.index);
  impl_->changes.note();
}

void CollisionScene::set_user_data(ColliderId id, std::uint64_t value) {
  impl_->colliders[impl_->checked(id, "set_user_data")].def.user_data = value;
}

void CollisionScene::set_apart(const pbd::World& world, pbd::BodyId a, pbd::BodyId b, bool apart) {
  pbd::detail::require_body(world, a, "CollisionScene::set_apart", "a");
  pbd::detail::require_body(world, b, "CollisionScene::set_apart", "b");
  pbd::detail::require(a != b, "CollisionScene::set_apart", "b", b.index, "another body than a");
  if (impl_->broad.apart.name(pbd::BodyPair::of(a.index, b.index), apart)) impl_->changes.note();
}

bool CollisionScene::is_apart(pbd::BodyId a, pbd::BodyId b) const {
  return impl_->broad.apart.named(a.index, b.index);
}

std::vector<pbd::BodyPair> CollisionScene::apart() const {
  const auto pairs = impl_->broad.apart.named();
  return {pairs.begin(), pairs.end()};
}

bool CollisionScene::contains(ColliderId id) const { return impl_->contains(id); }
const ColliderDef& CollisionScene::collider(ColliderId id) const {
  return impl_->colliders[impl_->checked(id, "collider")].def;
}
ColliderId CollisionScene::collider_at(std::uint32_t index) const {
  if (index >= impl_->colliders.size() || !impl_->colliders[index].alive) return {};
  return {index, impl_->colliders[index].generation};
}
std::uint32_t CollisionScene::slot_count() const {
  return static_cast<std::uint32_t>(impl_->colliders.size());
}
std::size_t CollisionScene::sensor_count() const { return impl_->sensor_count; }

std::int32_t CollisionScene::new_group() {
  Impl& m = *impl_;
  std::vector<std::int32_t> taken;
  for (const Collider& collider : m.colliders) {
    if (collider.def.filter.group < 0) taken.push_back(collider.def.filter.group);
  }
  std::sort(taken.begin(), taken.end());
  for (const std::int32_t group : taken) {
    if (group == m.next_group) ++m.next_group;
  }
  if (m.next_group >= 0) {
    pbd::detail::refuse("CollisionScene::new_group: number of groups", "at most 2^31", "more");
  }
  return m.next_group++;
}

std::uint64_t CollisionScene::changes() const { return impl_->changes.value(); }
const CollisionOptions& CollisionScene::options() const { return impl_->options; }
const CollisionStats& CollisionScene::stats() const { return impl_->stats; }

void CollisionScene::collect(const pbd::World& world, double dt, pbd::Workers& workers,
                             std::vector<pbd::Manifold>& out) {
  Impl& m = *impl_;
  const std::size_t first = out.size();
  m.update_order(world);
  m.broad.apart.update(world, [&](std::uint32_t body) { m.look_again_at(body); });
  m.watched.update(world, m.colliders, m.by_body);
  const std::span<const std::uint32_t> watched = m.watched.list();
  if (std::exchange(m.sleepers_moved, world.sleepers_moved()) != world.sleepers_moved()) {
    for (const std::uint32_t i : watched) m.colliders[i].asleep = false;
  }
  workers.for_chunks(watched.size(), kColliderGrain, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t k = begin; k < end; ++k) {
      Collider& collider = m.colliders[watched[k]];
      if (collider.alive) update_collider(collider, world, dt);
    }
  });
  m.broad.update(m.colliders, watched, dt, workers);
  MotionLimiter::guard(m.colliders, m.broad.found());
  m.contacts.grow(m.broad.cache_slots());
  // Grown while empty: there is nothing to copy.
  const std::size_t expected = first + m.stats.manifolds + m.stats.manifolds / 16;
  if (expected > out.capacity() && first == 0) out = {};
  if (expected > out.capacity()) out.reserve(2 * expected);

  m.contacts.collect(m.colliders, m.broad.pairs(), m.options.recycle_angle, dt, workers, out);
  m.sum_stats(std::span(out).subspan(first));
  m.watched.leave_still(world, m.colliders);
  if (m.beginning.is_over(m.added)) {
    m.broad.trim();
    m.watched.trim();
    m.limiter.trim();
  }
  m.collected = m.changes.value();
}

void CollisionScene::limit_motion(const pbd::World& world, std::span<const pbd::Pose> after,
                                  pbd::Workers& workers, std::vector<pbd::MotionLimit>& limits) {
  impl_->limiter.find(impl_->colliders, impl_->watched.list(), impl_->broad, world, after, workers,
                      limits);
}

void CollisionScene::remove_body(pbd::BodyId body) {
  Impl& m = *impl_;
  for (const std::uint32_t i : m.by_body.rows_of(body.index)) {
    if (m.colliders[i].def.body == body) remove({i, m.colliders[i].generation});
  }
  m.broad.apart.remove_body(body.index);
}

void CollisionScene::save(pbd::ByteWriter& out) const {
  Impl& m = *impl_;
  out.u32(kCacheMagic);
  out.u32(static_cast<std::uint32_t>(m.colliders.size()));
  for (std::uint32_t i = 0; i < m.colliders.size(); ++i) {
    const Collider& collider = m.colliders[i];
    out.u8(collider.alive ? 1 : 0);
    if (!collider.alive) continue;
    out.u32(collider.def.body.index);
    out.u8(static_cast<std::uint8_t>(collider.kind));
    save_surface(out, collider.def.material, collider.def.filter);
    out.u8(collider.guarded);
    out.u8(m.broad.placed_fixed(i) ? 2 : m.broad.placed(i) ? 1 : 0);
    out.vec3(m.broad.fat_box(i).min);
    out.vec3(m.broad.fat_box(i).max);
  }
  m.broad.apart.save(out);
  out.u32(static_cast<std::uint32_t>(m.broad.pairs().size()));
  for (const ColliderPair& pair : m.broad.pairs()) {
    out.u32(pair.low);
    out.u32(pair.high);
    m.contacts.save(out, pair.cache);
  }
}

bool CollisionScene::Impl::load(pbd::ByteReader& in) {
  order_is_old = true;
  changes.note();
  restored = true;
  if (in.u32() != kCacheMagic || in.u32() != colliders.size()) return false;
  for (std::uint32_t i = 0; i < colliders.size(); ++i) {
    Collider& collider = colliders[i];
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
      broad.place(i, fat, place == 2);
    } else {
      broad.remember_plane(i, fat);
    }
  }
  if (!broad.apart.load(in)) return false;
  const std::uint32_t count = in.u32();
  for (std::uint32_t k = 0; k < count && !in.failed(); ++k) {
    const std::uint32_t low = in.u32();
    const std::uint32_t high = in.u32();
    if (low >= high || high >= colliders.size() || !broad.meet(colliders[low], colliders[high])) {
      return false;
    }
    if (!broad.pairs().empty() && !(broad.pairs().back() < ColliderPair{low, high, 0, false})) {
      return false;
    }
    const ColliderPair& pair = broad.append_pair(low, high);
    const bool boxes = colliders[low].kind == Kind::Box && colliders[high].kind == Kind::Box;
    contacts.grow(pair.cache + 1);
    if (!contacts.load(in, pair.cache, boxes)) return false;
  }
  return !in.failed();
}

void CollisionScene::Impl::forget() {
  broad.reset();
  watched.forget();
  for (Collider& collider : colliders) collider.asleep = false;
}

void CollisionScene::load(pbd::ByteReader& in) {
  impl_->forget();
  if (impl_->load(in)) return;
  impl_->forget();
  in.fail();
}

bool CollisionScene::fits(const pbd::World& world) const {
  const auto is_body = [&](std::uint32_t slot) { return world.body_at(slot).valid(); };
  const auto pairs = impl_->broad.apart.named();
  return std::all_of(impl_->colliders.begin(), impl_->colliders.end(),
                     [&](const Collider& c) { return !c.alive || is_body(c.def.body.index); }) &&
         std::all_of(pairs.begin(), pairs.end(), [&](const pbd::BodyPair& pair) {
           return is_body(pair.low) && is_body(pair.high);
         });
}

std::unique_ptr<pbd::ContactSource> CollisionScene::make_empty() const {
  if (typeid(*this) != typeid(CollisionScene)) return nullptr;
  return std::make_unique<CollisionScene>(options());
}

bool CollisionScene::assign(const pbd::ContactSource& source) {
  const auto* other = dynamic_cast<const CollisionScene*>(&source);
  if (other == nullptr) return false;
  if (other == this) return true;
  Impl& m = *impl_;
  const std::int32_t next_group = std::max(m.next_group, other->impl_->next_group);
  static_cast<SceneState&>(m) = *other->impl_;
  m.next_group = next_group;           // groups given out before stay taken
  m.free.reserve(m.colliders.size());  // as in add(): removal must not allocate
  m.broad.assign(other->impl_->broad);
  m.contacts.assign(other->impl_->contacts);
  return true;
}

}  // namespace tandem::collision
