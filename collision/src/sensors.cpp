// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "sensors.h"

#include <algorithm>
#include <cmath>

#include "collider_query.h"

namespace tandem::collision {
namespace {

/// Share of its size that a collider must move to pass through something unnoticed.
constexpr double kFast = 0.5;
/// A path longer than the speed explains, by this factor and this share of the size, is a jump.
constexpr double kJump = 2.0;

bool first_child(const Aabb&, const Aabb&) { return false; }

}  // namespace

bool Sensors::sees(std::uint32_t sensor, std::uint32_t visitor) const {
  const ColliderDef& s = colliders_.collider(sensor).def;
  const ColliderDef& v = colliders_.collider(visitor).def;
  return !v.sensor && s.body != v.body && may_meet(s.filter, v.filter);
}

SensorPair Sensors::pair_of(std::uint32_t sensor, std::uint32_t visitor) const {
  return {colliders_.id(sensor), colliders_.id(visitor), colliders_.collider(sensor).def.body,
          colliders_.collider(visitor).def.body};
}

pbd::Vec3 Sensors::way_of(std::uint32_t index, double dt) const {
  if (index >= last_.size() || !last_[index].known || !(dt > 0.0)) return Vec3::Zero();
  const Collider& c = colliders_.collider(index);
  const Last& last = last_[index];
  if (last.generation != c.generation || c.is_half_space()) return Vec3::Zero();
  const Vec3 way = c.position - last.position;
  const double speed = std::max(last.speed, c.travel_within(1.0));
  const bool jumped = way.norm() > kJump * speed * dt + kFast * std::min(c.size, c.reach);
  return jumped ? Vec3(Vec3::Zero()) : way;
}

bool Sensors::passes(std::uint32_t sensor, std::uint32_t visitor) const {
  const Collider& s = colliders_.collider(sensor);
  const Collider& v = colliders_.collider(visitor);
  // The convex one is the probe; it moves in the frame of the other one.
  const bool visitor_moves = v.is_convex();
  if (!visitor_moves && !s.is_convex()) return false;
  const Collider& probe = visitor_moves ? v : s;
  const Collider& other = visitor_moves ? s : v;
  const Vec3 way =
      visitor_moves ? Vec3(way_[visitor] - way_[sensor]) : Vec3(way_[sensor] - way_[visitor]);
  const double length = way.norm();
  if (!(length > 0.0)) return false;
  ConvexCore core = probe.core(probe.position);
  core.centre -= way;
  SurfaceHit hit;
  return cast_collider(other, core, probe.position, way / length, length, MeshSides::Both, hit);
}

void Sensors::find(const pbd::World& world, const CollisionScene& scene,
                   std::vector<SensorPair>& inside, std::vector<SensorPair>& passed) {
  inside.clear();
  passed.clear();
  if (scene.sensor_count() == 0) {
    last_.clear();
    return;
  }
  colliders_.update(world, scene);
  const double dt = world.time() - time_;
  way_.assign(colliders_.size(), Vec3::Zero());
  moving_.clear();
  for (std::uint32_t i = 0; i < colliders_.size(); ++i) {
    if (!colliders_.present(i)) continue;
    way_[i] = way_of(i, dt);
    if (way_[i].norm() > kFast * colliders_.collider(i).size) moving_.push_back(i);
  }
  const auto visit = [&](std::uint32_t s, std::uint32_t v) {
    const Collider& sensor = colliders_.collider(s);
    const Collider& visitor = colliders_.collider(v);
    if (!sees(s, v) || (is_static(sensor, world) && is_static(visitor, world))) return;
    if (colliders_overlap(sensor, visitor)) inside.push_back(pair_of(s, v));
  };
  for (std::uint32_t s = 0; s < colliders_.size(); ++s) {
    if (!colliders_.present(s) || !colliders_.collider(s).def.sensor) continue;
    const Collider& sensor = colliders_.collider(s);
    const auto near = [&](const Aabb& box) {
      return sensor.is_half_space() || box.overlaps(sensor.needed);
    };
    colliders_.tree().walk(first_child, near, [&](std::uint32_t v) { visit(s, v); });
    for (const std::uint32_t v : colliders_.half_spaces()) visit(s, v);
  }
  std::sort(inside.begin(), inside.end());

  // A half-space cannot be passed through.
  for (const std::uint32_t m : moving_) {
    const Collider& mover = colliders_.collider(m);
    const Aabb before{mover.needed.min - way_[m], mover.needed.max - way_[m]};
    const Aabb swept = mover.needed.merged(before);
    colliders_.tree().walk(
        first_child, [&](const Aabb& box) { return box.overlaps(swept); },
        [&](std::uint32_t other) {
          if (mover.def.sensor == colliders_.collider(other).def.sensor) return;
          const std::uint32_t s = mover.def.sensor ? m : other;
          const std::uint32_t v = mover.def.sensor ? other : m;
          if (!sees(s, v)) return;
          const SensorPair pair = pair_of(s, v);
          if (std::binary_search(inside.begin(), inside.end(), pair)) return;
          if (passes(s, v)) passed.push_back(pair);
        });
  }
  std::sort(passed.begin(), passed.end());
  passed.erase(std::unique(passed.begin(), passed.end()), passed.end());
  remember(world);
}

void Sensors::remember(const pbd::World& world) {
  time_ = world.time();
  last_.resize(colliders_.size());
  for (std::uint32_t i = 0; i < colliders_.size(); ++i) {
    last_[i] = {};
    if (!colliders_.present(i)) continue;
    const Collider& c = colliders_.collider(i);
    last_[i] = {true, c.generation, c.position, c.travel_within(1.0)};
  }
}

void Sensors::forget() {
  last_.clear();
  time_ = 0.0;
}

void Sensors::save(pbd::ByteWriter& out) const {
  out.f64(time_);
  out.u32(static_cast<std::uint32_t>(last_.size()));
  for (const Last& last : last_) {
    out.u8(last.known ? 1 : 0);
    out.u32(last.generation);
    out.vec3(last.position);
    out.f64(last.speed);
  }
}

bool Sensors::load(pbd::ByteReader& in) {
  constexpr std::size_t kBytesPerEntry = 1 + 4 + 24 + 8;
  time_ = in.f64();
  const std::uint32_t count = in.u32();
  if (in.failed() || !std::isfinite(time_) || count > in.remaining() / kBytesPerEntry) return false;
  last_.assign(count, {});
  for (Last& last : last_) {
    last.known = in.u8() != 0;
    last.generation = in.u32();
    last.position = in.vec3();
    last.speed = in.f64();
    if (!last.position.allFinite() || !std::isfinite(last.speed)) return false;
  }
  return !in.failed();
}

}  // namespace tandem::collision
