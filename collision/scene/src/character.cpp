// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// A translation unit of its own: programs without characters do not link it.
#include "tandem/character.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "clip_planes.h"
#include "tandem/pbd/math.h"
#include "tandem/pbd/portable.h"
#include "tandem/pbd/validate.h"

namespace tandem {
namespace {

using collision::CastHit;
using collision::ClosestHit;
using collision::QueryFilter;
using detail::ClipPlanes;
using detail::kShortest;
using detail::without;

/// m/s: faster bodies are seen too late, and hit the character as a wall.
constexpr double kFastest = 30.0;
/// m, from a touched edge into the collider that the edge belongs to.
constexpr double kBehindEdge = 0.01;

void check(const CharacterDef& def) {
  constexpr std::string_view kKind = "CharacterDef";
  const auto at_least_zero = [&](double value, const char* field) {
    pbd::detail::require(value >= 0.0 && std::isfinite(value), kKind, field, value,
                         "finite and >= 0");
  };
  pbd::detail::require(def.mass > 0.0 && std::isfinite(def.mass), kKind, "mass", def.mass,
                       "finite and > 0");
  at_least_zero(def.max_push, "max_push");
  pbd::detail::require(def.max_slope >= 0.0 && def.max_slope <= 1.5, kKind, "max_slope",
                       def.max_slope, "from 0 to 1.5 rad");
  at_least_zero(def.max_step, "max_step");
  at_least_zero(def.air_acceleration, "air_acceleration");
  pbd::detail::require(def.padding > 0.0 && def.padding < def.shape.radius, kKind, "padding",
                       def.padding, "> 0 and below the radius");
}

}  // namespace

class __attribute__((visibility("hidden"))) Character::Impl {
 public:
  Impl(Scene& in, const CharacterDef& given) : scene(in), def(given) {
    check(def);
    body = scene.add(def.shape, {.type = BodyType::Kinematic,
                                 .pose = {.position = def.position},
                                 .filter = def.filter,
                                 .user_data = def.user_data});
    filter.filter = def.filter;
    filter.ignore_body = body;
    filter.accept = [this](collision::ColliderId id) {
      const BodyId other = scene.shapes().collider(id).body;
      return other != passed && std::find(met.begin(), met.end(), other) == met.end();
    };
  }

  void walk(const Vec3& wanted, double dt);

  Scene& scene;
  CharacterDef def;
  BodyId body;
  Vec3 velocity = Vec3::Zero();  ///< m/s, world; on the ground: that of the last walk()
  double jump_speed = 0.0;       ///< m/s, of the next walk()
  Footing footing = Footing::Air;
  BodyId ground;
  Vec3 ground_normal = Vec3::UnitZ();  ///< of the surface, not of a touched edge
  Vec3 ground_point = Vec3::Zero();    ///< m, world
  Vec3 up = Vec3::UnitZ();

 private:
  /// Motion of a body in the coming step.
  struct Motion {
    Pose from, to;
    Vec3 of(const Vec3& point_w) const { return to.to_world(from.to_local(point_w)) - point_w; }
  };

  std::optional<CastHit> cast(const Vec3& way) const {
    return query->shape_cast(def.shape, {.position = position}, way, filter);
  }
  bool walkable(const Vec3& normal) const {
    return normal.dot(up) >= pbd::portable::sin_cos(def.max_slope).cos;
  }
  /// m, height of its centre above the ground.
  double feet() const { return def.shape.half_height + def.shape.radius + def.padding; }
  bool yields(BodyId id) const { return scene.world().props(id).inverse_mass > 0.0; }
  Vec3 gravity() const { return scene.world().gravity(); }
  double advance(const Vec3& way, std::optional<CastHit>& hit) const;
  Vec3 surface_normal(const CastHit& hit) const;
  Motion motion(BodyId id, double dt) const;
  bool moves(BodyId id, double dt) const;
  void separate();
  void leave_ground();
  double probe(double reach);
  void meet(double dt, const Vec3& carried);
  void strike(const ClosestHit& hit, double dt, const Vec3& carried);
  void slide(Vec3 way, bool stands);
  bool step_up(const Vec3& way);
  bool start(const Vec3& level, const Vec3& carried, double dt);
  void fall(double dt);
  void settle(bool stands, double dt);

  const collision::SceneQuery* query = nullptr;  ///< during walk()
  Vec3 position = Vec3::Zero();                  ///< m, world, during walk()
  Vec3 before = Vec3::Zero();                    ///< m/s, world, after the last walk()
  QueryFilter filter;
  BodyId passed;            ///< skipped by casts
  std::vector<BodyId> met;  ///< skipped by casts: meet() has handled them
  std::vector<ClosestHit> near;
};

/// m, how far the capsule may go along `way` and keep its padding; sets `hit` to the obstacle, or
/// to none if it reaches the end.
double Character::Impl::advance(const Vec3& way, std::optional<CastHit>& hit) const {
  const double length = way.norm();
  const double reach = length + def.padding;
  hit = cast(way * (reach / length));
  if (!hit) return length;
  const double towards = -way.dot(hit->normal) / length;
  if (towards <= 1e-6) {  // moves along it, or out of it
    hit.reset();
    return length;
  }
  const double free = hit->fraction * reach - def.padding / towards;
  if (free >= length) hit.reset();
  return std::clamp(free, 0.0, length);
}

/// Normal of the collider at the hit; at an edge, that of a walkable surface behind it if there is
/// one.
Vec3 Character::Impl::surface_normal(const CastHit& hit) const {
  const Vec3 aside = without(hit.normal, up);
  if (walkable(hit.normal) || aside.norm() < 1e-6) return hit.normal;
  const Vec3 behind = hit.point - kBehindEdge * aside.normalized();
  const auto face = query->ray_cast(
      {.origin = behind + def.padding * up, .direction = -up, .max_distance = 2.0 * def.padding},
      filter);
  return face && face->distance > 0.0 && walkable(face->normal) ? face->normal : hit.normal;
}

Character::Impl::Motion Character::Impl::motion(BodyId id, double dt) const {
  const pbd::World& world = scene.world();
  const pbd::BodyState& state = world.state(id);
  if (const auto target = world.kinematic_target(id)) return {state.pose, *target};
  return {state.pose,
          {state.pose.position + dt * state.twist.linear,
           pbd::rotated(state.pose.orientation, dt * state.twist.angular)}};
}

/// Whether it may be elsewhere after the step.
bool Character::Impl::moves(BodyId id, double dt) const {
  if (yields(id)) return true;
  const Motion its = motion(id, dt);
  return its.from.position != its.to.position ||
         its.from.orientation.coeffs() != its.to.orientation.coeffs();
}

/// Moves out of the padding of its ground, and of immovable bodies.
void Character::Impl::separate() {
  for (int i = 0; i < 4; ++i) {
    near.clear();
    query->closest_all(def.shape, {.position = position}, def.padding, near, filter);
    double most = 0.0;
    for (const ClosestHit& hit : near) {
      if (yields(hit.body) && hit.body != ground) continue;
      position += (def.padding - hit.distance) * hit.normal;
      most = std::max(most, def.padding - hit.distance);
    }
    if (most < 1e-6) return;
  }
}

void Character::Impl::leave_ground() {
  footing = Footing::Air;
  ground = {};
  ground_normal = up;
}

/// Finds the ground within `reach` (m) below the padding. @return m, distance to it
double Character::Impl::probe(double reach) {
  std::optional<CastHit> hit;
  const double down = advance(-reach * up, hit);
  leave_ground();
  if (!hit) return down;
  const Vec3 normal = surface_normal(*hit);
  if (!walkable(normal) && down > def.padding) return down;
  footing = walkable(normal) ? Footing::Ground : Footing::Steep;
  ground = hit->body;
  ground_normal = normal;
  ground_point = hit->point;
  return down;
}

/// Exchanges momentum with moving bodies that it will touch within the step, and limits its own
/// approach to their speed. Later casts skip them, as these would see them at their current place.
void Character::Impl::meet(double dt, const Vec3& carried) {
  met.clear();
  near.clear();
  query->closest_all(def.shape, {.position = position}, def.padding + kFastest * dt, near, filter);
  for (const ClosestHit& hit : near) {
    if (hit.body == ground || !moves(hit.body, dt)) continue;
    strike(hit, dt, carried);
    met.push_back(hit.body);
  }
}

void Character::Impl::strike(const ClosestHit& hit, double dt, const Vec3& carried) {
  pbd::World& world = scene.world();
  const pbd::BodyProps& props = world.props(hit.body);
  const Vec3& n = hit.normal;
  const double gap = hit.distance - def.padding;
  double comes = motion(hit.body, dt).of(hit.on_collider).dot(n) / dt;
  const double goes = (velocity + carried).dot(n);
  if ((comes - goes) * dt <= gap) return;
  if (props.inverse_mass > 0.0) {
    const Vec3 arm = (hit.on_collider - world.pose(hit.body).position).cross(n);
    const Vec3 arm_l = world.pose(hit.body).orientation.conjugate() * arm;
    const double ease = props.inverse_mass + arm_l.dot(props.inverse_inertia * arm_l);
    const double mass = 1.0 / (1.0 / def.mass + ease);
    // A body that runs into it does so with all its momentum, until both have the same velocity.
    // The rest is the character's own push, at any speed.
    const double runs_in = comes - carried.dot(n) - std::max(0.0, (before - carried).dot(n));
    const double blow = std::min((comes - goes) * mass, std::max(0.0, runs_in) * mass);
    const double push = std::min((comes - goes) * mass - blow, def.max_push * dt);
    if (blow > 0.0) world.apply_impulse(hit.body, -blow * n, hit.on_collider);
    // As a force, which friction may resist from the start.
    if (push > 0.0) world.apply_force(hit.body, -push / dt * n, hit.on_collider);
    comes -= ease * (blow + push);
  }
  velocity += std::max(0.0, comes - gap / dt - goes) * n;
}

/// Slides along obstacles, up steps if it stands; the velocity loses the blocked part.
void Character::Impl::slide(Vec3 way, bool stands) {
  ClipPlanes planes;
  for (int i = 0; i < ClipPlanes::kMax && way.norm() > kShortest; ++i) {
    std::optional<CastHit> hit;
    const double length = way.norm();
    const double done = advance(way, hit);
    position += way * (done / length);
    if (!hit) return;
    way *= 1.0 - done / length;
    Vec3 normal = hit->normal;
    if (stands && walkable(normal)) {
      // Up a slope as fast as on level ground.
      way -= up * std::min(0.0, way.dot(normal) / normal.dot(up));
      continue;
    }
    if (stands && !yields(hit->body) && step_up(without(way, up))) return;
    // A slope too steep to walk on is a wall if the motion would climb it.
    const double lift = without(way, normal).dot(up);
    const Vec3 aside = without(normal, up);
    if (normal.dot(up) > 0.0 && lift > std::max(0.0, way.dot(up)) && aside.norm() > 1e-6) {
      normal = aside.normalized();
    }
    if (!planes.add(normal)) return;
    way = planes.clip(way);
    velocity = planes.clip(velocity);
  }
}

/// Up, forward and down again, if that ends on walkable ground.
bool Character::Impl::step_up(const Vec3& way) {
  const double length = way.norm();
  if (length < kShortest || def.max_step == 0.0) return false;
  const Vec3 floor = position;
  std::optional<CastHit> hit;
  const double height = advance(def.max_step * up, hit);
  position += height * up;
  const double on = advance(way, hit);
  position += way * (on / length);
  const double down = height < kShortest ? 0.0 : advance(-height * up, hit);
  if (on > 1e-3 * length && hit && walkable(surface_normal(*hit)) &&
      (hit->point - floor).dot(up) + feet() <= def.max_step) {
    position -= down * up;
    return true;
  }
  position = floor;
  return false;
}

/// Initial velocity of the step: relative to the ground if it stands, else in the world, where half
/// of the gravity increment comes after the step.
bool Character::Impl::start(const Vec3& level, const Vec3& carried, double dt) {
  if (footing == Footing::Ground && jump_speed == 0.0) {
    velocity = level - up * (level.dot(ground_normal) / ground_normal.dot(up));
    // As a force, which supports of the ground may carry within the step.
    if (yields(ground)) scene.world().apply_force(ground, def.mass * gravity(), ground_point);
    return true;
  }
  if (footing == Footing::Ground) {
    velocity = level + carried + jump_speed * up;
    if (yields(ground)) {
      scene.world().apply_impulse(ground, -def.mass * jump_speed * up, ground_point);
    }
  } else {
    const Vec3 lacks = level - without(velocity, up);
    const double change = std::min(lacks.norm(), def.air_acceleration * dt);
    const bool slides = footing == Footing::Steep && level.isZero(0.0);
    if (change > 0.0 && !slides) velocity += change * lacks.normalized();
  }
  fall(0.5 * dt);
  return false;
}

void Character::Impl::fall(double dt) {
  velocity += dt * gravity();
  if (footing == Footing::Steep) {
    velocity -= std::min(0.0, velocity.dot(ground_normal)) * ground_normal;
  }
}

/// Moves down to the ground that it walks on or falls to.
void Character::Impl::settle(bool stands, double dt) {
  met.clear();
  const double rise = std::max(0.0, velocity.dot(up) * dt);  // of a ground that lifts it
  const double down = probe(stands ? def.max_step : def.padding + rise);
  if (footing != Footing::Ground) return;
  const Vec3 floor = motion(ground, dt).of(ground_point) / dt;
  if (!stands && (velocity - floor).dot(up) > 1e-3) {  // moving up
    leave_ground();
    return;
  }
  if (stands) position -= down * up;
}

void Character::Impl::walk(const Vec3& wanted, double dt) {
  pbd::World& world = scene.world();
  const Pose from = world.pose(body);
  query = &scene.query();
  position = from.position;
  if (gravity().norm() > 0.0) up = -gravity().normalized();
  met.clear();
  passed = {};
  separate();
  if (!world.contains(ground)) leave_ground();
  before = velocity;
  const bool stood = footing == Footing::Ground;
  Vec3 carried = Vec3::Zero();
  if (stood) carried = motion(ground, dt).of(ground_point) / dt;
  const bool stands = start(without(wanted, up), carried, dt);
  if (!stands) carried.setZero();
  jump_speed = 0.0;
  meet(dt, carried);
  slide(velocity * dt, stands);
  if (!stands) fall(0.5 * dt);
  settle(stands, dt);
  if (stands && footing == Footing::Ground) {
    // Last, since everything above used the ground's place before the step.
    passed = ground;
    carried = motion(ground, dt).of(ground_point) / dt;
    slide(carried * dt, false);
  }
  velocity += carried;
  world.resume(body, {from, {(position - from.position) / dt, Vec3::Zero()}}, {});
}

Character::Character(Scene& scene, const CharacterDef& def)
    : impl_(std::make_unique<Impl>(scene, def)) {}
Character::~Character() = default;
Character::Character(Character&&) noexcept = default;
Character& Character::operator=(Character&&) noexcept = default;

void Character::walk(const Vec3& velocity, double dt) {
  pbd::detail::require_finite(velocity, "Character::walk", "velocity");
  pbd::detail::require(dt > 0.0 && std::isfinite(dt), "Character::walk", "dt", dt,
                       "finite and > 0");
  impl_->walk(velocity, dt);
}

void Character::jump(double speed) {
  pbd::detail::require(speed >= 0.0 && std::isfinite(speed), "Character::jump", "speed", speed,
                       "finite and >= 0");
  impl_->jump_speed = speed;
}

BodyId Character::body() const { return impl_->body; }
Footing Character::footing() const { return impl_->footing; }
BodyId Character::ground() const { return impl_->ground; }
Vec3 Character::ground_normal() const { return impl_->ground_normal; }
Vec3 Character::velocity() const { return impl_->velocity; }

}  // namespace tandem
