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

/// What a sender gives my states, relative to what I give its: no honest peer's policy comes near.
constexpr double kMostMirrored = 100.0;

/// m: what moves so much further in a step than its velocity says was put there.
constexpr double kJump = 0.1;

/// Of what agreement asks for in a step: a body that does less is in something's way, and one that
/// does it is on its way, or between neighbours that it cannot both follow.
constexpr double kBlocked = 0.5;

/// Cosine of half of 0.5 rad: closer orientations are an average's business, see Lead.
constexpr double kNoDoubt = 0.9689124217106447;
/// rad: further apart nothing is left of a share, see Lead.
constexpr double kNoMean = 1.2;

/// s: nobody steps so slowly.
constexpr double kLongestStep = 0.5;

}  // namespace

Peer::Impl::Impl(pbd::World& world, Transport& transport, const PeerOptions& options)
    : options_(options),
      announcement_(options.announcement.empty() ? default_announcement(options.influence)
                                                 : options.announcement),
      hearing_(options.hearing.empty() ? default_hearing(options.influence) : options.hearing),
      mirrored_(hearing_),
      world_(world),
      transport_(transport),
      springs_(world, options_),
      inbox_({.max_age = options.influence.max_age,
              .max_future = options.max_future,
              .plausibility = options.plausibility}),
      predictor_(options.own_predictor != nullptr
                     ? detail::make_guarded(options.own_predictor)
                     : make_predictor(options.predictor, options.prediction)),
      keeps_heard_(predictor_->remembers() || !options.acceptance.empty()) {
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
  if (now < last_before_ || step_dt_ > kLongestStep) {
    // The clock was set, or nothing was stepped for long: what is remembered is of other times.
    for (Shared& shared : shared_) shared.history.clear();
  }
  last_before_ = now;
  now_ = now;
  if (without_memory_ > 0) lay_out_histories();
  for (Shared& shared : shared_) {
    // An instance that nothing has moved yet is known from now on.
    if (shared.history.empty()) remember(shared, now, {});
  }
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
  if (without_memory_ > 0) lay_out_histories();
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
    remember(shared, now, correction);
    shared.averaged = {};
    update_initiative(shared, inbox_.newest_at(i), now);
  }
  if (now >= next_send_) {
    const auto interval = static_cast<SessionTime>(1.0 / (kNs * options_.update_hz));
    next_send_ = std::max(next_send_ + interval, now - interval);
    send(now);
  }
}

void Peer::Impl::collect(std::vector<pbd::PoseTarget>& out) const {
  if (in_pass()) out.insert(out.end(), targets_.begin(), targets_.end());
}

void Peer::Impl::aggregate(SessionTime now) {
  const CpuTimer timer(stats_.aggregate_s);
  targets_.clear();
  targeted_.clear();
  const PeerId self = transport_.self();
  for (std::size_t i = 0; i < shared_.size(); ++i) {
    Shared& shared = shared_[i];
    const auto newest = inbox_.newest_at(i);
    shared.asked.setZero();
    prefetch(i, age_);  // about the same for all bodies
    if (!world_.contains(shared.def.body)) continue;
    const bool unheard = options_.coupling == Coupling::None && !shared.def.owner.has_value();
    if (unheard || shared.def.owner == self) {
      estimates_.clear();
      drag(shared, now);
      continue;
    }
    const bool votes = estimate(shared, newest, now);
    if (drag(shared, now) || estimates_.empty()) continue;
    ++stats_.bodies_aggregated;
    pbd::PoseTarget& target = targets_.emplace_back();
    target.body = shared.def.body;
    target.motion = motion_;
    targeted_.push_back(&shared);
    const pbd::BodyState& own = world_.states()[shared.def.body.index];
    if (!(votes ? fuse_votes(own, target) : fuse(own.pose, estimates_, target))) {
      targets_.pop_back();
      targeted_.pop_back();
      continue;
    }
    limit(own, target, shared.joined);
    shared.asked =
        share_per_step(target.share, step_dt_) * (target.pose.position - own.pose.position);
  }
}

bool Peer::Impl::jumps(const Shared& shared, const pbd::Correction& correction, double dt) const {
  const pbd::BodyState& state = world_.state(shared.def.body);
  const MotionSample& last = shared.history.newest();
  const double reach =
      2.0 * dt * std::max(state.twist.linear.norm(), last.twist.linear.norm()) + kJump;
  const pbd::Vec3 way = state.pose.position - last.pose.position - correction.translation;
  return way.squaredNorm() > reach * reach;
}

void Peer::Impl::place(Shared& shared, const pbd::Pose& pose, const pbd::Twist& twist,
                       SessionTime now) {
  world_.set_pose(shared.def.body, pose);
  world_.set_twist(shared.def.body, twist);
  shared.history.clear();
  remember(shared, now, {});
}

void Peer::Impl::tell_observer(SessionTime now) {
  for (const Noted& n : noted_) {
    observer_->on_prediction(n.from, n.body, now, n.position, n.age);
  }
  noted_.clear();
}

bool Peer::Impl::estimate(Shared& shared, std::span<const Inbox::Received> newest,
                          SessionTime now) {
  estimates_.clear();
  if (newest.empty()) return false;
  if (ownership_ != nullptr && !shared.def.owner.has_value()) {
    estimate_owner(shared, newest, now);
    return false;
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
  double heaviest = 0.0;
  InfluenceContext known{.leads = own_lead, .gain = predictor_->gain()};
  for (std::size_t i = 0; i < newest.size(); ++i) {
    const Inbox::Received& received = newest[i];
    const StateUpdate& update = as_meant(received, shared);
    const bool owner = shared.def.owner == received.peer ||
                       (!shared.def.owner.has_value() && hard_at_sender(update));
    if (shared.def.owner.has_value() && !owner) continue;
    known.age = kNs * static_cast<double>(now - update.stamp);
    known.gain = predictor_->gain_for(update);
    known.sender_leads = update.flags.leads && own_lead == 0.0 &&
                         (!several || believes_lead(shared, received.peer, now));
    const double claimed = static_cast<double>(update.influence);
    const double most = known.sender_leads ? kMaxLeadersInfluence : kMaxSharedInfluence;
    const double heard = owner ? 1.0 : std::min(claimed, most);
    double share = hearing_.apply(heard, known);
    if (!owner) {
      if (options_.arbitration && own_confidence >= 1.0) {  // a newcomer leads nobody
        // Compared at the stamp: what spins fast turns far within the age of an update.
        double angle = 0.0;
        const MotionHistory::Moment stamp = shared.history.moment(update.stamp);
        age_ = stamp.age;
        if (!shared.history.within(stamp, update.pose.orientation, kNoDoubt)) {
          const pbd::Quat then = shared.history.at_time(stamp).pose.orientation;
          angle = pbd::rotation_between(then, update.pose.orientation).norm();
        }
        bool follows = known.sender_leads || received.peer < self;
        if (several && !known.sender_leads && angle > 0.0) {
          follows = outvoted_at_stamp(shared, newest, i);
        }
        if (several && !follows && angle > kNoMean) ++report_of(received.peer).outliers;
        share = shared.lead.share(share, angle, follows && own_lead == 0.0, now);
        share = std::min(share, most);  // it leads, and does not own
      }
      share = against_own(share, own_confidence);
    }
    if (!(share > 0.0)) continue;
    Heard* memory = keeps_heard_ ? &heard_from(shared, received.peer, now) : nullptr;
    // What the sender gives to my states by the same rules.
    // An owner listens to nobody.
    const double mirrored =
        owner ? 0.0
              : mirrored_.apply(own_announced, {.leads = update.flags.leads ? 1.0 : 0.0,
                                                .sender_leads = own_lead >= 1.0,
                                                .age = known.age,
                                                .gain = known.gain});
    const PredictionContext context{
        .now = now,
        .mirrored_share = std::min(mirrored / share, kMostMirrored),
        .peers = static_cast<int>(newest.size()),
        .gravity = world_.all_props()[shared.def.body.index].gravity_scale * world_.gravity(),
        .held = shared.held,
        .hangs = shared.hangs,
        .memory = memory != nullptr ? &memory->memory : nullptr};
    Prediction prediction = predictor_->predict(update, shared.history, context);
    if (!update.oriented || !shared.def.orientation) prediction.rotation.setZero();
    if (memory != nullptr && !owner) {
      share = accepted(share, prediction, *memory, now);
      if (!(share > 0.0)) continue;
    }
    const pbd::Vec3 position = own.pose.position + prediction.translation;
    const pbd::Pose pose{position, pbd::rotated(own.pose.orientation, prediction.rotation)};
    const pbd::Twist twist{own.twist.linear + prediction.twist.linear,
                           own.twist.angular + prediction.twist.angular};
    if (owner) {
      if (update.flags.teleported && update.stamp > shared.landed) {
        shared.landed = update.stamp;
        place(shared, pose, twist, now);
      }
    } else if (!shared.joined && own_confidence < 1.0 && claimed > own_announced) {
      // A newcomer takes over what it hears as it is. Drawn there, its copies would get caught on
      // what lies in between, and would pull at the others' once they listen.
      shared.joined = true;
      place(shared, pose, twist, now);
      if (prediction.translation.squaredNorm() > kJump * kJump) shared.jumped = kJumpTold;
    } else if (several) {
      if (known.sender_leads || (hands && update.flags.owner_driven)) {
        leaders_.push_back(received.peer);
      }
      if (claimed > 0.0 || known.sender_leads) {
        claims_.push_back(
            {.peer = received.peer, .way = prediction.translation, .turn = prediction.rotation});
      }
    } else if (known.sender_leads || (received.peer < self && own_lead == 0.0)) {
      const bool held = shared.held || update.flags.held;
      if (options_.arbitration && !held &&
          shared.lead.parted(prediction.translation, prediction.rotation, shared.blocked, now)) {
        place_apart(shared, pose, twist, received.peer, now);
      }
    }
    estimates_.push_back({.peer = received.peer, .pose = pose, .twist = twist, .share = share});
    if (share > heaviest) motion_ = prediction.motion;
    heaviest = std::max(heaviest, share);
    if (observer_ != nullptr) {
      noted_.push_back({received.peer, shared.def.id, position, known.age});
      observer_->on_estimate({received.peer, update, shared.history, context, prediction});
    }
  }
  if (!several) return false;
  if (own_lead == 0.0 && options_.arbitration) give_way(shared, newest, now);
  if (leaders_.empty()) return true;
  // The others only know an earlier state of it, and whoever lies is one of them.
  std::erase_if(estimates_, [this](const PeerEstimate& estimate) {
    return estimate.share < 1.0 &&
           std::find(leaders_.begin(), leaders_.end(), estimate.peer) == leaders_.end();
  });
  return false;
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

double Peer::Impl::against_own(double share, double confidence) {
  const double weight = weight_of_share(share);
  return weight > 0.0 ? share_of_weight(weight / confidence) : 0.0;
}

}  // namespace tandem::consensus
