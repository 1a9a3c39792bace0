// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "broad_phase.h"

#include <algorithm>

namespace tandem::collision {
namespace {

/// A fat box more than this many margins wider than needed is made anew.
constexpr double kShrink = 8.0;

bool may_touch(const Collider& a, const Collider& b) {
  if (!a.alive || !b.alive || a.def.body == b.def.body) return false;
  if (!a.dynamic && !b.dynamic) return false;
  if (!a.is_convex() && !b.is_convex() && a.rank == b.rank) return false;
  if (a.def.sensor || b.def.sensor) return false;
  return may_meet(a.def.filter, b.def.filter);
}

}  // namespace

void BroadPhase::add(std::uint32_t index, const Collider& collider) {
  if (proxies_.size() <= index) proxies_.resize(index + 1);
  proxies_[index] = {};
  if (collider.is_half_space()) {
    half_spaces_.insert(std::lower_bound(half_spaces_.begin(), half_spaces_.end(), index), index);
  }
}

void BroadPhase::look_again(std::uint32_t index) {
  std::erase_if(pairs_, [&](const ColliderPair& pair) {
    const bool gone = pair.low == index || pair.high == index;
    if (gone) free_slots_.push_back(pair.cache);
    return gone;
  });
  if (placed(index)) tree_.remove(proxies_[index].leaf);
  proxies_[index] = {};
}

void BroadPhase::remove(std::uint32_t index, const Collider& collider) {
  look_again(index);
  if (collider.is_half_space()) {
    half_spaces_.erase(std::find(half_spaces_.begin(), half_spaces_.end(), index));
  }
}

void BroadPhase::place(std::uint32_t index, const Aabb& fat) {
  Proxy& proxy = proxies_[index];
  proxy.fat = fat;
  if (proxy.leaf == AabbTree::kNone) {
    proxy.leaf = tree_.insert(fat, index);
  } else {
    tree_.move(proxy.leaf, fat);
  }
}

void BroadPhase::reset() {
  for (Proxy& proxy : proxies_) proxy = {};
  tree_.clear();
  pairs_.clear();
  free_slots_.clear();
  cache_slots_ = 0;
}

std::uint32_t BroadPhase::take_slot() {
  if (free_slots_.empty()) return cache_slots_++;
  const std::uint32_t slot = free_slots_.back();
  free_slots_.pop_back();
  return slot;
}

ColliderPair& BroadPhase::append_pair(std::uint32_t low, std::uint32_t high) {
  pairs_.push_back({low, high, take_slot(), false});
  return pairs_.back();
}

bool BroadPhase::refit(std::uint32_t index, const Collider& c) {
  const Proxy& proxy = proxies_[index];
  if (placed(index) && proxy.fat.contains(c.needed)) {
    const Vec3 slack = (proxy.fat.max - proxy.fat.min) - (c.needed.max - c.needed.min);
    if (slack.maxCoeff() <= kShrink * margin_) return false;
  }
  place(index, c.needed.expanded(margin_));
  return true;
}

bool BroadPhase::in_reach(const Collider& plane, const Aabb& fat, double dt) const {
  const Vec3 n = plane.plane_normal();
  const Vec3 middle = 0.5 * (fat.min + fat.max);
  const Vec3 half = 0.5 * (fat.max - fat.min);
  const double turning =
      plane.twist.angular.norm() * dt * ((middle - plane.body.position).norm() + half.norm());
  // Its own share of the margins, as `needed` has for the others.
  const double own = plane.speculative + plane.recycle + plane.motion(dt) + turning;
  return n.dot(middle) - n.cwiseAbs().dot(half) <= plane.plane_offset() + own;
}

bool BroadPhase::still_close(const ColliderPair& pair, const std::vector<Collider>& colliders,
                             double dt) const {
  const Collider& low = colliders[pair.low];
  const Collider& high = colliders[pair.high];
  if (!low.finite || !high.finite) return false;
  if (low.is_half_space()) return in_reach(low, proxies_[pair.high].fat, dt);
  if (high.is_half_space()) return in_reach(high, proxies_[pair.low].fat, dt);
  return proxies_[pair.low].fat.overlaps(proxies_[pair.high].fat);
}

void BroadPhase::update(const std::vector<Collider>& colliders, double dt) {
  moved_.clear();
  bool plane_moves = false;
  bool all_finite = true;
  for (std::uint32_t i = 0; i < colliders.size(); ++i) {
    const Collider& c = colliders[i];
    if (!c.alive) continue;
    if (!c.finite) {  // out of the tree, so that it is found anew when it is back among numbers
      all_finite = false;
      if (placed(i)) tree_.remove(proxies_[i].leaf);
      proxies_[i] = {};
    } else if (c.is_half_space()) {
      const Aabb plane{c.plane_normal(), Vec3(c.plane_offset(), c.motion(dt), dt)};
      const bool still = plane.min == proxies_[i].fat.min && plane.max == proxies_[i].fat.max &&
                         c.twist.angular.isZero(0.0);
      plane_moves = plane_moves || !still;
      proxies_[i].fat = plane;
    } else if (refit(i, c)) {
      moved_.push_back(i);
    }
  }
  if (moved_.empty() && !plane_moves && all_finite) return;
  std::erase_if(pairs_, [&](const ColliderPair& pair) {
    const bool gone = !still_close(pair, colliders, dt);
    if (gone) free_slots_.push_back(pair.cache);
    return gone;
  });
  if (plane_moves) {  // all boxes against the planes
    moved_.clear();
    for (std::uint32_t i = 0; i < colliders.size(); ++i) {
      if (placed(i) && colliders[i].finite) moved_.push_back(i);
    }
  }
  find(colliders, dt);
  merge_found();
}

void BroadPhase::find(const std::vector<Collider>& colliders, double dt) {
  found_.clear();
  const auto propose = [&](std::uint32_t i, std::uint32_t j) {
    if (!may_touch(colliders[i], colliders[j])) return;
    found_.push_back({std::min(i, j), std::max(i, j), 0, true});
  };
  for (const std::uint32_t i : moved_) {
    tree_.query(proxies_[i].fat, stack_, [&](std::uint32_t j) {
      if (i != j && colliders[j].finite) propose(i, j);
    });
    for (const std::uint32_t plane : half_spaces_) {
      if (colliders[plane].finite && in_reach(colliders[plane], proxies_[i].fat, dt)) {
        propose(i, plane);
      }
    }
  }
  std::sort(found_.begin(), found_.end());
  const auto same = [](const ColliderPair& l, const ColliderPair& r) {
    return l.low == r.low && l.high == r.high;
  };
  found_.erase(std::unique(found_.begin(), found_.end(), same), found_.end());
}

void BroadPhase::merge_found() {
  merged_.clear();
  std::size_t old = 0;
  for (const ColliderPair& pair : found_) {
    while (old < pairs_.size() && pairs_[old] < pair) merged_.push_back(pairs_[old++]);
    if (old < pairs_.size() && !(pair < pairs_[old])) continue;  // known already
    merged_.push_back({pair.low, pair.high, take_slot(), true});
  }
  while (old < pairs_.size()) merged_.push_back(pairs_[old++]);
  std::swap(pairs_, merged_);
}

}  // namespace tandem::collision
