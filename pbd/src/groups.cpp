// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "groups.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "tandem/pbd/math.h"

namespace tandem::pbd {
namespace {

/// Small islands of one level are joined to groups of at most so many bodies: the data that four
/// substeps read stays in the second-level cache, and each worker finds groups to solve.
constexpr std::size_t kMaxBodies = 512;
/// A larger island has a group of its own.
constexpr std::size_t kLargeIsland = 128;

/// Bodies per chunk of a worker.
constexpr std::size_t kGrain = 256;

/// Easy steps in a row before an island gets fewer substeps again.
constexpr int kCalmSteps = 8;

/// A body under springs or motors is at rest if it would take this many times as long to reach the
/// speed that counts as moving: a heavy body starts slowly.
constexpr double kSteady = 50.0;

/// m and rad: a body farther than this from its target is not at rest.
constexpr double kRestingDistance = 1e-3;
constexpr double kRestingAngle = 0.0175;

bool disagrees(const PoseTarget& target, const SolverBody& body) {
  const double angle = target.use_rotation_error
                           ? target.rotation_error.norm()
                           : rotation_between(body.q, target.pose.orientation).norm();
  return (target.pose.position - body.x).norm() > kRestingDistance || angle > kRestingAngle;
}

bool moves(const SolverBody& body) { return !body.v.isZero(0.0) || !body.w.isZero(0.0); }

/// By slot: 1 if the body belongs to another world; may be shorter.
std::span<const std::uint8_t> copies_of(const IslandCoupling* coupling) {
  return coupling != nullptr ? coupling->copies() : std::span<const std::uint8_t>();
}
bool is_copy(std::span<const std::uint8_t> copies, std::uint32_t body) {
  return body < copies.size() && copies[body] != 0;
}

/// Adds a step to the path of a slow body.
/// @param way   m, bound for being slow     @param turn  rad, bound for being slow
/// @return whether it is still slow
bool keeps_near(const SolverBody& body, const Pose& from, double way, double turn,
                BodyActivity& own) {
  own.moved += body.x - from.position;
  if (!(own.moved.squaredNorm() <= way * way)) return false;
  const Quat turn_now = body.q * from.orientation.conjugate();
  own.turned += (turn_now.w() < 0.0 ? -2.0 : 2.0) * turn_now.vec();
  return own.turned.squaredNorm() <= turn * turn;
}

/// Counts a step of a slow body. The mean speed is taken anew over each `sleep_after` (s): a
/// creeping body would otherwise stir whenever it has come far.
void stay_slow(BodyActivity& own, double dt, double sleep_after) {
  const double times = std::floor(own.low_speed_time / sleep_after);
  own.low_speed_time += dt;
  if (std::floor(own.low_speed_time / sleep_after) == times) return;
  own.moved.setZero();
  own.turned.setZero();
}

}  // namespace

void Groups::arrange(const Rule& rule, const Islands& islands,
                     std::span<const std::uint32_t> movers, std::span<const std::uint32_t> changed,
                     std::span<const ConstraintEdge> edges, std::span<const PoseTarget> targets,
                     const PropsTable& props, std::span<BodyActivity> activity,
                     std::span<SolverBody> bodies) {
  movers_ = movers;
  const bool pushed = sum_islands(rule, islands, activity, bodies);
  leave_out_joined(edges, bodies);
  if (rule.sleep_after > 0.0) wake_islands(changed, targets, bodies);
  if (rule.sleep_after > 0.0 && pushed) disturb(edges, bodies);
  if (rule.coupling != nullptr) rule.coupling->agree_awake(islands.of(), islands_);
  form_groups(rule, islands, props, activity, bodies);
}

bool Groups::sum_islands(const Rule& rule, const Islands& islands,
                         std::span<const BodyActivity> activity, std::span<SolverBody> bodies) {
  const std::size_t count = bodies.size();
  islands_.resize(count);
  joined_.resize(count);
  movable_.resize(count);
  for (const std::uint32_t i : movers_) {
    islands_[i] = {};
    joined_[i] = 0;
  }
  any_joined_ = false;
  const std::span<const std::uint8_t> copies = copies_of(rule.coupling);
  bool pushed = false;
  for (const std::uint32_t i : movers_) {
    bodies[i].island = islands.of()[i];
    movable_[i] = bodies[i].inv_mass > 0.0 ? 1 : 0;
    if (movable_[i] == 0) {
      pushed = pushed || moves(bodies[i]);
      continue;
    }
    if (is_copy(copies, i)) continue;
    if (bodies[i].projected && bodies[i].pushed) joined_[bodies[i].island] = any_joined_ = true;
    IslandPart& island = islands_[bodies[i].island];
    const bool awake = !activity[i].asleep || rule.sleep_after == 0.0;
    island.awake = island.awake || awake || moves(bodies[i]);
    island.level_sum += activity[i].level;
    ++island.bodies;
  }
  return pushed;
}

void Groups::leave_out_joined(std::span<const ConstraintEdge> edges,
                              std::span<const SolverBody> bodies) {
  if (!any_joined_) return;
  for (const ConstraintEdge& edge : edges) {
    if (edge.repeats) continue;
    for (const std::uint32_t end : {edge.body_a, edge.body_b}) {
      if (end != BodyId::kNone) joined_[bodies[end].island] = 0;
    }
  }
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

void Groups::form_groups(const Rule& rule, const Islands& islands, const PropsTable& props,
                         std::span<BodyActivity> activity, std::span<SolverBody> bodies) {
  const std::size_t count = bodies.size();
  levels_.resize(count);
  for (const std::uint32_t i : movers_) {
    levels_[i] = 0;
    const IslandPart& island = islands_[i];
    if (island.bodies == 0) continue;
    levels_[i] =
        static_cast<std::uint8_t>((2 * island.level_sum + island.bodies) / (2 * island.bodies));
  }
  const auto is_awake = [&](std::uint32_t i) {
    return movable_[i] != 0 && islands_[islands.of()[i]].awake;
  };
  std::array<std::size_t, kMaxLevel + 1> in_level{};
  for (const std::uint32_t i : movers_) {
    if (is_awake(i)) ++in_level[levels_[islands.of()[i]]];
  }
  groups_.clear();
  group_of_.resize(count);
  for (std::uint8_t level = 0; level <= kMaxLevel; ++level) {
    std::size_t open = count;  // group that takes islands; count: none yet
    if (in_level[level] == 0) continue;
    for (const std::uint32_t i : movers_) {
      if (islands.of()[i] != i || levels_[i] != level || !is_awake(i)) continue;
      // An island shared with another world is solved there in the group of the same number.
      const bool whole = rule.coupling != nullptr;
      const bool joined = !whole && joined_[i] != 0;
      const bool large = !whole && islands_[i].bodies > kLargeIsland;
      const bool full =
          open == count || (!whole && groups_[open].size + islands_[i].bodies > kMaxBodies);
      std::size_t group = open;
      if (joined || large || full) {
        group = groups_.size();
        groups_.push_back({.level = level, .substeps = rule.substeps << level, .joined = joined});
        if (!joined && !large) open = group;
      }
      groups_[group].size += islands_[i].bodies;
      ++groups_[group].islands;
      group_of_[i] = static_cast<std::uint32_t>(group);
    }
  }
  fill_groups(islands, props, activity, bodies);
  for (Group& group : groups_) {
    group.share =
        static_cast<double>(group.bodies.size()) / static_cast<double>(in_level[group.level]);
  }
}

void Groups::note_apart(const ConstraintEdges& edges, bool any_driven,
                        std::span<const SolverBody> bodies) {
  const auto group_of = [&](std::uint32_t i) -> Group* {
    const bool solved = i != BodyId::kNone && bodies[i].group != SolverBody::kNoGroup;
    return solved ? &groups_[bodies[i].group] : nullptr;
  };
  const auto drives = [&](std::uint32_t i) {
    return i != BodyId::kNone && bodies[i].inv_mass == 0.0 && moves(bodies[i]);
  };
  for (const ConstraintEdge& edge : edges.of_single_groups()) {
    for (const std::uint32_t i : {edge.body_a, edge.body_b}) {
      if (Group* group = group_of(i)) group->alone = true;
    }
  }
  if (!any_driven) return;
  for (const ConstraintEdge& edge : edges.all()) {
    if (Group* group = group_of(edge.body_a); group && drives(edge.body_b)) group->driven = true;
    if (Group* group = group_of(edge.body_b); group && drives(edge.body_a)) group->driven = true;
  }
}

/// Lists the bodies of all groups, ascending within each.
void Groups::fill_groups(const Islands& islands, const PropsTable& props,
                         std::span<BodyActivity> activity, std::span<SolverBody> bodies) {
  for (Group& group : groups_) group.size = 0;
  const auto for_awake = [&](auto&& visit) {
    for (const std::uint32_t i : movers_) {
      const std::uint32_t island = islands.of()[i];
      if (movable_[i] != 0 && islands_[island].awake) visit(i, group_of_[island]);
    }
  };
  for_awake([&](std::uint32_t, std::uint32_t group) { ++groups_[group].size; });
  std::size_t first = 0;
  for (Group& group : groups_) first += std::exchange(group.size, first);
  members_.resize(first);
  for_awake([&](std::uint32_t i, std::uint32_t number) {
    Group& group = groups_[number];
    members_[group.size++] = i;
    bodies[i].group = number;
    group.locked = group.locked || props[i].locks.any();
    if (activity[i].asleep) activity[i].stir();
    activity[i].asleep = false;
  });
  std::size_t begin = 0;
  for (Group& group : groups_) {
    group.bodies = std::span(members_).subspan(begin, group.size - begin);
    begin = group.size;
  }
}

static double speed_of(const BodyProps& body, const Groups::Rule& rule) {
  return body.sleep_speed.value_or(rule.sleep_speed);
}
static double spin_of(const BodyProps& body, const Groups::Rule& rule) {
  return body.sleep_spin.value_or(rule.sleep_spin);
}

/// Updates a body after the step of its island.
static void settle_body(const Groups::Rule& rule, const IslandPart& island,
                        std::uint8_t island_level, BodyActivity& own, SolverBody& body) {
  std::uint8_t level = 0;
  while (level < Groups::kMaxLevel && (rule.substeps << level) < island.wanted) ++level;
  own.level = std::max(level, island_level);
  if (level >= island_level) {
    own.steps_at_lower_level = 0;
  } else if (++own.steps_at_lower_level >= kCalmSteps) {
    own.level = static_cast<std::uint8_t>(island_level - 1);
    own.steps_at_lower_level = 0;
  }
  if (rule.sleep_after == 0.0 || !island.sleepy || !island.held || island.driven) return;
  own.asleep = true;
  body.v.setZero();
  body.w.setZero();
}

void Groups::settle(const Rule& rule, double dt, Workers& workers, const Islands& islands,
                    std::span<const ConstraintEdge> edges, std::span<const double> wanted,
                    std::span<const BodyState> before, const PropsTable& props,
                    std::span<BodyActivity> activity, std::span<SolverBody> bodies) {
  if (groups_.empty()) {
    if (rule.coupling != nullptr) rule.coupling->agree_rest(islands.of(), islands_);
    return;
  }
  sprung_.resize(bodies.size());
  for (const std::uint32_t i : movers_) sprung_[i] = 0;
  if (rule.sleep_after > 0.0) judge_rest(edges, bodies);
  const std::span<const std::uint8_t> copies = copies_of(rule.coupling);
  const double share = rule.sleep_after > 0.0 ? dt / (kSteady * rule.sleep_after) : 1.0;
  const auto is_steady = [&](std::uint32_t i) {
    const Vec3 dv = bodies[i].v - before[i].twist.linear;
    const Vec3 dw = bodies[i].w - before[i].twist.angular;
    return dv.norm() < share * speed_of(props[i], rule) &&
           dw.norm() < share * spin_of(props[i], rule);
  };
  const auto for_movers = [&](auto&& visit) {
    workers.for_chunks(movers_.size(), kGrain, [&](std::size_t begin, std::size_t end, int) {
      for (std::size_t k = begin; k < end; ++k) visit(movers_[k]);
    });
  };
  // Speed is measured by poses, since jitter moves nothing: a body that is pushed out of an overlap
  // and falls back in each step would have a velocity.
  rest_.resize(bodies.size());
  for_movers([&](std::uint32_t i) {
    rest_[i] = Rest::None;
    if (bodies[i].group == SolverBody::kNoGroup) return;
    BodyActivity& own = activity[i];
    const double way = speed_of(props[i], rule) * rule.sleep_after;
    const double turn = spin_of(props[i], rule) * rule.sleep_after;
    const bool rests = rule.sleep_after > 0.0 &&
                       keeps_near(bodies[i], before[i].pose, way, turn, own) &&
                       (sprung_[i] == 0 || is_steady(i));
    if (rests) {
      stay_slow(own, dt, rule.sleep_after);
    } else {
      own.stir();
    }
    const bool sleepy = props[i].can_sleep && own.low_speed_time >= rule.sleep_after;
    rest_[i] = sleepy || is_copy(copies, i) ? Rest::Sleepy : Rest::Stirs;
  });
  for (const std::uint32_t i : movers_) {
    if (rest_[i] == Rest::None) continue;
    IslandPart& island = islands_[islands.of()[i]];
    island.wanted = std::max(island.wanted, wanted[i]);
    island.sleepy = island.sleepy && rest_[i] == Rest::Sleepy;
  }
  if (rule.coupling != nullptr) rule.coupling->agree_rest(islands.of(), islands_);
  for_movers([&](std::uint32_t i) {
    if (rest_[i] == Rest::None) return;
    const std::uint32_t island = islands.of()[i];
    settle_body(rule, islands_[island], levels_[island], activity[i], bodies[i]);
  });
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
      IslandPart& island = islands_[bodies[ends[k]].island];
      // A freely drifting body is slow, but not at rest.
      if (edge.supports && fixed[1 - k] && !fixed[k]) island.held = true;
      if (edge.actuated) island.driven = true;
      if (edge.force_driven) sprung_[ends[k]] = 1;
    }
  }
}

}  // namespace tandem::pbd
