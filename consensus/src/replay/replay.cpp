// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "replay/replay.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/body_state.h"
#include "common/session_time.h"
#include "common/stable_share.h"
#include "tandem/consensus/influence.h"
#include "tandem/pbd/cpu_timer.h"
#include "tandem/pbd/validate.h"

namespace tandem::consensus {
namespace {

constexpr double kAll = std::numeric_limits<double>::infinity();

/// Frames: states of one peer no further apart are blended together. They came in several packets,
/// and bodies that touch must not be moved one after the other: a pile of 900 cubes had them up to
/// 17 mm, the motion of one frame, behind.
constexpr std::size_t kTogether = 3;

/// Carried news get this part of the share that is stable for an extrapolation. With one peer at
/// 0.15 s beside two honest ones, the others' p50 is 1.07 times that without it, and 1.12 with the
/// whole share (cubes, six seeds).
constexpr double kCarried = 0.5;

/// Another peer's state moved from its stamp to the frame: the difference to the local motion is
/// kept. Tennis off the grid, profile 3, all p95: 6.3 mm, 20 without it. An owner's state is
/// extrapolated by its own velocity: the local motion contains the whole last correction, which
/// would be made again (tests/consensus/peer_owner_test.cpp, a chain).
pbd::BodyState at_frame(const WorldHistory& history, const Replay::News& news) {
  const SessionTime time = history.frame(news.frame).time;
  if (time == news.stamp) return news.state;
  const double dt = seconds(time - news.stamp);
  if (std::isinf(news.weight)) return carried(news.state, dt);
  const pbd::BodyState then = history.state_beside(news.slot, news.stamp, news.state.twist);
  const pbd::BodyState own = history.state_at(news.slot, time);
  pbd::Correction apart = gap(then, news.state);
  apart.translation += dt * apart.twist.linear;
  apart.rotation += dt * apart.twist.angular;
  const pbd::Correction behind = history.lag(news.slot, news.stamp, time);
  apart.translation += behind.translation;
  apart.rotation += behind.rotation;
  return moved(own, apart);
}

}  // namespace

using pbd::detail::require;

void ReplayOptions::validate() const {
  require(share > 0.0 && share <= 1.0, "ReplayOptions", "share", share, "above 0 and at most 1");
  require(budget >= 1.0, "ReplayOptions", "budget", budget, "at least 1");
  require(tolerance >= 0.0 && std::isfinite(tolerance), "ReplayOptions", "tolerance", tolerance,
          "finite and >= 0 m");
}

std::size_t Replay::awake() const {
  std::size_t count = 0;
  const pbd::PropsTable& props = world_.all_props();
  for (std::uint32_t slot = 0; slot < props.size(); ++slot) {
    count += props[slot].type == pbd::BodyType::Dynamic && world_.awake_at(slot) ? 1 : 0;
  }
  return count;
}

void Replay::set_solver(const pbd::SolverOptions& options) {
  if (solver_.has_value() && options == solved_with_) return;
  solved_with_ = options;
  pbd::SolverOptions own = options;
  own.measure_stages = false;
  own.observer = nullptr;
  solver_.emplace(own);
}

PeerId Replay::update(ReplayStats& stats) {
  if (news_.empty() || history_.empty() || !possible()) {
    drop();
    return 0;
  }
  const pbd::CpuTimer timer(stats.seconds);
  bring_together();
  if (schedule_.is_due(history_, start_, awake(), options_.budget)) {
    if (!start()) {
      ++stats.without;
      drop();
      return oldest_;
    }
    ++stats.fresh;
    schedule_.begun();
  } else if (!slots_.empty() && schedule_.steps_along() && reached_ + 1 == history_.last()) {
    ++stats.postponed;
    forget_strangers();
    next_ = news_.size();  // the continued replay does not use them
  } else {
    ++stats.without;
    drop();
    return oldest_;
  }
  bool begins = true;
  for (; reached_ < history_.last(); ++reached_, begins = false) {
    take_late(reached_, begins);
    if (step_from(reached_, stats)) continue;
    drop();
    return 0;
  }
  take_late(reached_, begins);
  if (schedule_.is_fresh()) blend(reached_);
  for (std::uint32_t slot = 0; slot < slots_.size(); ++slot) {
    // Another body may have taken the slot since the replay began.
    slots_[slot].covered = slots_[slot].covered && is_here(slot);
    if (!slots_[slot].covered) continue;
    slots_[slot].gap = gap(history_.present(slot), copy_.world().states()[slot]);
  }
  return 0;
}

void Replay::keep() {
  if (!possible() || history_.empty()) return;
  copies_ = snapshots_.keep(history_.last(), world_, awake() == 0, springs_);
}

void Replay::bring_together() {
  for (News& news : news_) news.frame = history_.nearest(news.stamp);
  std::sort(news_.begin(), news_.end(), [](const News& a, const News& b) {
    return a.peer != b.peer ? a.peer < b.peer
                            : (a.frame != b.frame ? a.frame > b.frame : a.slot < b.slot);
  });
  // Where a peer has not sent a state lately, it relies on prediction: the replay provides that.
  start_ = history_.last();
  oldest_ = 0;
  const bool goes_back =
      std::any_of(news_.begin(), news_.end(), [](const News& news) { return !news.carried; });
  auto kept = news_.begin();
  for (auto first = news_.begin(); first != news_.end();) {
    const auto last = std::find_if(first, news_.end(), [&](const News& news) {
      return news.peer != first->peer || news.frame + kTogether < first->frame;
    });
    const std::size_t frame = std::prev(last)->frame;
    const PeerId peer = first->peer;
    if (frame < start_ && !(first->carried && goes_back)) {
      oldest_ = peer;
      start_ = frame;
    }
    for (; first != last; ++first, ++kept) {
      if (kept != first) *kept = *first;
      kept->frame = frame;
    }
    while (first != news_.end() && first->peer == peer) ++first;
  }
  news_.erase(kept, news_.end());
  // Snapshots are kept from the first request on: until then a replay begins where it can.
  while (start_ < history_.last() && snapshots_.find(start_, history_.last()) == nullptr) ++start_;
  carry_to_start();
}

void Replay::carry_to_start() {
  for (News& news : news_) {
    if (news.frame >= start_) continue;
    news.frame = start_;
    if (!news.carried) continue;
    // It lacks the corrections made since, which are then made again.
    const double age = seconds(history_.frame(start_).time - news.stamp);
    news.weight =
        std::min(news.weight, weight_of_share(kCarried * stable_share(age) / options_.share));
  }
}

bool Replay::is_here(std::uint32_t slot) const {
  const pbd::BodyId body = copy_.world().body_at(slot);
  return body.valid() && body == world_.body_at(slot);
}

void Replay::forget_strangers() {
  std::erase_if(news_, [this](const News& news) { return !is_here(news.slot); });
  std::erase_if(prescribed_, [this](const Prescribed& body) { return !is_here(body.slot); });
}

bool Replay::start() {
  const Snapshots::Snapshot* const snapshot = snapshots_.find(start_, history_.last());
  if (snapshot == nullptr || !copy_.assign(snapshot->world.world())) return false;
  const auto by_frame = [](const News& a, const News& b) {
    return a.frame != b.frame ? a.frame < b.frame
                              : (a.slot != b.slot ? a.slot < b.slot : a.peer < b.peer);
  };
  pbd::World& world = copy_.world();
  forget_strangers();
  std::sort(news_.begin(), news_.end(), by_frame);
  next_ = 0;
  reached_ = start_;
  const SessionTime begins = history_.frame(start_).time;
  slots_.assign(world_.slot_count(), {});
  for (const News& news : news_) {
    slots_[news.slot].covered = true;
    if (!world.awake_at(news.slot)) {
      copy_.set_state(news.slot, world.states()[news.slot], true);
    }
    // A body placed since has no past in common with the others' copies.
    if (history_.since(news.slot) > begins) prescribe({.slot = news.slot});
  }
  tethers_.begin(world_, world, snapshot->rows, begins);
  return true;
}

bool Replay::step_from(std::size_t frame, ReplayStats& stats) {
  blend(frame);
  apply_inputs(frame);
  const SessionTime time = history_.frame(frame).time;
  const double dt = seconds(history_.frame(frame + 1).time - time);
  tethers_.apply(copy_.world(), time, dt);
  if (hook_ != nullptr) hook_->before_step(copy_.world(), time, dt);
  const pbd::StepReport& report = solver_->step(copy_.world(), dt);
  ++stats.steps;
  stats.body_steps += static_cast<std::uint64_t>(report.awake);
  return report.status == pbd::StepStatus::Ok;
}

void Replay::take_late(std::size_t frame, bool begins) {
  const std::vector<WorldHistory::Late>& all = history_.late();
  if (all.empty()) return;
  const SessionTime time = history_.frame(frame).time;
  const SessionTime before = begins ? 0 : history_.frame(frame - 1).time;
  // A copy of the world from then lacks what was taken later; a continued replay lacks only what
  // was taken in the last frame.
  const SessionTime lacks = schedule_.is_fresh() ? time : history_.frame(history_.last()).time;
  for (const WorldHistory::Late& late : all) {
    const bool due = begins ? late.taken >= lacks : late.done > before;
    if (due && late.done < time) push(late, time);
  }
}

void Replay::push(const WorldHistory::Late& late, SessionTime time) {
  if (!is_here(late.slot)) return;
  const pbd::BodyState state = copy_.world().states()[late.slot];
  copy_.set_state(late.slot, late.added_to(state, time), true);
}

void Replay::blend(std::size_t frame) {
  while (next_ < news_.size() && news_[next_].frame == frame) {
    const std::uint32_t slot = news_[next_].slot;
    double& weight = slots_[slot].weight;
    const pbd::BodyState before = copy_.world().states()[slot];
    estimates_.clear();
    double total = 0.0;
    for (; next_ < news_.size() && news_[next_].frame == frame && news_[next_].slot == slot;
         ++next_) {
      const News& news = news_[next_];
      const pbd::BodyState state = at_frame(history_, news);
      // Relative to all that was blended before, as fuse() has it relative to the local state.
      double part = std::isinf(weight) ? 0.0 : news.weight / weight;
      if (std::isinf(news.weight)) part = kAll;
      estimates_.push_back({.peer = news.peer,
                            .pose = state.pose,
                            .twist = state.twist,
                            .share = share_of_weight(part)});
      total += news.weight;
    }
    pbd::PoseTarget target;
    if (!fuse(before.pose, estimates_, target)) continue;
    weight += total;
    copy_.displace(slot, mean_with(before, target));
  }
}

void Replay::apply_inputs(std::size_t number) {
  pbd::World& world = copy_.world();
  const WorldHistory::Frame& frame = history_.frame(number);
  if (world.gravity() != frame.gravity) world.set_gravity(frame.gravity);
  for (const WorldHistory::State& placed : frame.placed) {
    if (is_here(placed.slot)) copy_.set_state(placed.slot, placed.state, true);
  }
  for (const WorldHistory::Push& pushed : frame.pushed) {
    if (!is_here(pushed.slot)) continue;
    pbd::BodyState state = world.states()[pushed.slot];
    state.twist.linear += pushed.twist.linear;
    state.twist.angular += pushed.twist.angular;
    copy_.set_state(pushed.slot, state, true);
  }
  for (const WorldHistory::Late& late : history_.late()) {
    if (late.done == frame.time) push(late, frame.time);
  }
  for (const Prescribed& body : prescribed_) {
    if (!body.from.has_value()) {
      copy_.set_state(body.slot, history_.state_at(body.slot, frame.time), true);
      continue;
    }
    const double dt = seconds(frame.time - body.stamp);
    copy_.set_state(body.slot, carried(*body.from, dt), true);
  }
  for (const WorldHistory::Force& force : frame.forces) {
    const pbd::BodyId body = world.body_at(force.slot);
    if (!is_here(force.slot) || world.props(body).type != pbd::BodyType::Dynamic) continue;
    world.apply_force(body, force.wrench.force);
    world.apply_torque(body, force.wrench.torque);
  }
}

}  // namespace tandem::consensus
