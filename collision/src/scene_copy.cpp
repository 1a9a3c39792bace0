// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// A scene as another one. Shapes are shared; memory for the narrow phase is each scene's own.
#include <typeinfo>
#include <utility>

#include "contact_source_impl.h"

namespace tandem::collision {
namespace {

/// Triangles of a search: where `to` has no list yet, the next search would make it as well.
void copy_triangles(const PairCache& from, PairCache& to) {
  if (from.triangles == nullptr || !from.triangles->filled) {
    if (to.triangles != nullptr) to.triangles->filled = false;
    return;
  }
  if (to.triangles == nullptr) to.triangles = std::make_unique<TriangleList>();
  *to.triangles = *from.triangles;
}

/// @param may_take  patches from the pool; without, those that `to` has no memory for are left out
/// @return whether none was left out
bool copy_cache(const PairCache& from, PairCache& to, PatchPool& pool, bool may_take) {
  to.position = from.position;
  to.orientation = from.orientation;
  to.margin = from.margin;
  to.valid = from.valid;
  to.axis = from.axis;
  copy_triangles(from, to);
  ContactPatch** link = &to.patches;
  const ContactPatch* patch = from.patches;
  for (; patch != nullptr; patch = patch->next) {
    if (*link == nullptr && !may_take) break;
    if (*link == nullptr) *link = pool.take();
    ContactPatch* const next = (*link)->next;
    **link = *patch;
    (*link)->next = next;
    link = &(*link)->next;
  }
  pool.give(std::exchange(*link, nullptr));
  return patch == nullptr;
}

}  // namespace

void BroadPhase::assign(const BroadPhase& source) {
  tree_ = source.tree_;
  fixed_tree_ = source.fixed_tree_;
  leaves_ = source.leaves_;
  half_spaces_ = source.half_spaces_;
  planes_ = source.planes_;
  pairs_ = source.pairs_;
  found_.clear();
  free_slots_ = source.free_slots_;
  cache_slots_ = source.cache_slots_;
}

void CollisionScene::Impl::assign(const Impl& source) {
  if (this == &source) return;
  options_ = source.options_;
  stats_ = source.stats_;
  colliders_ = source.colliders_;
  free_ = source.free_;
  free_.reserve(colliders_.size());  // as add() does: removal needs no memory
  sensor_count_ = source.sensor_count_;
  added_ = source.added_;
  order_is_old_ = source.order_is_old_;
  natural_order_ = source.natural_order_;
  restored_ = source.restored_;
  sleepers_moved_ = source.sleepers_moved_;
  broad_.assign(source.broad_);
  assign_caches(source.caches_);
}

void CollisionScene::Impl::assign_caches(const std::vector<PairCache>& source) {
  // Slots beyond the source's stay, for their lists' memory, with what new ones begin with: nothing
  // reads it, but snapshots contain it.
  for (std::size_t i = source.size(); i < caches_.size(); ++i) {
    copy_cache(PairCache{}, caches_[i], pool_, false);
  }
  if (caches_.size() < source.size()) caches_.resize(source.size());
  // Patches that are not needed go back before others are taken, so that the pool does not grow
  // where only their pairs have changed.
  bool complete = true;
  for (std::size_t i = 0; i < source.size(); ++i) {
    complete = copy_cache(source[i], caches_[i], pool_, false) && complete;
  }
  for (std::size_t i = 0; i < source.size() && !complete; ++i) {
    copy_cache(source[i], caches_[i], pool_, true);
  }
}

std::unique_ptr<pbd::ContactSource> CollisionScene::make_empty() const {
  if (typeid(*this) != typeid(CollisionScene)) return nullptr;
  return std::make_unique<CollisionScene>(options());
}

bool CollisionScene::assign(const pbd::ContactSource& source) {
  const auto* other = dynamic_cast<const CollisionScene*>(&source);
  if (other == nullptr) return false;
  impl_->assign(*other->impl_);
  return true;
}

}  // namespace tandem::collision
