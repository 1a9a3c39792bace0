// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "broad_phase.h"

#include <algorithm>

#include "give_back.h"

namespace tandem::collision {
namespace {

/// A fat box that is more than this many margins too wide is rebuilt.
constexpr double kShrink = 8.0;
/// The margin is at most this share of a collider's least extent.
constexpr double kMarginShare = 0.06;
/// Steps by which a fat box extends in the direction of motion.
constexpr double kAhead = 3.0;
/// Lookups per chunk of a worker.
constexpr std::size_t kGrain = 32;
/// The same if most of them have not moved.
constexpr std::size_t kLookGrain = 256;
/// Index in an ascending list; its size if `index` is not in it.
std::size_t place_of(const std::vector<std::uint32_t>& list, std::uint32_t index) {
  const auto at = std::lower_bound(list.begin(), list.end(), index);
  const bool found = at != list.end() && *at == index;
  return found ? static_cast<std::size_t>(at - list.begin()) : list.size();
}

double margin_of(const Collider& c) { return std::min(kAabbMargin, kMarginShare * c.size); }
/// m, room for the coming steps.
Vec3 ahead_of(const Collider& c) { return (kAhead * c.motion().span) * c.motion().twist.linear; }

bool plane_reaches(const Collider& plane, const Aabb& fat, double dt) {
  const Vec3 n = plane.plane_normal();
  const Vec3 middle = 0.5 * (fat.min + fat.max);
  const Vec3 half = 0.5 * (fat.max - fat.min);
  const double turning = plane.motion().twist.angular.norm() * dt *
                         ((middle - plane.body.position).norm() + half.norm());
  // The plane's own share of the margins, as `needed` contains for the others.
  const double own =
      plane.margins.speculative + plane.margins.recycle + plane.travel_within(dt) + turning;
  return n.dot(middle) - n.cwiseAbs().dot(half) <= plane.plane_offset() + own;
}

}  // namespace

bool may_touch(const Collider& a, const Collider& b) {
  if (!a.alive || !b.alive || a.def.body == b.def.body) return false;
  if (!a.active() && !b.active()) return false;
  // Of non-convex colliders, only a mesh and a half-space meet.
  if (!a.is_convex() && !b.is_convex() && !(a.is_mesh() && b.is_half_space()) &&
      !(b.is_mesh() && a.is_half_space())) {
    return false;
  }
  if (a.def.sensor || b.def.sensor) return false;
  return may_meet(a.def.filter, b.def.filter);
}

void BroadPhase::add(std::uint32_t index, const Collider& collider) {
  if (leaves_.size() <= index) {
    leaves_.resize(index + 1, AabbTree::kNone);
    dropped_.resize(index + 1, 0);
  }
  leaves_[index] = AabbTree::kNone;
  if (collider.is_half_space()) {
    const auto at = std::lower_bound(half_spaces_.begin(), half_spaces_.end(), index);
    planes_.insert(planes_.begin() + (at - half_spaces_.begin()), Aabb{});
    half_spaces_.insert(at, index);
  }
}

void BroadPhase::look_again(std::uint32_t index) {
  dropped_[index] = 1;
  any_dropped_ = true;
  unlink(index);
  remember_plane(index, {});
}

void BroadPhase::remove(std::uint32_t index, const Collider& collider) {
  look_again(index);
  if (collider.is_half_space()) {
    const auto at = static_cast<std::ptrdiff_t>(place_of(half_spaces_, index));
    half_spaces_.erase(half_spaces_.begin() + at);
    planes_.erase(planes_.begin() + at);
  }
}

void BroadPhase::unlink(std::uint32_t index) {
  if (!placed(index)) return;
  (placed_fixed(index) ? fixed_tree_ : tree_).remove(leaves_[index] & ~kFixed);
  leaves_[index] = AabbTree::kNone;
}

void BroadPhase::place(std::uint32_t index, const Aabb& fat, bool fixed) {
  AabbTree& tree = fixed ? fixed_tree_ : tree_;
  if (placed(index) && placed_fixed(index) == fixed) {
    tree.move(leaves_[index] & ~kFixed, fat);
    return;
  }
  unlink(index);
  leaves_[index] = tree.insert(fat, index) | (fixed ? kFixed : 0u);
}

void BroadPhase::remember_plane(std::uint32_t index, const Aabb& plane) {
  const std::size_t at = place_of(half_spaces_, index);
  if (at < planes_.size()) planes_[at] = plane;
}

Aabb BroadPhase::fat_box(std::uint32_t index) const {
  if (placed(index)) return fat(index);
  const std::size_t at = place_of(half_spaces_, index);
  return at < planes_.size() ? planes_[at] : Aabb{};
}

void BroadPhase::reset() {
  std::fill(leaves_.begin(), leaves_.end(), AabbTree::kNone);
  std::fill(planes_.begin(), planes_.end(), Aabb{});
  tree_.clear();
  fixed_tree_.clear();
  pairs_.clear();
  std::fill(dropped_.begin(), dropped_.end(), 0);
  any_dropped_ = false;
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

bool BroadPhase::is_as_it_was(std::uint32_t index, const Collider& c) const {
  if (!c.alive) return true;
  if (!c.finite || c.is_half_space() || !placed(index) || placed_fixed(index) == c.active())
    return false;
  if (c.still) return true;
  if (!fat(index).contains(c.needed)) return false;
  const Vec3 slack = (fat(index).max - fat(index).min) - (c.needed.max - c.needed.min);
  return slack.maxCoeff() <= kShrink * margin_of(c) + 2.0 * ahead_of(c).cwiseAbs().maxCoeff();
}

void BroadPhase::refit(std::uint32_t index, const Collider& c) {
  const Vec3 ahead = ahead_of(c);
  const Aabb box = c.needed.expanded(margin_of(c));
  const Aabb fat{box.min + ahead.cwiseMin(0.0), box.max + ahead.cwiseMax(0.0)};
  if (placed(index) || c.active()) {
    place(index, fat, !c.active());
  } else {
    unlinked_.push_back(fixed_tree_.prepare(fat, index));
    leaves_[index] = unlinked_.back() | kFixed;
  }
}

bool BroadPhase::still_close(const ColliderPair& pair, const std::vector<Collider>& colliders,
                             double dt) const {
  const Collider& low = colliders[pair.low];
  const Collider& high = colliders[pair.high];
  if (!low.finite || !high.finite) return false;
  // Loaded input may name any pair.
  if (!(low.is_half_space() || placed(pair.low)) || !(high.is_half_space() || placed(pair.high)) ||
      (low.is_half_space() && high.is_half_space())) {
    return false;
  }
  if (low.is_half_space()) return plane_reaches(low, fat(pair.high), dt);
  if (high.is_half_space()) return plane_reaches(high, fat(pair.low), dt);
  return fat(pair.low).overlaps(fat(pair.high));
}

void BroadPhase::update(const std::vector<Collider>& colliders,
                        std::span<const std::uint32_t> watched, double dt, pbd::Workers& workers) {
  moved_.clear();
  found_.clear();
  if (has_moved_.size() < colliders.size()) has_moved_.resize(colliders.size(), 0);
  for (const std::uint32_t i : flagged_) has_moved_[i] = 0;
  flagged_.clear();
  const auto flag = [&](std::uint32_t i) {
    has_moved_[i] = 1;
    flagged_.push_back(i);
  };
  bool plane_moves = false, all_finite = true;
  stays_.resize(watched.size());
  workers.for_chunks(watched.size(), kLookGrain, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t k = begin; k < end; ++k) {
      stays_[k] = is_as_it_was(watched[k], colliders[watched[k]]) ? 1 : 0;
    }
  });
  for (std::size_t k = 0; k < watched.size(); ++k) {
    if (stays_[k] != 0) continue;
    const std::uint32_t i = watched[k];
    const Collider& c = colliders[i];
    if (placed(i) && placed_fixed(i) == c.active()) look_again(i);  // its body's type has changed
    if (!c.finite) {  // leaves the tree, so that it is found again once it is finite
      all_finite = false;
      unlink(i);
      remember_plane(i, {});
      flag(i);
    } else if (c.is_half_space()) {
      // For a resting half-space the length of the step does not matter.
      const Aabb plane{c.plane_normal(), Vec3(c.plane_offset(), c.travel_within(dt), 0.0)};
      const Aabb before = fat_box(i);
      const bool still = plane.min == before.min && plane.max == before.max &&
                         c.motion().twist.angular.isZero(0.0);
      plane_moves = plane_moves || !still;
      remember_plane(i, plane);
    } else {
      refit(i, c);
      moved_.push_back(i);
      flag(i);
    }
  }
  fixed_tree_.link_all(unlinked_);
  unlinked_.clear();
  if (moved_.empty() && !plane_moves && all_finite) return;
  if (plane_moves) {  // tests all boxes against the planes
    moved_.clear();
    for (std::uint32_t i = 0; i < colliders.size(); ++i) {
      if (placed(i) && colliders[i].finite) moved_.push_back(i);
      if (has_moved_[i] == 0) flag(i);
    }
  }
  drop_pairs([&](const ColliderPair& pair) {
    return (has_moved_[pair.low] != 0 || has_moved_[pair.high] != 0) &&
           !still_close(pair, colliders, dt);
  });
  index_pairs();
  find(colliders, dt, workers);
  merge_found();
}

void BroadPhase::trim() {
  for (auto* list : {&moved_, &unlinked_, &flagged_}) give_back(*list);
  give_back(found_);
  for (Search& search : searches_) give_back(search.found);
}

void BroadPhase::index_pairs() {
  // A few lookups are done without the index, which has to scan every collider.
  constexpr std::size_t kFew = 32;
  indexed_ = kFew * moved_.size() >= leaves_.size();
  if (!indexed_) return;
  first_pair_.resize(leaves_.size() + 1);
  std::uint32_t at = 0;
  for (std::uint32_t low = 0; low < first_pair_.size(); ++low) {
    while (at < pairs_.size() && pairs_[at].low < low) ++at;
    first_pair_[low] = at;
  }
}

bool BroadPhase::known(std::uint32_t low, std::uint32_t high) const {
  const auto begin = pairs_.begin() + (indexed_ ? first_pair_[low] : 0);
  const auto end = indexed_ ? pairs_.begin() + first_pair_[low + 1] : pairs_.end();
  const ColliderPair pair{low, high, 0, false};
  const auto at = std::lower_bound(begin, end, pair);
  return at != end && at->low == low && at->high == high;
}

void BroadPhase::find(const std::vector<Collider>& colliders, double dt, pbd::Workers& workers) {
  searches_.resize(static_cast<std::size_t>(workers.count()));
  for (Search& search : searches_) search.found.clear();
  workers.for_chunks(moved_.size(), kGrain, [&](std::size_t begin, std::size_t end, int worker) {
    Search& search = searches_[static_cast<std::size_t>(worker)];
    const auto propose = [&](std::uint32_t i, std::uint32_t j) {
      const std::uint32_t low = std::min(i, j);
      const std::uint32_t high = std::max(i, j);
      if (known(low, high) || !meet(colliders[i], colliders[j])) return;
      search.found.push_back({low, high, 0, true});
    };
    for (std::size_t k = begin; k < end; ++k) {
      const std::uint32_t i = moved_[k];
      const auto meet = [&](std::uint32_t j) {
        // Of two that moved, the lower one proposes the pair. Boxes in a tree are finite.
        if (i == j || (has_moved_[j] != 0 && j < i)) return;
        propose(i, j);
      };
      tree_.query(fat(i), search.stack, meet);
      if (colliders[i].active()) fixed_tree_.query(fat(i), search.stack, meet);
      for (const std::uint32_t plane : half_spaces_) {
        if (colliders[plane].finite && plane_reaches(colliders[plane], fat(i), dt)) {
          propose(i, plane);
        }
      }
    }
  });
  // Sorted, so that it does not matter which worker found what.
  found_.clear();
  for (Search& search : searches_) {
    found_.insert(found_.end(), search.found.begin(), search.found.end());
  }
  std::sort(found_.begin(), found_.end());
}

void BroadPhase::merge_found() {
  if (found_.empty()) return;
  // Merged in place, from the back: a heap has ten pairs per body.
  std::size_t old = pairs_.size();
  std::size_t at = old + found_.size();
  pairs_.resize(at);
  for (std::size_t n = found_.size(); n > 0;) {
    if (old > 0 && found_[n - 1] < pairs_[old - 1]) {
      pairs_[--at] = pairs_[--old];
    } else {
      pairs_[--at] = found_[--n];
      pairs_[at].cache = take_slot();
    }
  }
}

void BroadPhase::assign(const BroadPhase& source) {
  apart = source.apart;
  tree_ = source.tree_;
  fixed_tree_ = source.fixed_tree_;
  leaves_ = source.leaves_;
  half_spaces_ = source.half_spaces_;
  planes_ = source.planes_;
  pairs_ = source.pairs_;
  dropped_ = source.dropped_;
  any_dropped_ = source.any_dropped_;
  found_.clear();
  free_slots_ = source.free_slots_;
  cache_slots_ = source.cache_slots_;
}

}  // namespace tandem::collision
