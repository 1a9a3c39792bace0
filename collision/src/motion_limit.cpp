// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <algorithm>

#include "contact_source_impl.h"

namespace tandem::collision {
namespace {

/// Whether a body may be pushed out on the far side.
bool is_thin(const Collider& target, const Collider& collider) {
  return !target.dynamic && target.is_convex() && target.size < 2.0 * collider.size;
}

constexpr std::uint8_t kGuardedSteps = 60;

}  // namespace

void CollisionScene::Impl::guard(std::uint32_t index, std::uint32_t near) {
  Collider& collider = colliders_[index];
  if (collider.dynamic && is_thin(colliders_[near], collider)) collider.guarded = kGuardedSteps;
}

/// m, how far what cannot be pushed moves in this step, at most.
double CollisionScene::Impl::fastest_obstacle(std::span<const pbd::Pose> after) const {
  double fastest = 0.0;
  for (const Collider& c : colliders_) {
    if (!c.alive || c.dynamic || !c.finite || c.def.body.index >= after.size()) continue;
    fastest = std::max(fastest, (after[c.def.body.index].position - c.body.position).norm());
  }
  return fastest;
}

/// @param fastest  m, how far any obstacle moves
CoreHit CollisionScene::Impl::first_hit(Collider& collider, bool bullet, double fastest,
                                        std::span<const pbd::Pose> after, Worker& worker) const {
  const double radius = core_radius(collider);
  const Vec3 from = core_centre(collider, collider.body);
  const Vec3 to = core_centre(collider, after[collider.def.body.index]);
  const auto is_far = [&](const Vec3& way) { return way.squaredNorm() > radius * radius; };
  const bool wary = is_far(to - from) || collider.guarded > 0;
  if ((!wary && (to - from).norm() + fastest <= radius) || !to.allFinite()) return {};
  CoreHit first;
  const Aabb path{from.cwiseMin(to), from.cwiseMax(to)};
  broad_.query(path.expanded(radius), bullet, worker.stack, [&](std::uint32_t index) {
    const Collider& target = colliders_[index];
    if (target.dynamic && !bullet) return;
    if (!target.finite || !may_touch(collider, target)) return;
    // As seen from the target, which itself moves on (a kinematic one too).
    const Vec3 moved = after[target.def.body.index].position - target.body.position;
    if (!moved.allFinite() || (!wary && !is_far(to - from - moved))) return;
    if (is_thin(target, collider)) collider.guarded = kGuardedSteps;
    CoreHit hit = core_cast(from, to - moved, radius, target, worker.list);
    // What may be stopped itself takes nothing along.
    if (!target.dynamic) hit.moved = moved;
    first.take_first(hit);
  });
  return first;
}

void CollisionScene::Impl::limit_motion(const pbd::World& world, std::span<const pbd::Pose> after,
                                        pbd::Workers& workers,
                                        std::vector<pbd::MotionLimit>& limits) {
  limits.clear();
  workers_.resize(std::max(workers_.size(), static_cast<std::size_t>(workers.count())));
  for (Worker& worker : workers_) worker.limits.clear();
  const double fastest = fastest_obstacle(after);
  workers.for_chunks(
      colliders_.size(), kColliderGrain, [&](std::size_t begin, std::size_t end, int w) {
        Worker& worker = workers_[static_cast<std::size_t>(w)];
        for (std::size_t i = begin; i < end; ++i) {
          Collider& c = colliders_[i];
          if (!c.alive || !c.active() || !c.finite || !c.is_convex() || c.motion.span <= 0.0) {
            continue;
          }
          if (c.def.body.index >= after.size()) continue;
          if (c.guarded > 0) --c.guarded;
          if (!world.awake_at(c.def.body.index)) continue;
          const bool bullet = world.all_props()[c.def.body.index].bullet;
          const CoreHit hit = first_hit(c, bullet, fastest, after, worker);
          if (hit.share >= 1.0) continue;
          worker.limits.push_back({c.def.body.index, hit.share, hit.normal, hit.moved});
        }
      });
  for (const Worker& worker : workers_) {
    limits.insert(limits.end(), worker.limits.begin(), worker.limits.end());
  }
  std::sort(limits.begin(), limits.end(), [](const pbd::MotionLimit& l, const pbd::MotionLimit& r) {
    if (l.body != r.body) return l.body < r.body;
    if (l.share != r.share) return l.share < r.share;
    if (l.normal != r.normal) return lies_before(l.normal, r.normal);
    return lies_before(l.obstacle_moves, r.obstacle_moves);
  });
  limits.erase(std::unique(limits.begin(), limits.end(),
                           [](const pbd::MotionLimit& l, const pbd::MotionLimit& r) {
                             return l.body == r.body;
                           }),
               limits.end());
}

}  // namespace tandem::collision
