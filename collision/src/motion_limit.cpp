// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "motion_limit.h"

#include <algorithm>

#include "core_cast.h"

namespace tandem::collision {
namespace {

/// Colliders that one worker takes at a time.
constexpr std::size_t kChunk = 128;
constexpr std::uint8_t kGuardedSteps = 60;

/// Whether a body may be pushed out on the far side.
bool is_thin(const Collider& target, const Collider& collider) {
  return !target.dynamic && target.is_convex() && target.size < 2.0 * collider.size;
}

/// m, how far what cannot be pushed moves in this step, at most.
double fastest_obstacle(std::span<const Collider> colliders, std::span<const pbd::Pose> after) {
  double fastest = 0.0;
  for (const Collider& c : colliders) {
    if (!c.alive || c.dynamic || !c.finite || c.def.body.index >= after.size()) continue;
    fastest = std::max(fastest, (after[c.def.body.index].position - c.body.position).norm());
  }
  return fastest;
}

/// What a step is about.
struct MotionStep {
  std::span<Collider> colliders;
  const BroadPhase& broad;
  std::span<const pbd::Pose> after;
  double fastest;  ///< m, how far any obstacle moves
};

CoreHit first_hit(const MotionStep& step, Collider& collider, bool bullet,
                  std::vector<std::uint32_t>& stack, std::vector<std::uint32_t>& list) {
  const double radius = core_radius(collider);
  const Vec3 from = core_centre(collider, collider.body);
  const Vec3 to = core_centre(collider, step.after[collider.def.body.index]);
  const auto is_far = [&](const Vec3& way) { return way.squaredNorm() > radius * radius; };
  const bool wary = is_far(to - from) || collider.guarded > 0;
  if ((!wary && (to - from).norm() + step.fastest <= radius) || !to.allFinite()) return {};
  CoreHit first;
  const Aabb path{from.cwiseMin(to), from.cwiseMax(to)};
  step.broad.query(path.expanded(radius), bullet, stack, [&](std::uint32_t index) {
    const Collider& target = step.colliders[index];
    if (target.dynamic && !bullet) return;
    if (!target.finite || !may_touch(collider, target)) return;
    // As seen from the target, which itself moves on (a kinematic one too).
    const Vec3 moved = step.after[target.def.body.index].position - target.body.position;
    if (!moved.allFinite() || (!wary && !is_far(to - from - moved))) return;
    if (is_thin(target, collider)) collider.guarded = kGuardedSteps;
    CoreHit hit = core_cast(from, to - moved, radius, target, list);
    // What may be stopped itself takes nothing along.
    if (!target.dynamic) hit.moved = moved;
    first.take_first(hit);
  });
  return first;
}

}  // namespace

void MotionLimiter::guard(std::span<Collider> colliders, std::span<const ColliderPair> near) {
  const auto guard_one = [](Collider& collider, const Collider& other) {
    if (collider.dynamic && is_thin(other, collider)) collider.guarded = kGuardedSteps;
  };
  for (const ColliderPair& pair : near) {
    guard_one(colliders[pair.low], colliders[pair.high]);
    guard_one(colliders[pair.high], colliders[pair.low]);
  }
}

void MotionLimiter::find(std::span<Collider> colliders, const BroadPhase& broad,
                         const pbd::World& world, std::span<const pbd::Pose> after,
                         pbd::Workers& workers, std::vector<pbd::MotionLimit>& limits) {
  limits.clear();
  workers_.resize(std::max(workers_.size(), static_cast<std::size_t>(workers.count())));
  for (Worker& worker : workers_) worker.limits.clear();
  const MotionStep step{colliders, broad, after, fastest_obstacle(colliders, after)};
  workers.for_chunks(colliders.size(), kChunk, [&](std::size_t begin, std::size_t end, int w) {
    Worker& worker = workers_[static_cast<std::size_t>(w)];
    for (std::size_t i = begin; i < end; ++i) {
      Collider& c = colliders[i];
      if (!c.alive || !c.active() || !c.finite || !c.is_convex() || c.motion.span <= 0.0) {
        continue;
      }
      if (c.def.body.index >= after.size()) continue;
      if (c.guarded > 0) --c.guarded;
      if (!world.awake_at(c.def.body.index)) continue;
      const bool bullet = world.all_props()[c.def.body.index].bullet;
      const CoreHit hit = first_hit(step, c, bullet, worker.stack, worker.list);
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
