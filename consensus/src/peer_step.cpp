// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// What a peer does before and after a step, in that order.
#include <algorithm>
#include <cmath>

#include "peer_impl.h"
#include "tandem/pbd/math.h"

namespace tandem::consensus {
namespace {

/// Of what agreement asks for in a step: a body that does less is in something's way, and one that
/// does it is on its way, or between neighbours that it cannot both follow.
constexpr double kBlocked = 0.5;

/// s: nobody steps so slowly.
constexpr double kLongestStep = 0.5;

}  // namespace

Peer::Impl::Impl(pbd::World& world, Transport& transport, const PeerOptions& options)
    : options_(options),
      world_(world),
      transport_(transport),
      springs_(world, options_),
      history_(to_ns(options.influence.max_age)),
      inbox_({.max_age = options.influence.max_age,
              .max_future = options.max_future,
              .plausibility = options.plausibility}),
      predictor_(options.own_predictor != nullptr
                     ? options.own_predictor
                     : make_predictor(options.predictor, options.prediction)) {
  // Others' forces pull, and an owner's state is not averaged.
  const bool averaged =
      options.coupling == Coupling::OnePass || options.coupling == Coupling::TwoStep;
  if (options.predictor == PredictorKind::Replay && options.own_predictor == nullptr && averaged) {
    replay_ = std::make_unique<Replay>(world, history_, springs_, options.replay);
  }
  if (options.sending.selects() || options.sending.format != StateFormat::Full) {
    SendOptions sending = options.sending;
    // Who owns a body must be heard of before it is taken for gone.
    const bool owners = options.coupling == Coupling::SingleOwner;
    if (owners)
      sending.rest_refresh = std::min(sending.rest_refresh, 0.5 * options.influence.max_age);
    outbox_ = std::make_unique<Outbox>(sending, transport);
  }
  if (options.coupling == Coupling::SingleOwner) {
    ownership_ = std::make_unique<Ownership>(transport.self(), options.influence.max_age);
  }
}

void Peer::Impl::before_step(SessionTime now) {
  step_dt_ = last_before_ > 0 ? seconds(now - last_before_) : 1.0 / 60.0;
  if (step_dt_ < 0.0) {  // a clock that was set back: nothing moves, and nobody falls silent
    step_dt_ = 0.0;
    next_send_ = now;
  }
  // The clock was set, or nothing was stepped for long: what is remembered is of other times.
  if (now < last_before_ || step_dt_ > kLongestStep) history_.clear();
  last_before_ = now;
  now_ = now;
  // An instance that nothing has moved yet is known from now on.
  if (history_.empty()) history_.add(now, world_);
  history_.notice(world_);
  receive(now);
  springs_.prepare(now);
  if (ownership_ != nullptr) update_ownership(now);
  aggregate(now);
  if (!in_pass()) apply_coupling();
}

void Peer::Impl::after_step(SessionTime now) {
  now_ = now;
  if (started_ == 0) started_ = now;
  mark_joints();
  mark_acting();
  spread_acting();
  const double dt = seconds(now - last_before_);
  for (std::size_t i = 0; i < shared_.size(); ++i) {
    Shared& shared = shared_[i];
    if (!world_.contains(shared.def.body)) continue;
    if (shared.hard.active) {
      // Whatever the step has made of it: physics has no say, [friston] Fig. 2.
      shared.hard.own = carried(shared.hard.own, dt);
      shared.hard.shown = carried(shared.hard.shown, dt);
      world_.set_pose(shared.def.body, shared.hard.shown.pose);
      world_.set_twist(shared.def.body, shared.hard.shown.twist);
    }
    const pbd::Correction correction =
        in_pass() ? world_.correction(shared.def.body) : shared.averaged;
    // Others set poses as they like.
    shared.blocked = !in_pass() || correction.translation.dot(shared.asked) <
                                       kBlocked * shared.asked.squaredNorm();
    if (jumps(shared, correction, dt)) shared.jumped = kJumpTold;
    note_grip(shared);
    shared.averaged = {};
    update_initiative(shared, inbox_.newest_at(i), now);
  }
  history_.add(now, world_);
  if (replay_ != nullptr) replay_->keep();
  if (now >= next_send_) {
    const auto interval = static_cast<SessionTime>(1.0 / (kNs * options_.update_hz));
    next_send_ = std::max(next_send_ + interval, now - interval);
    send(now);
  }
}

void Peer::Impl::collect(const pbd::SolverOptions& options, std::vector<pbd::PoseTarget>& out) {
  if (replay_ != nullptr) replay_->set_solver(options);
  // Nothing is remembered where the world is stepped before its peer was told of it.
  if (replay_ != nullptr && !history_.empty()) {
    history_.note_inputs(world_);
    springs_.record(history_.pulls());
  }
  if (in_pass()) out.insert(out.end(), targets_.begin(), targets_.end());
}

bool Peer::Impl::jumps(const Shared& shared, const pbd::Correction& correction, double dt) const {
  const pbd::BodyState& state = world_.state(shared.def.body);
  if (!history_.knows(shared.def.body.index)) return false;
  const pbd::BodyState& last = history_.newest(shared.def.body.index);
  const double reach =
      2.0 * dt * std::max(state.twist.linear.norm(), last.twist.linear.norm()) + kJump;
  const pbd::Vec3 way = state.pose.position - last.pose.position - correction.translation;
  return way.squaredNorm() > reach * reach;
}

void Peer::Impl::place(Shared& shared, const pbd::BodyState& state) {
  world_.set_pose(shared.def.body, state.pose);
  world_.set_twist(shared.def.body, state.twist);
  history_.restart(shared.def.body.index, world_);
}

}  // namespace tandem::consensus
