// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "groups.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "tandem/pbd/math.h"

namespace tandem::pbd {
namespace {

/// Steps in a row that must have been easy before an island gets fewer substeps again.
constexpr int kCalmSteps = 8;

/// What springs or motors act on is at rest where it would take this many times as long to come to
/// the speed at which it counts as moving: a heavy body starts slowly.
constexpr double kSteady = 50.0;

/// A body that a remote peer sees further away than this is not at rest: m and rad.
constexpr double kRestingDistance = 1e-3;
constexpr double kRestingAngle = 0.0175;

bool disagrees(const PoseTarget& target, const SolverBody& body) {
  const double angle = target.use_rotation_error
                           ? target.rotation_error.norm()
                           : rotation_between(body.q, target.pose.orientation).norm();
  return (target.pose.position - body.x).norm() > kRestingDistance || angle > kRestingAngle;
}

bool moves(const SolverBody& body) { return !body.v.isZero(0.0) || !body.w.isZero(0.0); }

}  // namespace

void Groups::arrange(const Rule& rule, const Islands& islands,
                     std::span<const std::uint32_t> changed, std::span<const ConstraintEdge> edges,
                     std::span<const PoseTarget> targets, std::span<const BodyProps> props,
                     std::span<BodyActivity> activity, std::span<SolverBody> bodies) {
  const bool pushed = sum_islands(rule, islands, activity, bodies);
  if (rule.sleep_after > 0.0) wake_islands(changed, targets, bodies);
  if (rule.sleep_after > 0.0 && pushed) disturb(edges, bodies);
  form_groups(rule, props, activity, bodies);
}

bool Groups::sum_islands(const Rule& rule, const Islands& islands,
                         std::span<const BodyActivity> activity, std::span<SolverBody> bodies) {
  const auto count = static_cast<std::uint32_t>(bodies.size());
  islands_.assign(count, {});
  bool pushed = false;
  for (std::uint32_t i = 0; i < count; ++i) {
    bodies[i].island = islands.of()[i];
    if (bodies[i].inv_mass == 0.0) {
      pushed = pushed || moves(bodies[i]);
      continue;
    }
    Island& island = islands_[bodies[i].island];
    const bool awake = activity[i].awake || rule.sleep_after == 0.0;
    island.awake = island.awake || awake || moves(bodies[i]);
    island.level_sum += activity[i].level;
    ++island.bodies;
  }
  for (Island& island : islands_) {
    if (island.bodies == 0) continue;
    island.level =
        static_cast<std::uint8_t>((2 * island.level_sum + island.bodies) / (2 * island.bodies));
  }
  return pushed;
}

void Groups::wake_islands(std::span<const std::uint32_t> changed,
                          std::span<const PoseTarget> targets, std::span<const SolverBody> bodies) {
  for (const std::uint32_t i : changed) {
    if (i < bodies.size() && bodies[i].inv_mass > 0.0) islands_[bodies[i].island].awake = true;
  }
  for (const PoseTarget& target : targets) {
    const SolverBody& body = bodies[target.body.index];
    if (body.inv_mass > 0.0 && disagrees(target, body)) islands_[body.island].awake = true;
  }
}

void Groups::form_groups(const Rule& rule, std::span<const BodyProps> props,
                         std::span<BodyActivity> activity, std::span<SolverBody> bodies) {
  const auto count = static_cast<std::uint32_t>(bodies.size());
  for (Group& group : groups_) {
    group.bodies.clear();
    group.locked = false;
  }
  std::array<bool, kMaxLevel + 1> used{};
  for (std::uint32_t i = 0; i < count; ++i) {
    const Island& island = islands_[bodies[i].island];
    if (bodies[i].inv_mass > 0.0 && island.awake) used[island.level] = true;
  }
  std::array<std::uint32_t, kMaxLevel + 1> group_of{};
  count_ = 0;
  for (std::uint8_t level = 0; level <= kMaxLevel; ++level) {
    if (!used[level]) continue;
    if (count_ == groups_.size()) groups_.emplace_back();
    groups_[count_].level = level;
    groups_[count_].substeps = rule.substeps << level;
    group_of[level] = static_cast<std::uint32_t>(count_++);
  }
  for (std::uint32_t i = 0; i < count; ++i) {
    const Island& island = islands_[bodies[i].island];
    if (bodies[i].inv_mass == 0.0 || !island.awake) continue;
    bodies[i].group = group_of[island.level];
    Group& group = groups_[bodies[i].group];
    group.bodies.push_back(i);
    group.locked = group.locked || props[i].locks.any();
    if (!activity[i].awake) activity[i].still = 0.0;
    activity[i].awake = true;
  }
}

void Groups::settle(const Rule& rule, double dt, const Islands& islands,
                    std::span<const ConstraintEdge> edges, std::span<const double> wanted,
                    std::span<const BodyState> before, std::span<const BodyProps> props,
                    std::span<BodyActivity> activity, std::span<SolverBody> bodies) {
  if (count_ == 0) return;
  const auto count = static_cast<std::uint32_t>(bodies.size());
  sprung_.assign(count, 0);
  if (rule.sleep_after > 0.0) judge_rest(edges, bodies);
  const double share = rule.sleep_after > 0.0 ? dt / (kSteady * rule.sleep_after) : 1.0;
  const auto is_steady = [&](std::uint32_t i) {
    const Vec3 dv = bodies[i].v - before[i].twist.linear;
    const Vec3 dw = bodies[i].w - before[i].twist.angular;
    return dv.norm() < share * rule.sleep_speed && dw.norm() < share * rule.sleep_spin;
  };
  for (std::uint32_t i = 0; i < count; ++i) {
    if (bodies[i].group == SolverBody::kNoGroup) continue;
    Island& island = islands_[islands.of()[i]];
    island.wanted = std::max(island.wanted, wanted[i]);
    const bool slow = bodies[i].v.squaredNorm() < rule.sleep_speed * rule.sleep_speed &&
                      bodies[i].w.squaredNorm() < rule.sleep_spin * rule.sleep_spin &&
                      (sprung_[i] == 0 || is_steady(i));
    activity[i].still = slow ? activity[i].still + dt : 0.0;
    island.sleepy = island.sleepy && props[i].can_sleep && activity[i].still >= rule.sleep_after;
  }
  for (std::uint32_t i = 0; i < count; ++i) {
    if (bodies[i].group == SolverBody::kNoGroup) continue;
    const Island& island = islands_[islands.of()[i]];
    std::uint8_t level = 0;
    while (level < kMaxLevel && (rule.substeps << level) < island.wanted) ++level;
    activity[i].level = std::max(level, island.level);
    if (level >= island.level) {
      activity[i].calm = 0;
    } else if (++activity[i].calm >= kCalmSteps) {
      activity[i].level = static_cast<std::uint8_t>(island.level - 1);
      activity[i].calm = 0;
    }
    if (rule.sleep_after == 0.0 || !island.sleepy || !island.held || island.driven) continue;
    activity[i].awake = false;
    bodies[i].v.setZero();
    bodies[i].w.setZero();
  }
}

void Groups::disturb(std::span<const ConstraintEdge> edges, std::span<const SolverBody> bodies) {
  const auto pushes = [&](std::uint32_t i) {
    return bodies[i].inv_mass == 0.0 && moves(bodies[i]);
  };
  for (const ConstraintEdge& edge : edges) {
    const std::uint32_t a = edge.body_a;
    const std::uint32_t b = edge.body_b;
    if (a == BodyId::kNone || b == BodyId::kNone) continue;
    if (pushes(a)) islands_[bodies[b].island].awake = true;
    if (pushes(b)) islands_[bodies[a].island].awake = true;
  }
}

void Groups::judge_rest(std::span<const ConstraintEdge> edges, std::span<const SolverBody> bodies) {
  for (const ConstraintEdge& edge : edges) {
    const std::array<std::uint32_t, 2> ends{edge.body_a, edge.body_b};
    std::array<bool, 2> fixed{};
    for (std::size_t k = 0; k < 2; ++k) {
      fixed[k] = ends[k] == BodyId::kNone || bodies[ends[k]].inv_mass == 0.0;
    }
    for (std::size_t k = 0; k < 2; ++k) {
      if (ends[k] == BodyId::kNone) continue;
      Island& island = islands_[bodies[ends[k]].island];
      // What drifts freely is slow, but not at rest.
      if (edge.supports && fixed[1 - k] && !fixed[k]) island.held = true;
      if (edge.actuated) island.driven = true;
      if (edge.force_driven) sprung_[ends[k]] = 1;
    }
  }
}

}  // namespace tandem::pbd
