// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <algorithm>
#include <cmath>
#include <cstddef>

#include "cpu_clock.h"
#include "peer_impl.h"
#include "predictors.h"
#include "tandem/pbd/math.h"

namespace tandem::consensus {
namespace {

/// A peer that does not own a body is heard with no more than this, whatever it claims.
constexpr double kMaxSharedInfluence = 0.5;
/// The same of one that leads: nobody else acts on the body.
constexpr double kMaxLeadersInfluence = 0.8;

/// Of a mean at a stamp: who does not own a body does not have all of it.
constexpr double kMostOfMean = 0.9999;

/// Of a guess: a leader is followed with at least this share, as it listens to nobody.
constexpr double kFollowing = 0.25;

/// m: at this lever rotations and spins count as ways and speeds.
constexpr double kLeverArm = 0.1;

/// m: what moves so much further in a step than its velocity says was put there.
constexpr double kJump = 0.1;

/// Of what agreement asks for in a step: a body that does less is in something's way, and one that
/// does it is on its way, or between neighbours that it cannot both follow.
constexpr double kBlocked = 0.5;

/// rad: closer orientations are an average's business, and further apart nothing is left of a
/// weight, see Lead.
constexpr double kNoDoubt = 0.5;
constexpr double kNoMean = 1.2;

/// s: nobody steps so slowly.
constexpr double kLongestStep = 0.5;

}  // namespace

Peer::Impl::Impl(pbd::World& world, Transport& transport, const PeerOptions& options)
    : options_(options),
      announcement_(options.announcement.empty() ? default_announcement(options.influence)
                                                 : options.announcement),
      hearing_(options.hearing.empty() ? default_hearing(options.influence) : options.hearing),
      world_(world),
      transport_(transport),
      springs_(world, options_),
      history_(to_ns(options.influence.max_age)),
      inbox_({.max_age = options.influence.max_age,
              .max_future = options.max_future,
              .plausibility = options.plausibility}),
      predictor_(options.own_predictor != nullptr
                     ? detail::make_guarded(options.own_predictor)
                     : make_predictor(options.predictor, options.prediction)),
      keeps_heard_(predictor_->remembers() || !options.acceptance.empty()) {
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
  step_dt_ = last_before_ > 0 ? kNs * static_cast<double>(now - last_before_) : 1.0 / 60.0;
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
  tell_observer(now);
  if (!in_pass()) apply_coupling();
}

void Peer::Impl::after_step(SessionTime now) {
  now_ = now;
  if (started_ == 0) started_ = now;
  mark_joints();
  mark_acting();
  spread_acting();
  const double dt = kNs * static_cast<double>(now - last_before_);
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

void Peer::Impl::aggregate(SessionTime now) {
  const CpuTimer timer(stats_.aggregate_s);
  targets_.clear();
  targeted_.clear();
  wanted_.clear();
  apart_ = false;
  if (replay_ != nullptr) replay_->begin();
  const PeerId self = transport_.self();
  for (std::size_t i = 0; i < shared_.size(); ++i) {
    Shared& shared = shared_[i];
    const auto newest = inbox_.newest_at(i);
    shared.asked.setZero();
    if (!world_.contains(shared.def.body)) continue;
    const bool unheard = options_.coupling == Coupling::None && !shared.def.owner.has_value();
    if (unheard || shared.def.owner == self) {
      estimates_.clear();
      drag(shared, now);
      continue;
    }
    const Found found = estimate(shared, newest, now);
    if (drag(shared, now) || estimates_.empty()) continue;
    ++stats_.bodies_aggregated;
    want(shared, found, now);
  }
  if (replay_ != nullptr) {
    if (apart_) {
      replay_->update(stats_.replay);
    } else {
      replay_->drop();
    }
  }
  for (Wanted& wanted : wanted_) aim(wanted);
}

void Peer::Impl::want(Shared& shared, const Found& found, SessionTime now) {
  const std::uint32_t slot = shared.def.body.index;
  const pbd::BodyState& own = world_.states()[slot];
  if (found.votes) weigh_votes(own);
  Wanted wanted{.shared = &shared};
  pbd::PoseTarget& target = wanted.target;
  target.body = shared.def.body;
  target.motion = motion_;
  if (!fuse(own.pose, estimates_, target)) return;
  wanted.heaviest = std::max_element(estimates_.begin(), estimates_.end(), [](auto& a, auto& b) {
                      return a.weight < b.weight;
                    })->peer;
  if (found.by_hand || !replays()) {
    wanted_.push_back(wanted);
    return;
  }
  // How far what is said of its stamp may have moved since.
  double way = 0.0;
  bool apart = false;
  const auto speed = [](const pbd::Twist& twist) {
    return twist.linear.norm() + kLeverArm * twist.angular.norm();
  };
  for (const PeerEstimate& estimate : estimates_) {
    const Stamped& there = *std::ranges::find(stamped_, estimate.peer, &Stamped::peer);
    const double age = std::max(0.0, kNs * static_cast<double>(now - there.stamp));
    way = std::max(way, age * std::max(speed(own.twist), speed(there.state.twist)));
    apart = apart || there.apart;
  }
  target.share = target.share < 1.0 ? options_.replay.share : 1.0;
  if (way <= options_.replay.tolerance) {
    const SessionTime oldest = std::ranges::min_element(stamped_, {}, &Stamped::stamp)->stamp;
    // What somebody has put there since is not where it rested.
    if (!apart || history_.placed_since(slot, oldest)) return;
    target = at_rest(shared, target);
  } else {
    for (const PeerEstimate& estimate : estimates_) {
      const Stamped& there = *std::ranges::find(stamped_, estimate.peer, &Stamped::peer);
      if (there.stamp < history_.frame(history_.first()).time) continue;  // nobody knows any more
      replay_->add({.slot = slot,
                    .peer = there.peer,
                    .stamp = there.stamp,
                    .weight = weight_of_share(estimate.share),
                    .state = there.state});
    }
    wanted.replayed = true;
    apart_ = apart_ || apart;
  }
  wanted_.push_back(wanted);
}

pbd::PoseTarget Peer::Impl::at_rest(const Shared& shared, pbd::PoseTarget target) {
  const auto oldest = std::ranges::min_element(stamped_, {}, &Stamped::stamp);
  const pbd::BodyState then = history_.state_at(shared.def.body.index, oldest->stamp);
  for (PeerEstimate& estimate : estimates_) {
    const Stamped& there = *std::ranges::find(stamped_, estimate.peer, &Stamped::peer);
    estimate.pose = there.state.pose;
    estimate.twist = there.state.twist;
  }
  pbd::PoseTarget mean;
  fuse(then.pose, estimates_, mean);
  target.pose.position =
      then.pose.position + mean.share * (mean.pose.position - then.pose.position);
  target.pose.orientation = pbd::rotated(then.pose.orientation, mean.share * mean.rotation_error);
  target.use_rotation_error = false;
  target.twist.linear = then.twist.linear + mean.share * (mean.twist.linear - then.twist.linear);
  target.twist.angular =
      then.twist.angular + mean.share * (mean.twist.angular - then.twist.angular);
  return target;
}

void Peer::Impl::aim(Wanted& wanted) {
  Shared& shared = *wanted.shared;
  pbd::PoseTarget& target = wanted.target;
  const pbd::BodyState& own = world_.states()[shared.def.body.index];
  if (wanted.replayed) {
    const pbd::Correction* const gap = replay_->find(shared.def.body.index);
    if (gap == nullptr) return;
    target.pose = {own.pose.position + gap->translation,
                   pbd::rotated(own.pose.orientation, gap->rotation)};
    target.twist = {own.twist.linear + gap->twist.linear, own.twist.angular + gap->twist.angular};
    target.use_rotation_error = false;
    if (!shared.def.orientation) target.pose.orientation = own.pose.orientation;
  }
  limit(own, wanted);
  shared.asked =
      share_per_step(target.share, step_dt_) * (target.pose.position - own.pose.position);
  targets_.push_back(target);
  targeted_.push_back(&shared);
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

void Peer::Impl::place(Shared& shared, const pbd::Pose& pose, const pbd::Twist& twist) {
  world_.set_pose(shared.def.body, pose);
  world_.set_twist(shared.def.body, twist);
  history_.restart(shared.def.body.index, world_);
}

void Peer::Impl::tell_observer(SessionTime now) {
  for (const Noted& n : noted_) {
    observer_->on_prediction(n.from, n.body, now, n.position, n.age);
  }
  noted_.clear();
}

PredictionContext Peer::Impl::context_of(Shared& shared, PeerId from, SessionTime now) {
  return {.now = now,
          .gravity = world_.all_props()[shared.def.body.index].gravity_scale * world_.gravity(),
          .memory = keeps_heard_ ? &heard_from(shared, from, now).memory : nullptr};
}

Prediction Peer::Impl::carry(Shared& shared, PeerId from, const StateUpdate& update,
                             SessionTime now) {
  const OwnMotion own(history_, shared.def.body.index);
  Prediction prediction = predictor_->predict(update, own, context_of(shared, from, now));
  if (!update.oriented || !shared.def.orientation) prediction.rotation.setZero();
  return prediction;
}

Prediction Peer::Impl::compare(const Shared& shared, PeerId from, const StateUpdate& update) {
  const pbd::BodyState then =
      history_.state_beside(shared.def.body.index, update.stamp, update.twist);
  Prediction gap{.translation = update.pose.position - then.pose.position,
                 .twist = {update.twist.linear - then.twist.linear,
                           update.twist.angular - then.twist.angular}};
  pbd::Pose pose = update.pose;
  if (update.oriented && shared.def.orientation) {
    gap.rotation = pbd::rotation_between(then.pose.orientation, update.pose.orientation);
  } else {
    pose.orientation = then.pose.orientation;
  }
  const double way = gap.translation.norm() + kLeverArm * gap.rotation.norm();
  const double drift = gap.twist.linear.norm() + kLeverArm * gap.twist.angular.norm();
  const double age = kNs * static_cast<double>(now_ - update.stamp);
  const bool apart = way + age * drift > options_.replay.tolerance;
  stamped_.push_back({from, update.stamp, {pose, update.twist}, apart});
  return gap;
}

void Peer::Impl::observe(Shared& shared, PeerId from, const StateUpdate& update,
                         const Prediction& prediction, SessionTime now) {
  if (observer_ == nullptr) return;
  const OwnMotion own(history_, shared.def.body.index);
  noted_.push_back({from, shared.def.id,
                    world_.state(shared.def.body).pose.position + prediction.translation,
                    kNs * static_cast<double>(now - update.stamp)});
  observer_->on_estimate({from, update, own, context_of(shared, from, now), prediction});
}

Peer::Impl::Found Peer::Impl::estimate(Shared& shared, std::span<const Inbox::Received> newest,
                                       SessionTime now) {
  estimates_.clear();
  stamped_.clear();
  motion_ = pbd::TargetMotion::WithBody;
  Found found;
  if (newest.empty()) return found;
  if (ownership_ != nullptr && !shared.def.owner.has_value()) {
    estimate_owner(shared, newest, now);
    return found;
  }
  // Two peers know no majority, and pay for none.
  const bool several =
      options_.robust.outvote && newest.size() >= 2 && !shared.def.owner.has_value();
  const bool hands = believes_hands(newest.size());
  leaders_.clear();
  claims_.clear();
  const pbd::BodyState& own = world_.states()[shared.def.body.index];
  const PeerId self = transport_.self();
  const double own_announced = std::min(announced(shared), kMaxSharedInfluence);
  const double own_confidence = confidence();
  const double own_lead = shared.initiative.strength();
  // What a spring that only its own peer knows does to the body cannot be replayed.
  const bool hidden =
      springs_.holds_alone(shared.def.body) || std::ranges::any_of(newest, [&](const auto& r) {
        return r.update.flags.owner_driven &&
               (shared.def.owner.has_value() ? shared.def.owner == r.peer : hands);
      });
  double heaviest = 0.0;
  InfluenceContext known{.leads = own_lead};
  for (std::size_t i = 0; i < newest.size(); ++i) {
    const Inbox::Received& received = newest[i];
    const StateUpdate& update = as_meant(received, shared);
    const bool owner = shared.def.owner == received.peer ||
                       (!shared.def.owner.has_value() && hard_at_sender(update));
    if (shared.def.owner.has_value() && !owner) continue;
    const bool carried = hidden || !replays();
    known.age = kNs * static_cast<double>(now - update.stamp);
    const bool leads = update.flags.leads && own_lead == 0.0 &&
                       (!several || believes_lead(shared, received.peer, now));
    const double claimed = static_cast<double>(update.influence);
    const double most = leads ? kMaxLeadersInfluence : kMaxSharedInfluence;
    double share = hearing_.apply(owner ? 1.0 : std::min(claimed, most), known);
    if (!(share > 0.0)) continue;
    Prediction prediction = compare(shared, received.peer, update);
    if (!owner) {
      // At the stamp the own state is as old, and decays as much.
      const double mine =
          carried ? own_confidence : weight_of_share(hearing_.apply(own_announced, known));
      double weight = (1.0 - own_lead) * weight_of_share(share) / mine;
      if (options_.arbitration && own_confidence >= 1.0) {  // a newcomer leads nobody
        // Compared at the stamp: what spins fast turns far within the age of an update.
        const double angle = prediction.rotation.norm();
        bool follows = leads || received.peer < self;
        if (several && !leads && angle > kNoDoubt) follows = outvoted_at_stamp(shared, newest, i);
        if (several && !follows && angle > kNoMean) ++report_of(received.peer).outliers;
        weight = Lead::weight(weight, angle, follows && own_lead == 0.0);
      }
      // It leads, and does not own.
      share = std::min(share_of_weight(weight), carried ? most : kMostOfMean);
      if (carried && options_.hearing.empty()) {
        share = std::min(share, std::max(leads ? kFollowing : 0.0, stable_share(known.age)));
      }
    }
    if (!(share > 0.0)) {
      stamped_.pop_back();
      continue;
    }
    const bool teleports = owner && update.flags.teleported && update.stamp > shared.landed;
    const bool newcomer =
        !owner && !shared.joined && own_confidence < 1.0 && claimed > own_announced;
    if (carried || teleports || newcomer) prediction = carry(shared, received.peer, update, now);
    if (!options_.acceptance.empty() && !owner) {
      share = accepted(share, prediction, heard_from(shared, received.peer, now), now);
      if (!(share > 0.0)) continue;
    }
    const pbd::Pose pose{own.pose.position + prediction.translation,
                         pbd::rotated(own.pose.orientation, prediction.rotation)};
    const pbd::Twist twist{own.twist.linear + prediction.twist.linear,
                           own.twist.angular + prediction.twist.angular};
    observe(shared, received.peer, update, prediction, now);
    if (teleports) {
      shared.landed = update.stamp;
      place(shared, pose, twist);
    } else if (newcomer) {
      // A newcomer takes over what it hears as it is. Drawn there, its copies would get caught on
      // what lies in between, and would pull at the others' once they listen.
      shared.joined = true;
      place(shared, pose, twist);
      if (prediction.translation.squaredNorm() > kJump * kJump) shared.jumped = kJumpTold;
    } else if (several) {
      if (leads || (hands && update.flags.owner_driven)) leaders_.push_back(received.peer);
      if (claimed > 0.0 || leads) {
        claims_.push_back(
            {.peer = received.peer, .way = prediction.translation, .turn = prediction.rotation});
      }
    } else if (!owner && (leads || (received.peer < self && own_lead == 0.0))) {
      const bool held = shared.held || update.flags.held;
      if (options_.arbitration && !held &&
          shared.lead.parted(prediction.translation, prediction.rotation, shared.blocked, now)) {
        place_apart(shared, pose, twist, received.peer, now);
      }
    }
    found.by_hand = hidden;
    if (hidden && owner && replays()) {
      replay_->prescribe({.slot = shared.def.body.index,
                          .from = pbd::BodyState{update.pose, update.twist},
                          .stamp = update.stamp});
    }
    estimates_.push_back({.peer = received.peer, .pose = pose, .twist = twist, .share = share});
    if (share > heaviest) motion_ = prediction.motion;
    heaviest = std::max(heaviest, share);
  }
  if (!several) return found;
  if (own_lead == 0.0 && options_.arbitration) give_way(shared, newest, now);
  found.votes = leaders_.empty();
  if (found.votes) return found;
  // The others only know an earlier state of it, and whoever lies is one of them.
  std::erase_if(estimates_, [this](const PeerEstimate& estimate) {
    return estimate.share < 1.0 &&
           std::find(leaders_.begin(), leaders_.end(), estimate.peer) == leaders_.end();
  });
  return found;
}

double Peer::Impl::accepted(double share, const Prediction& prediction, const Heard& heard,
                            SessionTime now) const {
  if (options_.acceptance.empty()) return share;
  return options_.acceptance.apply(share,
                                   {.confidence = confidence(),
                                    .heard_for = kNs * static_cast<double>(now - heard.first),
                                    .variance = prediction.variance,
                                    .distance = prediction.translation.norm(),
                                    .angle = prediction.rotation.norm(),
                                    .speed = prediction.twist.linear.norm(),
                                    .angular_speed = prediction.twist.angular.norm()});
}

Peer::Impl::Heard& Peer::Impl::heard_from(Shared& shared, PeerId peer, SessionTime now) {
  auto it = std::lower_bound(shared.heard.begin(), shared.heard.end(), peer,
                             [](const Heard& h, PeerId id) { return h.peer < id; });
  if (it == shared.heard.end() || it->peer != peer) {
    it = shared.heard.insert(it, {.peer = peer, .first = now, .last = now, .memory = {}});
  } else if (kNs * static_cast<double>(now - it->last) > options_.influence.max_age) {
    *it = {.peer = peer, .first = now, .last = now, .memory = {}};  // away, or started again
  }
  it->last = now;
  return *it;
}

double Peer::Impl::announced(const Shared& shared) {
  if (ownership_ != nullptr && !shared.def.owner.has_value()) {
    return ownership_->mine(index_of(shared)) ? 1.0 : 0.0;
  }
  return announcement_.apply(0.0, {.owned = shared.def.owner.has_value(),
                                   .sender_owns = shared.def.owner == transport_.self(),
                                   .held_alone = springs_.holds_alone(shared.def.body),
                                   .leads = shared.initiative.strength(),
                                   .confidence = confidence()});
}

double Peer::Impl::confidence() const {
  if (options_.authority_ramp <= 0.0) return 1.0;
  const double since = started_ == 0 ? 0.0 : kNs * static_cast<double>(now_ - started_);
  return std::clamp(since / options_.authority_ramp, 0.0, 1.0);
}

}  // namespace tandem::consensus
