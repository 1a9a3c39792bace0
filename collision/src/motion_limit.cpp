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

CoreHit CollisionScene::Impl::first_hit(Collider& collider, bool bullet,
                                        std::span<const pbd::Pose> after, Worker& worker) const {
  const double radius = core_radius(collider);
  const Vec3 from = core_centre(collider, collider.body);
  const Vec3 to = core_centre(collider, after[collider.def.body.index]);
  const bool fast = (to - from).squaredNorm() > radius * radius;
  if ((!fast && collider.guarded == 0) || !to.allFinite()) return {};
  CoreHit first;
  const Aabb path{from.cwiseMin(to), from.cwiseMax(to)};
  broad_.query(path.expanded(radius), bullet, worker.stack, [&](std::uint32_t index) {
    const Collider& target = colliders_[index];
    if (target.dynamic && !bullet) return;
    if (!target.finite || !may_touch(collider, target)) return;
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

}  // namespace tandem::collision
