// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "agree/estimator.h"

#include <algorithm>

#include "agree/pose_arbiter.h"
#include "common/body_state.h"
#include "common/ranges.h"
#include "common/stable_share.h"
#include "tandem/consensus/influence.h"

namespace tandem::consensus {
namespace {

/// Largest share accepted from a peer that does not own the body.
constexpr double kMaxSharedInfluence = 0.5;
/// Largest share accepted from a peer that leads it: nobody else acts on the body.
constexpr double kMaxLeadersInfluence = 0.8;

/// Largest share in a mean at a stamp of a peer that does not own the body.
constexpr double kMaxOfMean = 0.9999;

/// Weights below this, relative to the local state's 1, are ignored: such a state is neither a vote
/// nor worth a replay.
constexpr double kNegligible = 0.01;

/// m: a newcomer's placement over a longer distance is announced as a jump.
constexpr double kFarAway = 0.1;

}  // namespace

Estimator::Listening Estimator::listening_to(const SharedBody& shared,
                                             std::span<const Inbox::Received> newest, bool replays,
                                             bool by_hand) const {
  return {// Two peers have no majority, and need not pay for votes.
          .several =
              data_.options.robust.outvote && newest.size() >= 2 && !shared.def.owner.has_value(),
          .carried = by_hand || !replays,
          .hands = trust_.believes_hands(newest.size()),
          .own_lead = shared.initiative.strength(),
          .own_announced = std::min(data_.announced(shared), kMaxSharedInfluence),
          .own_confidence = data_.confidence()};
}

void Estimator::estimate(SharedBody& shared, std::span<const Inbox::Received> newest, bool replays,
                         Estimates& out) {
  out.clear();
  if (newest.empty()) return;
  if (data_.changes_hands(shared)) {
    estimate_owner(shared, newest, out);
    return;
  }
  if (rests_where_all_have_it(shared, newest)) return;
  // The effect of a spring that only its own peer knows cannot be replayed.
  const bool hands = trust_.believes_hands(newest.size());
  out.by_hand =
      data_.springs.holds_alone(shared.def.body) || ranges::any_of(newest, [&](const auto& r) {
        return r.update.flags.owner_driven &&
               (shared.def.owner.has_value() ? shared.def.owner == r.peer : hands);
      });
  const Listening listening = listening_to(shared, newest, replays, out.by_hand);
  heaviest_ = 0.0;
  for (std::size_t i = 0; i < newest.size(); ++i) hear(shared, newest, i, listening, replays, out);
  if (!listening.several) return;
  if (listening.own_lead == 0.0 && data_.options.arbitration) placement_.give_way(shared, out);
  out.votes = out.leaders.empty();
  if (!out.votes) keep_leaders(out);
}

bool Estimator::rests_where_all_have_it(const SharedBody& shared,
                                        std::span<const Inbox::Received> newest) const {
  const std::uint32_t slot = shared.def.body.index;
  if (data_.world.awake_at(slot) || data_.confidence() < 1.0) return false;
  const pbd::Pose& own = data_.world.states()[slot].pose;
  return std::all_of(newest.begin(), newest.end(), [&](const Inbox::Received& received) {
    const StateUpdate& there = received.update;
    if (there.rounded || there.flags.owner_driven) return false;
    if (speed(there.twist) > 0.0) return false;
    const double way = (there.pose.position - own.position).norm();
    // rad: for a small angle, twice the distance of the unit quaternions.
    const double turn = 2.0 * (there.pose.orientation.coeffs() - own.orientation.coeffs()).norm();
    return way + kLeverArm * turn <= data_.options.replay.tolerance;
  });
}

void Estimator::hear(SharedBody& shared, std::span<const Inbox::Received> newest, std::size_t i,
                     const Listening& listening, bool replays, Estimates& out) {
  const PeerId from = newest[i].peer;
  const StateUpdate& update = remote_.as_meant(newest[i], shared);
  Hearing hearing{.owner = shared.def.owner == from ||
                           (!shared.def.owner.has_value() && hard_at_sender(update)),
                  .claimed = static_cast<double>(update.influence),
                  .age = seconds(data_.now - update.stamp)};
  const bool owner = hearing.owner;
  if (shared.def.owner.has_value() && !owner) return;
  hearing.leads = update.flags.leads && listening.own_lead == 0.0 &&
                  (!listening.several || trust_.believes_lead(shared, from));
  Prediction prediction;
  const Stamped stamped = remote_.compare(shared, update, prediction);
  const double most = hearing.leads ? kMaxLeadersInfluence : kMaxSharedInfluence;
  hearing.share = owner ? 1.0 : std::min(hearing.claimed, most);
  if (hearing.share > 0.0 && !owner) {
    hearing.share = share_beside(shared, newest, i, hearing, prediction.rotation.norm(), listening);
  }
  if (!(hearing.share > 0.0)) return;
  const bool teleports = owner && update.flags.teleported && update.stamp > shared.landed;
  const bool newcomer = !owner && !shared.joined && listening.own_confidence < 1.0 &&
                        hearing.claimed > listening.own_announced;
  if (listening.carried || teleports || newcomer) prediction = remote_.carry(shared, from, update);
  const pbd::BodyState there = moved(data_.world.states()[shared.def.body.index], prediction);
  remote_.observe(shared, from, update, prediction);
  if (teleports || newcomer) {
    follow(shared, update, there, prediction, teleports);
  } else if (!owner) {
    if (hearing.leads || (listening.hands && update.flags.owner_driven)) {
      out.leaders.push_back(from);
    }
    if (hearing.claimed > 0.0 || hearing.leads) {
      out.claims.push_back(
          {.peer = from, .way = prediction.translation, .turn = prediction.rotation});
    }
  }
  if (out.by_hand && owner && replays) {
    out.prescribed.push_back({.stamp = update.stamp, .state = {update.pose, update.twist}});
  }
  out.states.push_back(
      {.peer = from, .pose = there.pose, .twist = there.twist, .share = hearing.share});
  out.stamped.push_back(stamped);
  if (hearing.share > heaviest_) out.motion = prediction.motion;
  heaviest_ = std::max(heaviest_, hearing.share);
}

void Estimator::follow(SharedBody& shared, const StateUpdate& update, const pbd::BodyState& there,
                       const Prediction& prediction, bool teleports) {
  placement_.place(shared, there);
  if (teleports) {
    shared.landed = update.stamp;
    return;
  }
  // A newcomer takes over the first state it hears as it is. If it were pulled there instead, its
  // copies would get caught on obstacles and pull at the others' copies.
  shared.joined = true;
  if (prediction.translation.squaredNorm() > kFarAway * kFarAway) {
    shared.jumped = SharedBody::kJumpTold;
  }
}

double Estimator::share_beside(const SharedBody& shared, std::span<const Inbox::Received> newest,
                               std::size_t i, const Hearing& hearing, double angle,
                               const Listening& listening) {
  const bool leads = hearing.leads;
  const double mine =
      listening.carried ? listening.own_confidence : weight_of_share(listening.own_announced);
  double weight = (1.0 - listening.own_lead) * weight_of_share(hearing.share) / mine;
  if (data_.options.arbitration && listening.own_confidence >= 1.0) {  // a newcomer leads nobody
    // Compared at the stamp: a fast spin turns far within the age of an update.
    bool follows = leads || newest[i].peer < data_.self();
    if (listening.several && !leads) {
      if (angle > PoseArbiter::kFromAngle) follows = trust_.outvoted_at_stamp(shared, newest, i);
      if (!follows && angle > PoseArbiter::kToAngle) ++data_.report_of(newest[i].peer).outliers;
    }
    weight = PoseArbiter::weight(weight, angle, follows && listening.own_lead == 0.0);
  }
  if (weight < kNegligible) return 0.0;
  if (!listening.carried) return std::min(share_of_weight(weight), kMaxOfMean);
  // It leads, and does not own the body.
  const double guessed =
      std::min(share_of_weight(weight), leads ? kMaxLeadersInfluence : kMaxSharedInfluence);
  if (!data_.options.influence.limits_guesses) return guessed;
  return std::min(guessed,
                  std::max(leads ? following_share(hearing.age) : 0.0, stable_share(hearing.age)));
}

void Estimator::keep_leaders(Estimates& out) {
  // Other peers only know an earlier state, and a liar is one of the others.
  out.keep([&](const PeerEstimate& estimate) {
    return estimate.share >= 1.0 || ranges::find(out.leaders, estimate.peer) != out.leaders.end();
  });
}

void Estimator::estimate_owner(SharedBody& shared, std::span<const Inbox::Received> newest,
                               Estimates& out) {
  const PeerId owner = shared.tenure.owner;
  if (owner == 0 || owner == data_.self()) return;
  const pbd::BodyState& own = data_.world.state(shared.def.body);
  for (const Inbox::Received& received : newest) {
    const StateUpdate& update = remote_.as_meant(received, shared);
    // Until the new owner has the grant the body has no owner, and moves freely here.
    if (received.peer != owner || update.influence < 1.0F) continue;
    const Prediction prediction = remote_.carry(shared, owner, update);
    const pbd::BodyState there = moved(own, prediction);
    out.states.push_back({.peer = owner, .pose = there.pose, .twist = there.twist, .share = 1.0});
    remote_.observe(shared, owner, update, prediction);
    return;
  }
}

bool Estimator::hard_at_sender(const StateUpdate& update) const {
  return data_.options.mode == InputMode::Hard && update.flags.owner_driven &&
         update.influence >= 1.0F;
}

}  // namespace tandem::consensus
