// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "input/acts.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/body_state.h"
#include "common/ranges.h"
#include "common/session_time.h"

namespace tandem::consensus {
namespace {

/// ns: acts under one name within this time are one act, and receipts are tracked for this long.
constexpr SessionTime kOneAct = 1'000'000'000;

/// If a body has gained this part of an act's change before the act arrived here, it has already
/// followed others' states.
constexpr double kFollowed = 0.2;

/// m/s and rad/s: impulses are first cut to this change of speed.
constexpr double kMaxChange = 1e5;

/// `after`, shortened to `limit` or to the length of `before`, whichever is longer.
pbd::Vec3 within(const pbd::Vec3& before, const pbd::Vec3& after, double limit) {
  const double most = std::max(limit, before.norm());
  const double length = after.norm();
  return length > most ? pbd::Vec3(after * (most / length)) : after;
}

/// The fraction of an impulse that changes a speed by at most kMaxChange.
double bearable(double change) { return change > kMaxChange ? kMaxChange / change : 1.0; }

}  // namespace

SessionTime Acts::last_frame(SessionTime now) const {
  return history_.empty() ? now : history_.frame(history_.last()).time;
}

bool Acts::act(const ActDef& def, SharedBody& shared, PeerId self, bool owned, SessionTime now) {
  const pbd::BodyId body = shared.def.body;
  const SessionTime when = last_frame(now);
  if (def.name != 0 && find(body, self, 0, def.name) != nullptr) return true;
  ActUpdate update = as_update(def);
  update.number = next_number_;
  update.stamp = when;
  const pbd::Twist change = apply(update, shared);
  history_.note_own(body.index, world_.state(body), change, def.pose.has_value());
  if (owned) return true;  // its states convey it
  if (!budget_.fill(now) || acts_.size() >= kMaxOfAll) return false;
  budget_.spend(def.pose ? kPlacing : 1.0);
  ++next_number_;
  pending_.push_back(update);
  marks_.push_back({body.index, true});
  remember({.actor = self,
            .number = update.number,
            .name = def.name,
            .body = body,
            .sets_pose = def.pose.has_value(),
            .sets_twist = def.twist.has_value(),
            .change = change,
            .done = when,
            .taken = when});
  return true;
}

pbd::Twist Acts::apply(const ActUpdate& act, SharedBody& shared) {
  const pbd::BodyId body = shared.def.body;
  const pbd::BodyProps& props = world_.props(body);
  const pbd::Twist before = world_.state(body).twist;
  if (act.pose) world_.set_pose(body, *act.pose);
  if (act.twist) world_.set_twist(body, *act.twist);
  const pbd::Vec3 impulse = bearable(props.inverse_mass * act.impulse.norm()) * act.impulse;
  if (!impulse.isZero(0.0)) world_.apply_impulse(body, impulse);
  const pbd::Vec3 angular =
      bearable(props.inverse_inertia.norm() * act.angular_impulse.norm()) * act.angular_impulse;
  if (!angular.isZero(0.0)) world_.apply_angular_impulse(body, angular);
  // The limit of hands applies to acts too.
  const pbd::Twist after = within_limits(before, world_.state(body).twist);
  world_.set_twist(body, after);
  return difference(after, before);
}

pbd::Twist Acts::within_limits(const pbd::Twist& before, const pbd::Twist& after) const {
  const RobustOptions& robust = options_.robust;
  return {within(before.linear, after.linear, robust.max_pull_speed),
          within(before.angular, after.angular, robust.max_spin_correction)};
}

bool Acts::receive(PeerId from, const ActUpdate& update, SharedBody& shared,
                   std::span<const Inbox::Received> newest, bool established,
                   pbd::TokenBucket& budget, SessionTime now) {
  const pbd::BodyId body = shared.def.body;
  if (update.stamp < now - to_ns(options_.influence.max_age)) return false;
  if (update.stamp > now + to_ns(options_.max_future)) return false;
  const SessionTime taken = last_frame(now);
  const SessionTime done = std::min(update.stamp, taken);
  if (const Act* const known = find(body, from, update.number, update.name)) {
    // Under one name it was done here already, on account of another peer: this actor has it too.
    if (known->name == 0 || known->actor == from) return true;
    note_receipt(*known, from, done);
    marks_.push_back({body.index, false});
    return true;
  }
  if (!budget.admits(now) || acts_.size() >= kMaxOfAll) return false;
  budget.spend(update.pose ? kPlacing : 1.0);
  // A newcomer's copy came from peers that had already done the act.
  const bool has_it = !established && shared.joined && history_.knows(body.index) &&
                      history_.since(body.index) > done;
  pbd::Twist change;
  if (!has_it && !is_superseded(body, update.pose.has_value(), done, from)) {
    change = take(update, shared, done, newest, from);
  }
  remember({.actor = from,
            .number = update.number,
            .name = update.name,
            .body = body,
            .sets_pose = update.pose.has_value(),
            .sets_twist = update.twist.has_value(),
            .change = change,
            .done = done,
            .taken = taken});
  marks_.push_back({body.index, false});
  done_.push_back({.actor = from,
                   .number = update.number,
                   .body = update.body,
                   .name = update.name,
                   .stamp = taken});
  return true;
}

pbd::Twist Acts::take(const ActUpdate& update, SharedBody& shared, SessionTime done,
                      std::span<const Inbox::Received> newest, PeerId from) {
  const pbd::BodyId body = shared.def.body;
  const SessionTime taken = last_frame(done);
  const pbd::BodyState before = world_.state(body);
  ActUpdate act = update;
  if (act.pose) {
    // Extrapolated to now, in a straight line.
    const pbd::Twist twist = within_limits(before.twist, act.twist.value_or(before.twist));
    act.pose = carried({*act.pose, twist}, seconds(taken - done)).pose;
    apply(act, shared);
    history_.restart(body.index, world_);
    ++shared.placed;
    shared.jumped = SharedBody::kJumpTold;
    return difference(world_.state(body).twist, before.twist);
  }
  if (act.twist && history_.knows(body.index)) {
    // Set relative to the twist at that time: changes since, as by gravity, remain.
    const pbd::Twist then = history_.state_at(body.index, done).twist;
    act.twist->linear += before.twist.linear - then.linear;
    act.twist->angular += before.twist.angular - then.angular;
  }
  const pbd::Twist change = apply(act, shared);
  const double dt = seconds(taken - done);
  WorldHistory::Late late{.slot = body.index,
                          .twist = change,
                          .now = change,
                          .done = done,
                          .followed = taken,
                          .taken = taken,
                          .behind = {dt * change.linear, dt * change.angular, {}}};
  const auto sent = ranges::find(newest, from, &Inbox::Received::peer);
  // Resent after a loss, or overtaken: the body has meanwhile followed states that include it.
  const bool told = sent != newest.end() && sent->update.stamp > done;
  if (told &&
      (sent->arrival < taken || part_gained(body, before.twist, change, done) > kFollowed)) {
    follow(body, *sent, before, late);
    world_.set_twist(
        body, {before.twist.linear + late.now.linear, before.twist.angular + late.now.angular});
  }
  history_.note_late(late);
  return late.now;
}

void Acts::follow(pbd::BodyId body, const Inbox::Received& sent, const pbd::BodyState& before,
                  WorldHistory::Late& late) const {
  const pbd::Twist change = late.twist;
  const SessionTime stamp = sent.update.stamp;
  const double then = part_missing(body, sent, change);
  const double since = part_gained(body, before.twist, change, stamp);
  const double now = std::clamp(then - std::max(since, 0.0), 0.0, 1.0);
  late.twist = {then * change.linear, then * change.angular};
  late.now = {now * change.linear, now * change.angular};
  late.followed = std::min(late.taken, sent.arrival);
  if (!history_.knows(body.index)) return;
  // Less the displacement beyond the local motion since that state.
  const pbd::BodyState old = history_.state_at(body.index, stamp);
  const double age = seconds(late.taken - stamp);
  const double dt = seconds(late.taken - late.done);
  late.behind.translation = dt * late.twist.linear;
  late.behind.rotation = dt * late.twist.angular;
  const pbd::Vec3 gained = before.pose.position - old.pose.position - age * old.twist.linear;
  const double square = late.behind.translation.squaredNorm();
  if (!(square > 0.0)) return;
  const double part = std::clamp(gained.dot(late.behind.translation) / square, 0.0, 1.0);
  late.behind.translation *= 1.0 - part;
  late.behind.rotation *= 1.0 - part;
}

double Acts::part_gained(pbd::BodyId body, const pbd::Twist& now, const pbd::Twist& change,
                         SessionTime done) const {
  const double square = change.linear.squaredNorm();
  if (!(square > 0.0) || !history_.knows(body.index)) return 0.0;
  pbd::Vec3 gained = now.linear - history_.state_at(body.index, done).twist.linear;
  for (const Act& other : acts_) {
    if (other.body == body && other.taken >= done) gained -= other.change.linear;
  }
  return gained.dot(change.linear) / square;
}

double Acts::part_missing(pbd::BodyId body, const Inbox::Received& sent,
                          const pbd::Twist& change) const {
  const double square = change.linear.squaredNorm();
  if (!(square > 0.0) || !history_.knows(body.index)) return 1.0;
  const StateUpdate& there = sent.update;
  pbd::Vec3 missing = there.twist.linear - history_.state_at(body.index, there.stamp).twist.linear;
  for (const Act& other : acts_) {
    if (other.body == body && lacks(other, sent, there.stamp)) missing += other.change.linear;
  }
  return std::clamp(missing.dot(change.linear) / square, 0.0, 1.0);
}

bool Acts::is_superseded(pbd::BodyId body, bool sets_pose, SessionTime done, PeerId actor) const {
  return ranges::any_of(acts_, [&](const Act& act) {
    if (act.body != body || !(sets_pose ? act.sets_pose : act.sets_twist)) return false;
    return act.done != done ? act.done > done : act.actor > actor;
  });
}

Acts::Act* Acts::find(pbd::BodyId body, PeerId actor, std::uint32_t number, std::uint64_t name) {
  if (body.index >= count_.size() || count_[body.index] == 0) return nullptr;
  const auto at = std::find_if(acts_.begin(), acts_.end(), [&](const Act& act) {
    if (act.body != body || act.name != name) return false;
    return name != 0 || (act.actor == actor && act.number == number);
  });
  return at != acts_.end() ? &*at : nullptr;
}

void Acts::remember(Act act) {
  act.serial = next_serial_++;
  if (count_.size() <= act.body.index) count_.resize(act.body.index + 1, 0);
  ++count_[act.body.index];
  acts_.push_back(act);
  note_receipt(act, act.actor, act.done);
}

void Acts::note_receipt(const Act& act, PeerId peer, SessionTime stamp) {
  const auto key = [](const Receipt& receipt) { return std::pair(receipt.act, receipt.peer); };
  const auto at = ranges::lower_bound(receipts_, std::pair(act.serial, peer), key);
  if (at != receipts_.end() && key(*at) == std::pair(act.serial, peer)) return;
  if (receipts_.size() < kMaxReceipts) receipts_.insert(at, {act.serial, peer, stamp});
}

void Acts::receive(PeerId from, const ActReceipt& receipt, pbd::BodyId body) {
  const Act* const act = find(body, receipt.actor, receipt.number, receipt.name);
  if (act != nullptr) note_receipt(*act, from, receipt.stamp);
}

void Acts::prepare(SessionTime now) {
  // Numbers continue from the clock (ms), as springs' do.
  if (next_number_ == 0) next_number_ = static_cast<std::uint32_t>(now / 1'000'000);
  for (ActUpdate& act : pending_) {
    if (act.stamp == 0) act.stamp = now;
  }
  for (Act& act : acts_) {
    if (act.done == 0) act.done = act.taken = now;
  }
  const auto first = acts_.empty() ? next_serial_ : acts_.front().serial;
  std::erase_if(acts_, [&](const Act& act) {
    const bool old = std::abs(now - act.taken) > kOneAct;
    if (old) --count_[act.body.index];
    return old;
  });
  if ((acts_.empty() ? next_serial_ : acts_.front().serial) == first) return;
  std::erase_if(receipts_, [&](const Receipt& receipt) {
    return !ranges::binary_search(acts_, receipt.act, &Act::serial);
  });
}

void Acts::forget_body(pbd::BodyId body) {
  std::erase_if(acts_, [&](const Act& act) {
    if (act.body == body) --count_[body.index];
    return act.body == body;
  });
}

void Acts::announce(std::vector<ActUpdate>& acts, std::vector<ActReceipt>& receipts) {
  acts.insert(acts.end(), pending_.begin(), pending_.end());
  pending_.clear();
  receipts.insert(receipts.end(), done_.begin(), done_.end());
  done_.clear();
}

bool Acts::lacks(const Act& act, const Inbox::Received& received, SessionTime until) const {
  // A state from before the act is not held against its sender.
  if (until <= act.done) return false;
  const auto key = [](const Receipt& receipt) { return std::pair(receipt.act, receipt.peer); };
  const auto wanted = std::pair(act.serial, received.peer);
  const auto at = ranges::lower_bound(receipts_, wanted, key);
  const bool has = at != receipts_.end() && key(*at) == wanted;
  return !has || received.update.stamp <= at->stamp;
}

std::span<const Inbox::Received> Acts::knowing(pbd::BodyId body, const Inbox& inbox,
                                               std::span<const Inbox::Received> newest) {
  if (body.index >= count_.size() || count_[body.index] == 0) return newest;
  heard_.clear();
  for (const Inbox::Received& received : newest) {
    const SessionTime until = inbox.holds_until(received);
    const bool behind = ranges::any_of(
        acts_, [&](const Act& act) { return act.body == body && lacks(act, received, until); });
    if (!behind) heard_.push_back(received);
  }
  return heard_;
}

bool Acts::acted(PeerId peer, pbd::BodyId body) const {
  if (body.index >= count_.size() || count_[body.index] == 0) return false;
  return ranges::any_of(acts_,
                        [&](const Act& act) { return act.body == body && act.actor == peer; });
}

void Acts::mark(std::uint8_t own, std::uint8_t other, std::vector<std::uint8_t>& acting) {
  for (const Mark& mark : marks_) {
    if (mark.slot >= acting.size()) continue;
    acting[mark.slot] = static_cast<std::uint8_t>(acting[mark.slot] | (mark.own ? own : other));
  }
  marks_.clear();
}

}  // namespace tandem::consensus
