// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/pbd/world_copy.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <typeinfo>
#include <utility>

#include "tandem/pbd/contact.h"
#include "tandem/pbd/validate.h"

namespace tandem::pbd {
namespace {

[[maybe_unused]] bool is_sound(const BodyState& state) {
  return state.pose.position.allFinite() && state.twist.linear.allFinite() &&
         state.twist.angular.allFinite() &&
         std::abs(state.pose.orientation.norm() - 1.0) < 1e-3;  // false for NaN
}

bool equal(const BodyState& l, const BodyState& r) {
  return l.pose.position == r.pose.position &&
         l.pose.orientation.coeffs() == r.pose.orientation.coeffs() &&
         l.twist.linear == r.twist.linear && l.twist.angular == r.twist.angular;
}

}  // namespace

WorldCopy::WorldCopy() = default;
WorldCopy::~WorldCopy() = default;

WorldCopy::WorldCopy(WorldCopy&& other) noexcept
    : world_(std::move(other.world_)),
      contact_source_(std::move(other.contact_source_)),
      filled_(std::exchange(other.filled_, false)) {}

WorldCopy& WorldCopy::operator=(WorldCopy&& other) noexcept {
  if (this == &other) return *this;
  world_ = std::move(other.world_);
  contact_source_ = std::move(other.contact_source_);
  filled_ = std::exchange(other.filled_, false);
  return *this;
}

void WorldCopy::clear() {
  filled_ = false;
  world_ = World();
  contact_source_.reset();
}

bool WorldCopy::same_kinds(const World& other) const {
  const auto same_kind = [](const auto& l, const auto& r) { return typeid(l) == typeid(r); };
  if ((contact_source_ != nullptr) != (other.contact_source_ != nullptr)) return false;
  if (contact_source_ != nullptr && !same_kind(*contact_source_, *other.contact_source_)) {
    return false;
  }
  return std::equal(world_.blocks_.begin(), world_.blocks_.end(), other.blocks_.begin(),
                    other.blocks_.end(),
                    [&](const auto& l, const auto& r) { return same_kind(*l, *r); });
}

void WorldCopy::copy_bodies(const World& from, World& to) {
  to.gravity_ = from.gravity_;
  to.time_ = from.time_;
  to.states_ = from.states_;
  to.placements_.note();
  to.body_log_.reserve(from.states_.size());
  to.body_log_.outdate();
  to.props_.assign(from.props_);
  to.slots_.assign(from.slots_);
  // Assignment may reallocate each node of a map.
  if (to.by_stable_id_ != from.by_stable_id_) to.by_stable_id_ = from.by_stable_id_;
  to.ranks_ = from.ranks_;
  to.slots_by_rank_ = from.slots_by_rank_;
  to.order_is_old_ = from.order_is_old_;
  to.corrections_ = from.corrections_;
  to.in_contact_ = from.in_contact_;
  to.touching_ = from.touching_;
  to.activity_ = from.activity_;
  to.sleepers_moved_ = from.sleepers_moved_;
  to.wrenches_ = from.wrenches_;
  to.displaced_ = from.displaced_;
  to.kinematic_targets_ = from.kinematic_targets_;
  to.user_data_ = from.user_data_;
}

bool WorldCopy::fill(const World& source) {
  // Drops whatever was set on the copy.
  world_.target_source_ = nullptr;
  world_.contact_source_ = contact_source_.get();
  if (!same_kinds(source)) {
    world_.blocks_.clear();
    world_.contacts_ = nullptr;
    world_.contact_source_ = nullptr;
    contact_source_.reset();
    for (const auto& block : source.blocks_) {
      world_.blocks_.push_back(block->make_empty());
      if (world_.blocks_.back() == nullptr) return false;
      if (block.get() == source.contacts_) {
        world_.contacts_ = static_cast<ContactBlock*>(world_.blocks_.back().get());
      }
    }
    if (source.contact_source_ != nullptr) {
      contact_source_ = source.contact_source_->make_empty();
      if (contact_source_ == nullptr) return false;
      world_.contact_source_ = contact_source_.get();
    }
  }
  copy_bodies(source, world_);
  for (std::size_t i = 0; i < source.blocks_.size(); ++i) {
    if (!world_.blocks_[i]->assign(*source.blocks_[i])) return false;
  }
  return contact_source_ == nullptr || contact_source_->assign(*source.contact_source_);
}

bool WorldCopy::assign(const World& source) {
  if (&source == &world_) return filled_;
  try {
    filled_ = fill(source);
  } catch (...) {  // out of memory
    clear();
    throw;
  }
  if (!filled_) clear();
  return filled_;
}

void WorldCopy::restore(World& target) const {
  if (!filled_) {
    detail::refuse("WorldCopy::restore: the copy", "of a world (assign())", "empty");
  }
  if (&target == &world_) return;
  if (!same_kinds(target)) {
    detail::refuse("WorldCopy::restore: target",
                   "a world with the blocks and the contact source of the one that was copied");
  }
  copy_bodies(world_, target);
  for (std::size_t i = 0; i < target.blocks_.size(); ++i) {
    target.blocks_[i]->assign(*world_.blocks_[i]);
  }
  if (contact_source_ != nullptr) target.contact_source_->assign(*contact_source_);
}

void WorldCopy::set_state(std::uint32_t slot, const BodyState& state, bool awake) {
  assert(slot < world_.slot_count() && world_.slots_.alive(slot));
  assert(is_sound(state));
  BodyActivity& activity = world_.activity_[slot];
  const bool stays_asleep = activity.asleep && !awake && equal(world_.states_[slot], state);
  if (!awake && !stays_asleep) ++world_.sleepers_moved_;
  world_.states_[slot] = state;
  world_.placements_.note();
  world_.note(slot);
  if (world_.props_[slot].type != BodyType::Dynamic) return;
  if (awake && activity.asleep) activity.stir();
  activity.asleep = !awake;
}

void WorldCopy::displace(std::uint32_t slot, const BodyState& state) {
  set_state(slot, state, true);
  world_.displaced_.resize(world_.states_.size(), 0);
  world_.displaced_[slot] = 1;
}

void WorldCopy::clear_inputs() {
  world_.wrenches_.clear();
  world_.kinematic_targets_.clear();
}

}  // namespace tandem::pbd
