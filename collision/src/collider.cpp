// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "collider.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "tandem/pbd/portable.h"

namespace tandem::collision {
namespace {

/// m, stands for no bound: far above every valid size, but its square does not overflow.
constexpr double kHuge = 1e9;

// Shares of a collider's least extent: speculative margin, and motion of its parts before a contact
// is found again. For small bodies, whose margins would be as large as the bodies.
constexpr double kSpeculativeSizeShare = 0.25;
constexpr double kRecycleSizeShare = 0.02;

struct Sizes {
  double size;
  double reach;  // from the shape's origin
  Kind kind;
};

Sizes sizes_of(const Shape& shape) {
  if (const auto* s = std::get_if<Sphere>(&shape))
    return {2.0 * s->radius, s->radius, Kind::Sphere};
  if (const auto* c = std::get_if<Capsule>(&shape)) {
    return {2.0 * c->radius, c->radius + c->half_height, Kind::Capsule};
  }
  if (const auto* b = std::get_if<Box>(&shape)) {
    return {2.0 * b->half_extents.minCoeff(), b->half_extents.norm(), Kind::Box};
  }
  if (const auto* c = std::get_if<Cylinder>(&shape)) {
    return {2.0 * std::min(c->radius, c->half_height),
            pbd::portable::hypot(c->radius, c->half_height), Kind::Cylinder};
  }
  if (const auto* c = std::get_if<Cone>(&shape)) {
    return {std::min(2.0 * c->radius, 2.0 * c->half_height),
            pbd::portable::hypot(c->radius, c->half_height), Kind::Cone};
  }
  if (const auto* h = std::get_if<Hull>(&shape)) {
    return {(*h)->extent(), (*h)->centre().norm() + (*h)->reach(), Kind::Polytope};
  }
  if (const auto* f = std::get_if<Field>(&shape)) {
    const Aabb& bounds = (*f)->bounds();
    return {kHuge, bounds.min.cwiseAbs().cwiseMax(bounds.max.cwiseAbs()).norm(), Kind::Grid};
  }
  if (const auto* m = std::get_if<Mesh>(&shape)) {
    const Aabb& bounds = (*m)->bounds();
    return {kHuge, bounds.min.cwiseAbs().cwiseMax(bounds.max.cwiseAbs()).norm(), Kind::Triangles};
  }
  return {kHuge, kHuge, Kind::HalfSpace};
}

Aabb bounds_of(const Collider& c) {
  Vec3 centre = c.position;
  Vec3 extent = Vec3::Zero();
  const auto place = [&](const Aabb& bounds) {
    centre += c.rotation * (0.5 * (bounds.min + bounds.max));
    extent = c.rotation.cwiseAbs() * (0.5 * (bounds.max - bounds.min));
  };
  if (const auto* s = std::get_if<Sphere>(&c.def.shape)) {
    extent = Vec3::Constant(s->radius);
  } else if (const auto* k = std::get_if<Capsule>(&c.def.shape)) {
    extent = Vec3::Constant(k->radius) + k->half_height * c.rotation.col(2).cwiseAbs();
  } else if (const auto* b = std::get_if<Box>(&c.def.shape)) {
    extent = c.rotation.cwiseAbs() * b->half_extents;
  } else if (const auto* m = std::get_if<Mesh>(&c.def.shape)) {
    place((*m)->bounds());
  } else if (const auto* f = std::get_if<Field>(&c.def.shape)) {
    place((*f)->bounds());
  } else if (c.is_convex()) {
    const ConvexCore core = c.core(c.position);
    for (int i = 0; i < 3; ++i) {
      const double high = core.reach(Vec3::Unit(i));
      const double low = core.reach(-Vec3::Unit(i));
      centre[i] += 0.5 * (high - low);
      extent[i] = 0.5 * (high + low);
    }
  }
  return {centre - extent, centre + extent};
}

}  // namespace

double Collider::travel_within(double dt) const {
  // A half-space extends everywhere: its rotation is handled pair by pair.
  const double turning = is_half_space() ? 0.0 : motion().twist.angular.norm() * reach;
  return (motion().twist.linear.norm() + turning) * dt;
}

ConvexCore Collider::core(const Vec3& origin) const {
  ConvexCore core;
  core.centre = position - origin;
  core.axes = rotation;
  core.size = size;
  if (const auto* s = std::get_if<Sphere>(&def.shape)) {
    core.kind = CoreKind::Point;
    core.radius = s->radius;
  } else if (const auto* c = std::get_if<Capsule>(&def.shape)) {
    core.kind = CoreKind::Segment;
    core.radius = c->radius;
    core.half = Vec3(0.0, 0.0, c->half_height);
  } else if (const auto* box = std::get_if<Box>(&def.shape)) {
    core.kind = CoreKind::Box;
    core.half = box->half_extents;
  } else if (const auto* cylinder = std::get_if<Cylinder>(&def.shape)) {
    core.kind = CoreKind::Cylinder;
    core.half = Vec3(cylinder->radius, cylinder->radius, cylinder->half_height);
  } else if (const auto* cone = std::get_if<Cone>(&def.shape)) {
    core.kind = CoreKind::Cone;
    core.half = Vec3(cone->radius, cone->radius, cone->half_height);
  } else {
    core.kind = CoreKind::Polytope;
    core.hull = std::get<Hull>(def.shape).get();
    core.centre += rotation * core.hull->centre();
  }
  return core;
}

Collider make_collider(const ColliderDef& def, const CollisionOptions& options) {
  Collider c;
  c.def = def;
  c.def.local.orientation.normalize();
  if (auto* plane = std::get_if<HalfSpace>(&c.def.shape)) plane->normal.normalize();
  c.alive = true;
  const Sizes sizes = sizes_of(def.shape);
  c.kind = sizes.kind;
  c.local_identity = c.def.local.position.isZero(0.0) && c.def.local.orientation.w() == 1.0 &&
                     c.def.local.orientation.vec().isZero(0.0);
  c.size = sizes.size;
  c.reach = sizes.reach + def.local.position.norm();
  c.margins.speculative = std::min(options.speculative_margin, kSpeculativeSizeShare * c.size);
  c.margins.recycle = std::min(options.recycle_distance, kRecycleSizeShare * c.size);
  return c;
}

void put_in_order(std::span<Collider> colliders, const pbd::BodyOrder& order) {
  for (std::uint32_t i = 0; i < colliders.size(); ++i) {
    colliders[i].rank.own = i;
    colliders[i].rank.body = order.rank(colliders[i].def.body.index);
  }
  if (order.natural()) return;
  std::vector<std::uint32_t> sorted;
  for (std::uint32_t i = 0; i < colliders.size(); ++i) sorted.push_back(i);
  std::sort(sorted.begin(), sorted.end(), [&](std::uint32_t l, std::uint32_t r) {
    const auto place = [&](std::uint32_t i) {
      return std::pair(colliders[i].rank.body, colliders[i].added);
    };
    return place(l) < place(r);
  });
  for (std::uint32_t rank = 0; rank < sorted.size(); ++rank)
    colliders[sorted[rank]].rank.own = rank;
}

bool same_state(const Collider& c, const pbd::BodyState& state) {
  return state.pose.position == c.body.position &&
         state.pose.orientation.coeffs() == c.body.orientation.coeffs() &&
         state.twist.linear == c.motion().twist.linear &&
         state.twist.angular == c.motion().twist.angular;
}

bool is_static(const Collider& collider, const pbd::World& world) {
  return world.all_props()[collider.def.body.index].type == pbd::BodyType::Static;
}

void update_collider(Collider& c, const pbd::World& world, double dt) {
  // Its body may have been removed while the scene was not the world's.
  if (!world.contains(c.def.body)) {
    c.finite = c.still = c.asleep = false;
    return;
  }
  const pbd::BodyState& state = world.states()[c.def.body.index];
  const bool asleep = !world.awake_at(c.def.body.index);
  // Moves of sleeping bodies are reported by World::sleepers_moved(); all others wake them.
  if (asleep && c.asleep) {
    c.still = true;
    return;
  }
  const pbd::BodyType type = world.all_props()[c.def.body.index].type;
  c.dynamic = type == pbd::BodyType::Dynamic;
  const bool unchanged = c.finite && same_state(c, state);
  const bool at_rest = state.twist.linear.isZero(0.0) && state.twist.angular.isZero(0.0);
  c.asleep = asleep && at_rest && c.dynamic;
  c.still = unchanged && at_rest;
  const bool goes = type != pbd::BodyType::Static || !at_rest || c.own_motion.get() != nullptr;
  const bool known = c.own_motion.get() != nullptr || !goes;
  if (known && (c.still || (unchanged && c.motion().span == dt))) return;
  c.body = state.pose;
  c.rotation = state.pose.orientation.toRotationMatrix();
  if (!c.local_identity) c.rotation *= c.local_rotation();
  c.position = c.local_identity ? state.pose.position : state.pose.to_world(c.def.local.position);
  if (goes) {
    ColliderMotion& motion = c.own_motion.made();
    motion.twist = state.twist;
    motion.span = dt;
    motion.turn = motion.twist.angular.norm() * dt;
    motion.travel = c.travel_within(dt);
  }
  c.finite = c.rotation.allFinite() && c.position.allFinite() && std::isfinite(c.motion().travel);
  c.asleep = c.asleep && c.finite;
  if (!c.finite || c.is_half_space()) return;
  // Current bounds, bounds at the end, and what rotation may add in between.
  const Vec3 sweep = dt * c.motion().twist.linear;
  // Half of the margins: a pair uses the smaller of two.
  const Aabb bounds = bounds_of(c).expanded(0.5 * (c.margins.speculative + c.margins.recycle) +
                                            c.motion().turn * c.reach);
  c.needed = {bounds.min + sweep.cwiseMin(0.0), bounds.max + sweep.cwiseMax(0.0)};
}

}  // namespace tandem::collision
