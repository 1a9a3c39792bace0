// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "motion_limit.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>
#include <utility>

#include "core_cast.h"
#include "inner_core.h"
#include "motion_path.h"
#include "tandem/pbd/contact.h"
#include "tandem/pbd/math.h"
#include "tandem/pbd/portable.h"

namespace tandem::collision {
namespace {

/// Colliders per chunk of a worker.
constexpr std::size_t kChunk = 128;
constexpr std::uint8_t kGuardedSteps = 60;
/// Share of the smaller of two sizes: gap at which two bodies that would have met are stopped, for
/// the contact of the next step; and distance at which a core counts as obstructed.
constexpr double kLeftApart = 0.01;
/// Rounds in which stopped bodies are checked again by those that they meet.
constexpr int kRounds = 4;

// Pace of a collider in a step.
constexpr std::uint8_t kPaceIdle = 0;  ///< nothing to check
constexpr std::uint8_t kPaceSlow = 1;
constexpr std::uint8_t kPaceFast = 2;  ///< the middle moves further than the radius of its ball
constexpr std::uint8_t kPaceSwift =
    3;  ///< far points do, or it is marked: movable ones stop it, too

/// Whether a body may be pushed out on the far side.
bool is_thin(const Collider& target, const Collider& collider) {
  return !target.dynamic && target.is_convex() && target.size < 2.0 * collider.size;
}

bool may_be_limited(const Collider& c, std::size_t bodies) {
  return c.alive && c.active() && c.finite && c.is_convex() && c.motion().span > 0.0 &&
         c.def.body.index < bodies;
}

bool is_finite(const pbd::Pose& pose) {
  return pose.position.allFinite() && pose.orientation.coeffs().allFinite();
}

/// Whether it is a solid of revolution about an axis through its body's centre.
bool is_round(const Collider& c) {
  return (c.kind == Kind::Capsule || c.kind == Kind::Cylinder || c.kind == Kind::Cone) &&
         c.def.local.position.isZero(1e-9 * c.size);
}

/// The axis of a solid of revolution, world.
Vec3 axis_of(const Collider& c, const pbd::Pose& body) {
  return pbd::rotate(body.orientation, Vec3(c.local_rotation().col(2)));
}

/// rad^2, rotation, slightly less for large ones; for a solid of revolution that of its axis.
double turned_squared(const Collider& c, const pbd::Pose& to) {
  const pbd::Quat& before = c.body.orientation;
  if (is_round(c)) return (axis_of(c, to) - axis_of(c, c.body)).squaredNorm();
  const double chord2 = std::min((to.orientation.coeffs() - before.coeffs()).squaredNorm(),
                                 (to.orientation.coeffs() + before.coeffs()).squaredNorm());
  return 4.0 * chord2;
}

/// rad, rotation: root of turned_squared().
double turned(const Collider& c, const pbd::Pose& to) { return std::sqrt(turned_squared(c, to)); }

/// m, largest motion of any point of an immovable collider in this step.
double fastest_obstacle(std::span<const Collider> colliders, std::span<const std::uint32_t> watched,
                        const pbd::World& world, std::span<const pbd::Pose> after) {
  double fastest = 0.0;
  for (const std::uint32_t i : watched) {
    const Collider& c = colliders[i];
    if (!c.alive || c.dynamic || !c.finite || c.def.body.index >= after.size()) continue;
    if (is_static(c, world)) continue;
    const pbd::Pose& end = after[c.def.body.index];
    const double round = c.is_convex() ? turned(c, end) * c.reach : 0.0;
    fastest = std::max(fastest, (end.position - c.body.position).norm() + round);
  }
  return fastest;
}

}  // namespace

/// Input of a step.
struct MotionLimiter::Step {
  std::span<Collider> colliders;
  const BroadPhase& broad;
  const pbd::World& world;
  std::span<const pbd::Pose> after;
  std::span<const std::uint8_t> pace;     ///< by collider: kPaceIdle to kPaceSwift
  std::span<const std::uint8_t> chained;  ///< by body slot

  const pbd::Pose& end(const Collider& c) const {
    return is_static(c, world) ? c.body : after[c.def.body.index];
  }
  bool meet(const Collider& a, const Collider& b) const { return broad.meet(a, b); }
  /// Whether it stops where its surface meets something. Chained bodies do not: the others would go
  /// on and strain the rows.
  bool is_swept(std::uint32_t i) const {
    return pace[i] >= kPaceFast && chained[colliders[i].def.body.index] == 0;
  }
  MotionPath path(const Collider& c) const {
    if (!is_round(c)) return {c.body, end(c), c.motion().twist, c.motion().span};
    // Spin about its own axis is ignored: a rolling rod keeps its axis level.
    const Vec3 axis = axis_of(c, c.body);
    const Vec3 then = axis_of(c, end(c));
    const Vec3 across = axis.cross(then);
    const double sine = across.norm();
    pbd::Pose to{end(c).position, c.body.orientation};
    if (sine > 1e-12) {
      const double angle = pbd::portable::atan2(sine, axis.dot(then));
      to.orientation = pbd::exp_map(angle / sine * across) * to.orientation;
    }
    pbd::Twist twist = c.motion().twist;
    twist.angular -= axis.dot(twist.angular) * axis;
    return {c.body, to, twist, c.motion().span};
  }
};

namespace {

using MotionStep = MotionLimiter::Step;

/// Whether rotation moves far points by more than its thickness.
bool swings(const Collider& c, const pbd::Pose& end) {
  return c.kind != Kind::Sphere && turned_squared(c, end) * (c.reach * c.reach) > c.size * c.size;
}

/// Bullets and swinging colliders are swift at any speed. A collider is idle if it is not guarded
/// and moves so little that no obstacle gets through the ball in its middle.
/// @param fastest  m, largest motion of any obstacle
std::uint8_t pace_of(const Collider& c, const pbd::Pose& end, bool bullet, double fastest) {
  const double radius = core_radius(c);
  const Vec3 way = core_centre(c, end) - core_centre(c, c.body);
  if (swings(c, end) || (bullet && !way.isZero(0.0))) return kPaceSwift;
  const double way2 = pbd::dot(way, way);
  if (way2 > radius * radius) return kPaceFast;
  const double left = radius - fastest;
  return c.guarded == 0 && left >= 0.0 && way2 <= left * left ? kPaceIdle : kPaceSlow;
}

/// Pose at the end of a body that is at `pose` when the obstacle is at `then`, and is carried along
/// by it.
pbd::Pose carried(const pbd::Pose& pose, const pbd::Pose& then, const pbd::Pose& end) {
  const pbd::Quat turn = end.orientation * then.orientation.conjugate();
  pbd::Pose out{end.position + pbd::rotate(turn, pose.position - then.position),
                turn * pose.orientation};
  out.orientation.normalize();
  return out;
}

/// When the surfaces of `first` and `second` meet, if the core of `first` would. If they touch at
/// the start, `touching` is set and it is when the core meets.
SweepHit find_meeting(const Collider& first, MovingCore a, const Collider& second,
                      const MovingCore& b, std::vector<Vec3>& arms, bool& touching) {
  const double touch = kLeftApart * std::min(first.size, second.size);
  a.core = inner_core(first, arms);
  SweepHit hit = sweep(a, b, touch);
  if (hit.apart <= 0.0) {
    // At least the centre stays on its side.
    a.core = point_core(a.core.centre);
    hit = sweep(a, b, core_radius(first));
    if (hit.apart <= 0.0) return {};
  }
  if (hit.share >= 1.0) return hit;
  a.core = body_core(first);
  const SweepHit whole = sweep(a, b, touch);
  touching = whole.apart <= 2.0 * touch;
  return touching || whole.share >= 1.0 ? hit : whole;
}

/// Casts the ball in the middle against an immovable collider, which may move by itself.
void cast_ball(const MotionStep& step, const Collider& c, const Collider& target,
               std::vector<std::uint32_t>& list, std::vector<pbd::MotionLimit>& limits) {
  const double radius = core_radius(c);
  const Vec3 from = core_centre(c, c.body);
  const Vec3 to = core_centre(c, step.end(c));
  const auto is_far = [&](const Vec3& way) { return way.squaredNorm() > radius * radius; };
  // In the frame of the target.
  const Vec3 moved = step.end(target).position - target.body.position;
  if (c.guarded == 0 && !is_far(to - from) && !is_far(to - from - moved)) return;
  const CoreHit hit = core_cast(from, to - moved, radius, target, list);
  if (hit.share >= 1.0) return;
  pbd::Pose pose = step.end(c);
  const Vec3& start = c.body.position;
  pose.position = start + hit.share * (pose.position - start - moved) + moved;
  limits.push_back({c.def.body.index, hit.share, pose, hit.normal, moved});
}

/// Sweeps the shape against a collider that does not stop for it: an immovable one carries along
/// what it meets, and a slow one is taken at its end pose.
void sweep_shape(const MotionStep& step, const Collider& c, const MotionPath& path,
                 const Collider& target, std::vector<Vec3>& arms,
                 std::vector<pbd::MotionLimit>& limits) {
  const bool pushed = target.dynamic;
  const pbd::Pose& end = step.end(target);
  const MotionPath other = pushed ? MotionPath(end) : step.path(target);
  bool touching = false;
  const SweepHit hit = find_meeting(
      c, {.reach = c.reach, .path = path}, target,
      {.core = body_core(target), .reach = target.reach, .path = other}, arms, touching);
  if (hit.share >= 1.0 || (touching && pushed)) return;
  pbd::Pose pose = path.at(hit.share);
  if (!pushed) pose = carried(pose, other.at(hit.share), end);
  limits.push_back({c.def.body.index, hit.share, pose, touching ? hit.normal : Vec3(Vec3::Zero()),
                    end.position - target.body.position});
}

bool stops_before(const pbd::MotionLimit& l, const pbd::MotionLimit& r) {
  if (l.body != r.body) return l.body < r.body;
  if (l.share != r.share) return l.share < r.share;
  if (l.normal != r.normal) return lies_before(l.normal, r.normal);
  return lies_before(l.pose.position, r.pose.position);
}

}  // namespace

void MotionLimiter::limit_one(const Step& step, std::uint32_t index, Worker& worker) {
  Collider& c = step.colliders[index];
  const double radius = core_radius(c);
  const Vec3 from = core_centre(c, c.body);
  const Vec3 to = core_centre(c, step.end(c));
  if (!is_finite(step.end(c))) return;
  const bool swept = step.is_swept(index);
  const bool whole = swept && c.kind != Kind::Sphere;
  std::optional<MotionPath> known_path;
  const auto path = [&]() -> const MotionPath& {
    return known_path ? *known_path : known_path.emplace(step.path(c));
  };
  const Aabb middle{from.cwiseMin(to), from.cwiseMax(to)};
  const Aabb way = whole ? path().bounds(c.reach) : middle.expanded(radius);
  step.broad.query(way, swept && step.pace[index] == kPaceSwift, worker.stack,
                   [&](std::uint32_t other) {
                     const Collider& target = step.colliders[other];
                     if (!target.finite || !is_finite(step.end(target)) || !step.meet(c, target))
                       return;
                     if (target.dynamic) {
                       if (!target.is_convex()) return;
                       if (step.is_swept(other)) {
                         worker.pairs.push_back({index, other});
                       } else {
                         sweep_shape(step, c, path(), target, worker.arms, worker.limits);
                       }
                       return;
                     }
                     if (is_thin(target, c)) c.guarded = kGuardedSteps;
                     const bool turns = turned(target, step.end(target)) * target.reach > radius;
                     if (target.is_convex() && (whole || turns)) {
                       sweep_shape(step, c, path(), target, worker.arms, worker.limits);
                     } else {
                       cast_ball(step, c, target, worker.list, worker.limits);
                     }
                   });
}

void MotionLimiter::mark_chained(const pbd::World& world, std::span<const std::uint32_t> watched) {
  const std::size_t bodies = world.states().size();
  if (chained_.size() < bodies) chained_.resize(bodies, 0);
  for (const std::uint32_t body : links_) chained_[body] = 0;
  links_.clear();
  if (std::none_of(watched.begin(), watched.end(),
                   [&](std::uint32_t i) { return pace_[i] >= kPaceFast; })) {
    return;
  }
  edges_.clear();
  for (const auto& block : world.blocks()) {
    if (block.get() != world.contacts()) block->append_edges(edges_);
  }
  const auto moves = [&](std::uint32_t i) {
    return i < bodies && world.all_props()[i].type == pbd::BodyType::Dynamic;
  };
  for (const pbd::ConstraintEdge& edge : edges_) {
    if (moves(edge.body_a) && moves(edge.body_b)) {
      chained_[edge.body_a] = chained_[edge.body_b] = 1;
      links_.insert(links_.end(), {edge.body_a, edge.body_b});
    }
  }
}

/// By time of meeting, then by the order of the colliders, independent of the worker.
void MotionLimiter::sort_pairs(const Step& step) {
  std::sort(pairs_.begin(), pairs_.end(), [&](const FastPair& l, const FastPair& r) {
    const auto place = [&](const FastPair& pair) {
      return std::tuple(pair.share, step.colliders[pair.first].rank.own,
                        step.colliders[pair.second].rank.own);
    };
    return place(l) < place(r);
  });
}

/// Stops the first to meet, in the order of time. Pairs with a stopped collider are checked again.
bool MotionLimiter::stop_first(const Step& step, std::vector<Vec3>& arms) {
  for (FastPair& pair : pairs_) {
    if (!std::exchange(pair.old, false)) continue;
    const Collider& first = step.colliders[pair.first];
    const Collider& second = step.colliders[pair.second];
    const MovingCore a{
        .reach = first.reach, .path = step.path(first), .stop = stops_[first.def.body.index]};
    const MovingCore b{.core = body_core(second),
                       .reach = second.reach,
                       .path = step.path(second),
                       .stop = stops_[second.def.body.index]};
    bool touching = false;
    const double share = find_meeting(first, a, second, b, arms, touching).share;
    pair.share = touching ? 1.0 : share;
  }
  sort_pairs(step);
  bool any = false;
  for (FastPair& pair : pairs_) {
    if (pair.share >= 1.0) break;
    if (pair.old) continue;
    for (const std::uint32_t i : {pair.first, pair.second}) {
      const std::uint32_t body = step.colliders[i].def.body.index;
      if (stops_[body] <= pair.share) continue;
      stops_[body] = pair.share;
      any = true;
      for (FastPair& other : pairs_) {
        other.old = other.old || step.colliders[other.first].def.body.index == body ||
                    step.colliders[other.second].def.body.index == body;
      }
    }
  }
  return any;
}

void MotionLimiter::stop_pairs(const Step& step, std::vector<pbd::MotionLimit>& limits) {
  pairs_.clear();
  for (const Worker& worker : workers_) {
    pairs_.insert(pairs_.end(), worker.pairs.begin(), worker.pairs.end());
  }
  if (pairs_.empty()) return;
  stops_.assign(step.after.size(), 1.0);
  for (const pbd::MotionLimit& limit : limits) {
    stops_[limit.body] = std::min(stops_[limit.body], limit.share);
  }
  for (int round = 0; round < kRounds && stop_first(step, workers_[0].arms); ++round) {
  }
  for (const FastPair& pair : pairs_) {
    for (const std::uint32_t i : {pair.first, pair.second}) {
      const Collider& c = step.colliders[i];
      const double stop = stops_[c.def.body.index];
      if (stop >= 1.0) continue;
      limits.push_back({c.def.body.index, stop, step.path(c).at(stop), Vec3::Zero(), Vec3::Zero()});
    }
  }
}

void MotionLimiter::guard(std::span<Collider> colliders, std::span<const ColliderPair> near) {
  const auto guard_one = [](Collider& collider, const Collider& other) {
    if (collider.dynamic && is_thin(other, collider)) collider.guarded = kGuardedSteps;
  };
  for (const ColliderPair& pair : near) {
    guard_one(colliders[pair.low], colliders[pair.high]);
    guard_one(colliders[pair.high], colliders[pair.low]);
  }
}

void MotionLimiter::find(std::span<Collider> colliders, std::span<const std::uint32_t> watched,
                         const BroadPhase& broad, const pbd::World& world,
                         std::span<const pbd::Pose> after, pbd::Workers& workers,
                         std::vector<pbd::MotionLimit>& limits) {
  limits.clear();
  workers_.resize(std::max(workers_.size(), static_cast<std::size_t>(workers.count())));
  for (Worker& worker : workers_) {
    worker.limits.clear();
    worker.pairs.clear();
  }
  if (pace_.size() < colliders.size()) pace_.resize(colliders.size(), kPaceIdle);
  for (const std::uint32_t i : paced_) pace_[i] = kPaceIdle;
  paced_.assign(watched.begin(), watched.end());
  const double fastest = fastest_obstacle(colliders, watched, world, after);
  workers.for_chunks(watched.size(), kChunk, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t k = begin; k < end; ++k) {
      const std::uint32_t i = watched[k];
      Collider& c = colliders[i];
      if (!may_be_limited(c, after.size())) continue;
      if (c.guarded > 0) --c.guarded;
      const std::uint32_t body = c.def.body.index;
      if (!world.awake_at(body)) continue;
      pace_[i] = pace_of(c, after[body], world.all_props()[body].bullet, fastest);
    }
  });
  mark_chained(world, watched);
  const Step step{colliders, broad, world, after, pace_, chained_};
  workers.for_chunks(watched.size(), kChunk, [&](std::size_t begin, std::size_t end, int w) {
    for (std::size_t k = begin; k < end; ++k) {
      const std::uint32_t i = watched[k];
      if (pace_[i] != kPaceIdle) {
        limit_one(step, i, workers_[static_cast<std::size_t>(w)]);
      }
    }
  });
  for (const Worker& worker : workers_) {
    limits.insert(limits.end(), worker.limits.begin(), worker.limits.end());
  }
  stop_pairs(step, limits);
  std::sort(limits.begin(), limits.end(), stops_before);
  limits.erase(std::unique(limits.begin(), limits.end(),
                           [](const pbd::MotionLimit& l, const pbd::MotionLimit& r) {
                             return l.body == r.body;
                           }),
               limits.end());
}

}  // namespace tandem::collision
