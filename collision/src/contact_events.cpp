// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/collision/contact_events.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "contact_reading.h"
#include "sensors.h"
#include "tandem/pbd/bytes.h"
#include "tandem/pbd/validate.h"

namespace tandem::collision {
namespace {

constexpr std::uint32_t kMagic = 0x31564554;  // "TEV1"

/// Differences between `before` and `now`; all ascending.
template <class Pair>
void compare(const std::vector<Pair>& before, const std::vector<Pair>& now,
             std::vector<Pair>& begun, std::vector<Pair>& ended) {
  begun.clear();
  ended.clear();
  std::set_difference(now.begin(), now.end(), before.begin(), before.end(),
                      std::back_inserter(begun));
  std::set_difference(before.begin(), before.end(), now.begin(), now.end(),
                      std::back_inserter(ended));
}

void save_id(pbd::ByteWriter& out, const auto& id) {
  out.u32(id.index);
  out.u32(id.generation);
}

void load_id(pbd::ByteReader& in, auto& id) {
  id.index = in.u32();
  id.generation = in.u32();
}

/// @tparam Pair  four ids
template <class Pair>
void save_pairs(pbd::ByteWriter& out, const std::vector<Pair>& pairs) {
  out.u32(static_cast<std::uint32_t>(pairs.size()));
  for (const auto& [a, b, body_a, body_b] : pairs) {
    save_id(out, a);
    save_id(out, b);
    save_id(out, body_a);
    save_id(out, body_b);
  }
}

template <class Pair>
bool load_pairs(pbd::ByteReader& in, std::vector<Pair>& pairs) {
  constexpr std::size_t kBytesPerPair = 4 * 8;
  const std::uint32_t count = in.u32();
  if (in.failed() || count > in.remaining() / kBytesPerPair) return false;
  pairs.assign(count, {});
  for (auto& [a, b, body_a, body_b] : pairs) {
    load_id(in, a);
    load_id(in, b);
    load_id(in, body_a);
    load_id(in, body_b);
  }
  return std::is_sorted(pairs.begin(), pairs.end());
}

}  // namespace

bool ContactEventOptions::validate(std::string* error) const {
  const auto fail = [&](const char* field, double value, const char* rule) {
    if (error != nullptr) {
      *error = pbd::detail::must_be(std::string("ContactEventOptions.") + field, rule, value);
    }
    return false;
  };
  if (!(hit_speed > 0.0) || !std::isfinite(hit_speed)) {
    return fail("hit_speed", hit_speed, "finite and > 0");
  }
  if (!(release_gap >= 0.0) || !std::isfinite(release_gap)) {
    return fail("release_gap", release_gap, "finite and >= 0");
  }
  return true;
}

class __attribute__((visibility("hidden"))) ContactEvents::Impl {
 public:
  explicit Impl(const ContactEventOptions& options) : options_(options) {}

  void update(const pbd::World& world, const CollisionScene& scene) {
    std::swap(touching, touched_);
    touching.clear();
    hits.clear();
    if (world.contacts() != nullptr && world.contact_source() == &scene) {
      read_contacts(*world.contacts(),
                    [&](const ContactReading& reading) { see_contact(world, scene, reading); });
    }
    std::erase_if(hits, [&](const ContactHit& hit) {
      return hit.speed < options_.hit_speed || !(hit.impulse > 0.0);
    });
    compare(touched_, touching, begun, ended);

    std::swap(inside, was_inside_);
    sensors.find(world, scene, inside, passed_);
    compare(was_inside_, inside, sensor_begun, sensor_ended);
    for (const SensorPair& pair : passed_) {
      if (std::binary_search(was_inside_.begin(), was_inside_.end(), pair)) continue;
      sensor_begun.push_back(pair);
      sensor_ended.push_back(pair);
    }
    if (!passed_.empty()) {
      std::sort(sensor_begun.begin(), sensor_begun.end());
      std::sort(sensor_ended.begin(), sensor_ended.end());
    }
  }

  void forget() {
    touching.clear();
    inside.clear();
    sensors.forget();
    begun.clear();
    ended.clear();
    hits.clear();
    sensor_begun.clear();
    sensor_ended.clear();
  }

  std::vector<ContactPair> touching, begun, ended;
  std::vector<ContactHit> hits;
  std::vector<SensorPair> inside, sensor_begun, sensor_ended;
  Sensors sensors;

 private:
  /// The pair of the reading, if its colliders are those of the step.
  static bool name_pair(const CollisionScene& scene, const ContactReading& reading,
                        ContactPair& pair) {
    pair.a = scene.collider_at(reading.low());
    pair.b = scene.collider_at(reading.high());
    if (!pair.a.valid() || !pair.b.valid()) return false;
    pair.body_a = scene.collider(pair.a).body;
    pair.body_b = scene.collider(pair.b).body;
    const auto is = [&](std::uint32_t a, std::uint32_t b) {
      return reading.manifold->body_a == a && reading.manifold->body_b == b;
    };
    return is(pair.body_a.index, pair.body_b.index) || is(pair.body_b.index, pair.body_a.index);
  }

  bool touches(const ContactReading& reading, double gap, const ContactPair& pair) const {
    if (reading.loaded || gap <= 0.0) return true;
    return gap < options_.release_gap && std::binary_search(touched_.begin(), touched_.end(), pair);
  }

  void see_contact(const pbd::World& world, const CollisionScene& scene,
                   const ContactReading& reading) {
    ContactPair pair;
    if (!name_pair(scene, reading, pair)) return;
    const ManifoldGap nearest = gap_of(*reading.manifold, world);
    if (!touches(reading, nearest.gap, pair)) return;
    // The manifolds of one pair are consecutive.
    if (touching.empty() || touching.back() != pair) touching.push_back(pair);
    if (hits.empty() || hits.back().pair != pair) hits.push_back({.pair = pair});
    ContactHit& hit = hits.back();
    hit.impulse += reading.impulse;
    if (reading.approach_speed <= hit.speed) return;
    hit.speed = reading.approach_speed;
    hit.point = nearest.point;
    const bool from_a = reading.manifold->body_a == pair.body_a.index;
    hit.normal = from_a ? reading.manifold->normal : pbd::Vec3(-reading.manifold->normal);
  }

  ContactEventOptions options_;
  std::vector<ContactPair> touched_;  ///< at the last update
  std::vector<SensorPair> was_inside_;
  std::vector<SensorPair> passed_;
};

ContactEvents::ContactEvents(const ContactEventOptions& options) {
  std::string error;
  if (!options.validate(&error)) throw std::invalid_argument(error);
  impl_ = std::make_unique<Impl>(options);
}
ContactEvents::~ContactEvents() = default;
ContactEvents::ContactEvents(ContactEvents&&) noexcept = default;
ContactEvents& ContactEvents::operator=(ContactEvents&&) noexcept = default;

void ContactEvents::update(const pbd::World& world, const CollisionScene& scene) {
  impl_->update(world, scene);
}
std::span<const ContactPair> ContactEvents::begun() const { return impl_->begun; }
std::span<const ContactPair> ContactEvents::ended() const { return impl_->ended; }
std::span<const ContactHit> ContactEvents::hits() const { return impl_->hits; }
std::span<const ContactPair> ContactEvents::touching() const { return impl_->touching; }
std::span<const SensorPair> ContactEvents::sensor_begun() const { return impl_->sensor_begun; }
std::span<const SensorPair> ContactEvents::sensor_ended() const { return impl_->sensor_ended; }
std::span<const SensorPair> ContactEvents::in_sensors() const { return impl_->inside; }

void ContactEvents::save(pbd::ByteWriter& out) const {
  out.u32(kMagic);
  save_pairs(out, impl_->touching);
  save_pairs(out, impl_->inside);
  impl_->sensors.save(out);
}

void ContactEvents::load(pbd::ByteReader& in) {
  impl_->forget();
  if (in.u32() == kMagic && load_pairs(in, impl_->touching) && load_pairs(in, impl_->inside) &&
      impl_->sensors.load(in)) {
    return;
  }
  impl_->forget();
  if (!in.failed()) in.bytes(in.remaining() + 1);  // sets the failure that the owner checks
}

}  // namespace tandem::collision
