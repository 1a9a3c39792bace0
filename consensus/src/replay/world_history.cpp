// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "replay/world_history.h"

#include <algorithm>

#include "common/body_state.h"
#include "common/ranges.h"
#include "common/session_time.h"
#include "tandem/pbd/math.h"

namespace tandem::consensus {
namespace {

/// m/s: a larger change between frames is a hit. Tennis off the grid, profile 3: all p95 6.3 mm and
/// p99 14; 8.0 and 22 without this.
constexpr double kHit = 0.5;

bool same(const pbd::Pose& a, const pbd::Pose& b) {
  return a.position == b.position && a.orientation.coeffs() == b.orientation.coeffs();
}
bool same(const pbd::Twist& a, const pbd::Twist& b) {
  return a.linear == b.linear && a.angular == b.angular;
}

}  // namespace

void WorldHistory::grow() {
  std::vector<Frame> larger(frames_.empty() ? 16 : 2 * frames_.size());
  for (std::size_t n = first(); n < end_; ++n) {
    larger[n % larger.size()] = std::move(frames_[n % frames_.size()]);
  }
  frames_ = std::move(larger);
}

void WorldHistory::notice(const pbd::World& world) {
  Frame& frame = newest_frame();
  const std::size_t slots = world.slot_count();
  frame.states.resize(slots);
  const std::size_t known = generations_.size();
  since_.resize(slots, frame.time);
  generations_.resize(slots, 0);
  for (std::uint32_t slot = 0; slot < slots; ++slot) {
    const std::uint32_t generation = world.body_at(slot).generation;
    if (slot < known && generation == generations_[slot]) continue;
    if (slot < known) std::erase_if(late_, [slot](const Late& l) { return l.slot == slot; });
    generations_[slot] = generation;
    since_[slot] = frame.time;
    frame.states[slot] = world.states()[slot];
  }
}

void WorldHistory::add(SessionTime time, const pbd::World& world) {
  if (count_ > 0 && time <= frame(last()).time) clear();
  // One frame that is too old stays, so that all younger times lie between two frames.
  while (count_ > 2 && frame(first() + 1).time < time - longest_) --count_;
  if (count_ == frames_.size()) grow();
  ++end_;
  ++count_;
  Frame& frame = newest_frame();
  frame.time = time;
  frame.states.assign(world.states().begin(), world.states().end());
  frame.forces.clear();
  frame.placed.clear();
  frame.pushed.clear();
  frame.pulls.clear();
  agreed_.clear();
  acted_.clear();
  noted_ = false;
  std::erase_if(late_, [&](const Late& late) { return late.taken < time - longest_; });
  notice(world);
}

void WorldHistory::note_agreement(std::uint32_t slot, const pbd::World& world) {
  agreed_.push_back({slot, world.states()[slot]});
}

pbd::BodyState WorldHistory::Late::added_to(const pbd::BodyState& state, SessionTime time) const {
  const bool follows = time > followed;
  const pbd::Twist& change = follows ? now : twist;
  // Corrections by agreement since are in the pose.
  const double since = follows ? 0.0 : seconds(time - done);
  return {carried({state.pose, change}, since).pose,
          {state.twist.linear + change.linear, state.twist.angular + change.angular}};
}

void WorldHistory::note_late(const Late& late) {
  if (!knows(late.slot)) return;
  late_.push_back(late);
  const auto acted = ranges::find(acted_, late.slot, &Push::slot);
  pbd::Twist& sum =
      (acted != acted_.end() ? *acted : acted_.emplace_back(Push{.slot = late.slot})).twist;
  sum.linear += late.now.linear;
  sum.angular += late.now.angular;
}

void WorldHistory::note_own(std::uint32_t slot, const pbd::BodyState& state,
                            const pbd::Twist& change, bool placed) {
  if (!noted_ || !knows(slot)) return;
  if (placed) {
    newest_frame().placed.push_back({slot, state});
  } else {
    newest_frame().pushed.push_back({slot, change});
  }
}

void WorldHistory::restart(std::uint32_t slot, const pbd::World& world) {
  if (!knows(slot)) return;
  std::erase_if(late_, [slot](const Late& late) { return late.slot == slot; });
  std::erase_if(acted_, [slot](const Push& push) { return push.slot == slot; });
  since_[slot] = frame(last()).time;
  newest_frame().states[slot] = world.states()[slot];
}

void WorldHistory::note_inputs(const pbd::World& world) {
  if (count_ == 0) return;
  notice(world);
  noted_ = true;
  Frame& frame = newest_frame();
  frame.gravity = world.gravity();
  frame.forces.clear();
  frame.placed.clear();
  frame.pushed.clear();
  for (std::uint32_t slot = 0; slot < world.wrenches().size(); ++slot) {
    const pbd::Wrench& wrench = world.wrenches()[slot];
    if (!wrench.force.isZero(0.0) || !wrench.torque.isZero(0.0)) {
      frame.forces.push_back({slot, wrench});
    }
  }
  ranges::sort(agreed_, &State::slot);
  ranges::sort(acted_, &Push::slot);
  auto agreed = agreed_.begin();
  auto acted = acted_.begin();
  const std::span<const pbd::BodyState> states = world.states();
  for (std::uint32_t slot = 0; slot < states.size(); ++slot) {
    const pbd::BodyState* expected = &frame.states[slot];
    pbd::BodyState with_acts;
    while (acted != acted_.end() && acted->slot < slot) ++acted;
    if (acted != acted_.end() && acted->slot == slot) {
      with_acts = *expected;
      with_acts.twist.linear += acted->twist.linear;
      with_acts.twist.angular += acted->twist.angular;
      expected = &with_acts;
    }
    for (; agreed != agreed_.end() && agreed->slot <= slot; ++agreed) {
      if (agreed->slot == slot) expected = &agreed->state;
    }
    const pbd::BodyState& state = states[slot];
    const pbd::BodyType type = world.all_props()[slot].type;
    if (type == pbd::BodyType::Static) continue;
    if (type == pbd::BodyType::Kinematic || !same(state.pose, expected->pose)) {
      frame.placed.push_back({slot, state});
    } else if (!same(state.twist, expected->twist)) {
      frame.pushed.push_back({slot, difference(state.twist, expected->twist)});
    }
  }
}

std::size_t WorldHistory::at_or_before(SessionTime time) const {
  // Steps have similar lengths, so that the guess is seldom off by more than one.
  std::size_t n = last();
  if (count_ > 1 && time < frame(n).time) {
    const SessionTime step = std::max<SessionTime>(frame(n).time - frame(n - 1).time, 1);
    const auto back = static_cast<std::size_t>((frame(n).time - time) / step);
    n -= std::min(back, count_ - 1);
  }
  while (n > first() && frame(n).time > time) --n;
  while (n < last() && frame(n + 1).time <= time) ++n;
  return n;
}

std::size_t WorldHistory::nearest(SessionTime time) const {
  const std::size_t n = at_or_before(time);
  if (n == last()) return n;
  return frame(n + 1).time - time < time - frame(n).time ? n + 1 : n;
}

bool WorldHistory::placed_since(std::uint32_t slot, SessionTime time) const {
  for (std::size_t n = at_or_before(time); n <= last(); ++n) {
    if (ranges::find(frame(n).placed, slot, &State::slot) != frame(n).placed.end()) return true;
  }
  return false;
}

SessionTime WorldHistory::since(std::uint32_t slot) const {
  return std::max(since_[slot], frame(first()).time);
}

pbd::BodyState WorldHistory::with_late(std::uint32_t slot, SessionTime time,
                                       pbd::BodyState state) const {
  for (const Late& late : late_) {
    if (late.slot != slot || time <= late.done || time > late.taken) continue;
    state = late.added_to(state, time);
  }
  return state;
}

pbd::BodyState WorldHistory::present(std::uint32_t slot) const {
  pbd::BodyState state = newest(slot);
  const SessionTime time = frame(last()).time;
  for (const Late& late : late_) {
    if (late.slot != slot || late.taken != time || late.done == time) continue;
    state.twist.linear += late.now.linear;
    state.twist.angular += late.now.angular;
  }
  return state;
}

pbd::Correction WorldHistory::lag(std::uint32_t slot, SessionTime first, SessionTime end) const {
  pbd::Correction behind{};
  for (const Late& late : late_) {
    if (late.slot != slot || late.taken < first || late.taken >= end) continue;
    behind.translation += late.behind.translation;
    behind.rotation += late.behind.rotation;
  }
  return behind;
}

pbd::BodyState WorldHistory::state_at(std::uint32_t slot, SessionTime time) const {
  const SessionTime known = std::max(time, since(slot));
  const std::size_t n = at_or_before(known);
  const Frame& before = frame(n);
  const pbd::BodyState& a = before.states[slot];
  if (n == last() || known <= before.time) return with_late(slot, known, a);
  const Frame& after = frame(n + 1);
  const pbd::BodyState& b = after.states[slot];
  const double dt = seconds(after.time - before.time);
  const double f = seconds(known - before.time) / dt;
  const pbd::Vec3 way = b.pose.position - a.pose.position;
  pbd::BodyState state;
  state.pose.position =
      a.pose.position + f * way +
      f * (1.0 - f) * ((1.0 - f) * (dt * a.twist.linear - way) - f * (dt * b.twist.linear - way));
  state.pose.orientation = pbd::rotated(
      a.pose.orientation, f * pbd::rotation_between(a.pose.orientation, b.pose.orientation));
  state.twist.linear = a.twist.linear + f * (b.twist.linear - a.twist.linear);
  state.twist.angular = a.twist.angular + f * (b.twist.angular - a.twist.angular);
  return with_late(slot, known, state);
}

pbd::BodyState WorldHistory::state_beside(std::uint32_t slot, SessionTime time,
                                          const pbd::Twist& other) const {
  const std::size_t n = at_or_before(time);
  if (time <= since(slot) || n == last()) return state_at(slot, time);
  const pbd::BodyState& a = frame(n).states[slot];
  const pbd::BodyState& b = frame(n + 1).states[slot];
  const double off_a = speed(difference(a.twist, other));
  const double off_b = speed(difference(b.twist, other));
  if (!(speed(difference(b.twist, a.twist)) > kHit)) return state_at(slot, time);
  const bool first = off_a < off_b;
  return with_late(slot, time,
                   carried(first ? a : b, seconds(time - frame(first ? n : n + 1).time)));
}

MotionSample OwnMotion::newest() const {
  const pbd::BodyState& state = history_.newest(slot_);
  return {history_.frame(history_.last()).time, state.pose, state.twist};
}

MotionSample OwnMotion::at_time(SessionTime time) const {
  const pbd::BodyState state = history_.state_at(slot_, time);
  return {time, state.pose, state.twist};
}

}  // namespace tandem::consensus
