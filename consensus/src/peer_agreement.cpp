// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "cpu_clock.h"
#include "peer_impl.h"
#include "tandem/pbd/math.h"

namespace tandem::consensus {
namespace {

/// A peer that does not own a body is heard with no more than this, whatever it claims.
constexpr double kMaxSharedInfluence = 0.5;
/// The same of one that leads: nobody else acts on the body.
constexpr double kMaxLeadersInfluence = 0.8;

/// Of a mean at a stamp: who does not own a body does not have all of it.
constexpr double kMostOfMean = 0.9999;

/// A leader is followed with at least this share: it listens to nobody, so nothing comes back. What
/// one holds is 1.09 and 1.25 of the physical limit apart at profile 3 (p95 of cubes and room), and
/// 1.46 and 1.61 with the share that all others have.
constexpr double kFollowing = 0.5;

/// rad: closer orientations are an average's business, and further apart nothing is left of a
/// weight, see Lead.
constexpr double kNoDoubt = 0.5;
constexpr double kNoMean = 1.2;

/// Lengths as well: they are what a rotation and a distance are made from.
bool finite(const Prediction& p) {
  return std::isfinite(p.translation.squaredNorm()) && std::isfinite(p.rotation.squaredNorm()) &&
         std::isfinite(p.twist.linear.squaredNorm()) &&
         std::isfinite(p.twist.angular.squaredNorm());
}

}  // namespace

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
    const pbd::Vec3 asked = std::exchange(shared.asked, pbd::Vec3::Zero());
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
    want(shared, found, asked, now);
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

void Peer::Impl::want(Shared& shared, const Found& found, const pbd::Vec3& asked, SessionTime now) {
  const std::uint32_t slot = shared.def.body.index;
  const pbd::BodyState& own = world_.states()[slot];
  if (found.votes) weigh_votes(own);
  Wanted wanted{.shared = &shared, .asked = asked};
  pbd::PoseTarget& target = wanted.target;
  target.body = shared.def.body;
  target.motion = motion_;
  if (!fuse(own.pose, estimates_, target)) return;
  wanted.heaviest = std::ranges::max_element(estimates_, {}, &PeerEstimate::weight)->peer;
  if (found.by_hand || !replays()) {
    wanted_.push_back(wanted);
    return;
  }
  // How far what is said of its stamp may have moved since.
  double way = 0.0;
  bool apart = false;
  SessionTime oldest = now;
  for (const Stamped& there : stamped_) {
    const double age = std::max(0.0, seconds(now - there.stamp));
    way = std::max(way, age * std::max(speed(own.twist), speed(there.state.twist)));
    apart = apart || there.apart;
    oldest = std::min(oldest, there.stamp);
  }
  if (target.share < 1.0) {
    target.share = leaders_.empty() ? options_.replay.share
                                    : std::max(options_.replay.share, kFollowing);
  }
  if (way <= options_.replay.tolerance) {
    // What somebody has put there since is not where it rested.
    if (!apart || history_.placed_since(slot, oldest)) return;
    stay(history_.state_at(slot, oldest), target);
  } else {
    for (std::size_t i = 0; i < stamped_.size(); ++i) {
      const Stamped& there = stamped_[i];
      if (there.stamp < history_.frame(history_.first()).time) continue;  // nobody knows any more
      replay_->add({.slot = slot,
                    .peer = estimates_[i].peer,
                    .stamp = there.stamp,
                    .weight = weight_of_share(estimates_[i].share),
                    .state = there.state});
    }
    wanted.replayed = true;
    wanted.oldest = oldest;
    apart_ = apart_ || apart;
  }
  wanted_.push_back(wanted);
}

void Peer::Impl::stay(const pbd::BodyState& then, pbd::PoseTarget& target) {
  for (std::size_t i = 0; i < stamped_.size(); ++i) {
    estimates_[i].pose = stamped_[i].state.pose;
    estimates_[i].twist = stamped_[i].state.twist;
  }
  pbd::PoseTarget fused;
  fuse(then.pose, estimates_, fused);
  const pbd::BodyState mean = mean_with(then, fused);
  target.pose = mean.pose;
  target.twist = mean.twist;
  target.use_rotation_error = false;
}

void Peer::Impl::ease_in(const pbd::BodyState& own, Wanted& wanted) const {
  pbd::PoseTarget& target = wanted.target;
  if (target.share >= 1.0) return;
  const pbd::Vec3 gap = target.pose.position - own.pose.position;
  const double distance = gap.norm();
  if (!(distance > 0.0)) return;
  const double age = std::max(step_dt_, seconds(now_ - wanted.oldest));
  const double faster = (target.twist.linear - own.twist.linear).norm();  // m/s
  const double growth = 2.0 * std::max(distance / age, faster) * step_dt_ / age;
  const double most = std::max(0.0, wanted.asked.dot(gap) / distance) + growth * step_dt_;
  const double full = share_per_step(target.share, step_dt_) * distance;
  if (full > most) target.share *= most / full;
}

void Peer::Impl::aim(Wanted& wanted) {
  Shared& shared = *wanted.shared;
  pbd::PoseTarget& target = wanted.target;
  const pbd::BodyState& own = world_.states()[shared.def.body.index];
  if (wanted.replayed) {
    const pbd::Correction* const missing = replay_->find(shared.def.body.index);
    if (missing == nullptr) return;
    const pbd::BodyState mean = moved(own, *missing);
    target.pose = mean.pose;
    target.twist = mean.twist;
    target.use_rotation_error = false;
    if (!shared.def.orientation) target.pose.orientation = own.pose.orientation;
  }
  limit(own, wanted);
  if (wanted.replayed) ease_in(own, wanted);
  shared.asked =
      share_per_step(target.share, step_dt_) * (target.pose.position - own.pose.position);
  targets_.push_back(target);
  targeted_.push_back(&shared);
}

PredictionContext Peer::Impl::context_of(Shared& shared, PeerId from, SessionTime now) {
  return {.now = now,
          .gravity = world_.all_props()[shared.def.body.index].gravity_scale * world_.gravity(),
          .memory = predictor_->remembers() ? &heard_from(shared, from, now).memory : nullptr};
}

Prediction Peer::Impl::carry(Shared& shared, PeerId from, const StateUpdate& update,
                             SessionTime now) {
  const OwnMotion own(history_, shared.def.body.index);
  const PredictionContext context = context_of(shared, from, now);
  Prediction prediction = predictor_->predict(update, own, context);
  // No number of an application's own gets into a world unseen.
  if (!finite(prediction)) prediction = as_stamped_->predict(update, own, context);
  if (!update.oriented || !shared.def.orientation) prediction.rotation.setZero();
  return prediction;
}

Peer::Impl::Stamped Peer::Impl::compare(const Shared& shared, const StateUpdate& update,
                                        Prediction& missing) {
  const pbd::BodyState then =
      history_.state_beside(shared.def.body.index, update.stamp, update.twist);
  Stamped there{update.stamp, {update.pose, update.twist}};
  if (!update.oriented || !shared.def.orientation) {
    there.state.pose.orientation = then.pose.orientation;
  }
  const pbd::Correction apart = gap(then, there.state);
  missing = {.translation = apart.translation, .rotation = apart.rotation, .twist = apart.twist};
  const double age = seconds(now_ - update.stamp);
  const double way = apart.translation.norm() + kLeverArm * apart.rotation.norm();
  there.apart = way + age * speed(apart.twist) > options_.replay.tolerance;
  return there;
}

void Peer::Impl::observe(Shared& shared, PeerId from, const StateUpdate& update,
                         const Prediction& prediction, SessionTime now) {
  if (observer_ == nullptr) return;
  const OwnMotion own(history_, shared.def.body.index);
  observer_->on_estimate({from, update, own, context_of(shared, from, now), prediction,
                          world_.pose(shared.def.body).position + prediction.translation,
                          seconds(now - update.stamp)});
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
  leaders_.clear();
  claims_.clear();
  const bool hands = believes_hands(newest.size());
  // What a spring that only its own peer knows does to the body cannot be replayed.
  found.by_hand =
      springs_.holds_alone(shared.def.body) || std::ranges::any_of(newest, [&](const auto& r) {
        return r.update.flags.owner_driven &&
               (shared.def.owner.has_value() ? shared.def.owner == r.peer : hands);
      });
  const Listening listening{
      // Two peers know no majority, and pay for none.
      .several = options_.robust.outvote && newest.size() >= 2 && !shared.def.owner.has_value(),
      .carried = found.by_hand || !replays(),
      .own_lead = shared.initiative.strength(),
      .own_announced = std::min(announced(shared), kMaxSharedInfluence),
      .own_confidence = confidence()};
  const pbd::BodyState& own = world_.states()[shared.def.body.index];
  double heaviest = 0.0;
  for (std::size_t i = 0; i < newest.size(); ++i) {
    const PeerId from = newest[i].peer;
    const StateUpdate& update = as_meant(newest[i], shared);
    const bool owner =
        shared.def.owner == from || (!shared.def.owner.has_value() && hard_at_sender(update));
    if (shared.def.owner.has_value() && !owner) continue;
    const bool leads = update.flags.leads && listening.own_lead == 0.0 &&
                       (!listening.several || believes_lead(shared, from, now));
    const double claimed = static_cast<double>(update.influence);
    Prediction prediction;
    const Stamped stamped = compare(shared, update, prediction);
    const double age = seconds(now - update.stamp);
    const double most = leads ? kMaxLeadersInfluence : kMaxSharedInfluence;
    double share = effective_share(options_.influence, owner ? 1.0 : std::min(claimed, most), age);
    if (share > 0.0 && !owner) {
      share =
          share_beside(shared, newest, i, share, leads, prediction.rotation.norm(), age, listening);
    }
    if (!(share > 0.0)) continue;
    const bool teleports = owner && update.flags.teleported && update.stamp > shared.landed;
    const bool newcomer = !owner && !shared.joined && listening.own_confidence < 1.0 &&
                          claimed > listening.own_announced;
    if (listening.carried || teleports || newcomer) prediction = carry(shared, from, update, now);
    const pbd::BodyState there = moved(own, prediction);
    observe(shared, from, update, prediction, now);
    if (teleports) {
      shared.landed = update.stamp;
      place(shared, there);
    } else if (newcomer) {
      // A newcomer takes over what it hears as it is. Drawn there, its copies would get caught on
      // what lies in between, and would pull at the others' once they listen.
      shared.joined = true;
      place(shared, there);
      if (prediction.translation.squaredNorm() > kJump * kJump) shared.jumped = kJumpTold;
    } else if (!owner) {
      if (leads || (hands && update.flags.owner_driven)) leaders_.push_back(from);
      if (claimed > 0.0 || leads) {
        claims_.push_back(
            {.peer = from, .way = prediction.translation, .turn = prediction.rotation});
      }
    }
    if (found.by_hand && owner && replays()) {
      replay_->prescribe({.slot = shared.def.body.index,
                          .from = pbd::BodyState{update.pose, update.twist},
                          .stamp = update.stamp});
    }
    estimates_.push_back({.peer = from, .pose = there.pose, .twist = there.twist, .share = share});
    stamped_.push_back(stamped);
    if (share > heaviest) motion_ = prediction.motion;
    heaviest = std::max(heaviest, share);
  }
  if (listening.own_lead == 0.0 && options_.arbitration)
    give_way(shared, newest, listening.several, now);
  if (!listening.several) return found;
  found.votes = leaders_.empty();
  if (!found.votes) keep_leaders();
  return found;
}

double Peer::Impl::share_beside(const Shared& shared, std::span<const Inbox::Received> newest,
                                std::size_t i, double share, bool leads, double angle, double age,
                                const Listening& listening) {
  // At the stamp the own state is as old, and decays as much.
  const double mine =
      listening.carried
          ? listening.own_confidence
          : weight_of_share(effective_share(options_.influence, listening.own_announced, age));
  double weight = (1.0 - listening.own_lead) * weight_of_share(share) / mine;
  if (options_.arbitration && listening.own_confidence >= 1.0) {  // a newcomer leads nobody
    // Compared at the stamp: what spins fast turns far within the age of an update.
    bool follows = leads || newest[i].peer < transport_.self();
    if (listening.several && !leads) {
      if (angle > kNoDoubt) follows = outvoted_at_stamp(shared, newest, i);
      if (!follows && angle > kNoMean) ++report_of(newest[i].peer).outliers;
    }
    weight = Lead::weight(weight, angle, follows && listening.own_lead == 0.0);
  }
  if (!listening.carried) return std::min(share_of_weight(weight), kMostOfMean);
  // It leads, and does not own.
  const double guessed =
      std::min(share_of_weight(weight), leads ? kMaxLeadersInfluence : kMaxSharedInfluence);
  if (!options_.influence.limits_guesses) return guessed;
  return std::min(guessed, std::max(leads ? kFollowing : 0.0, stable_share(age)));
}

void Peer::Impl::keep_leaders() {
  // The others only know an earlier state of it, and whoever lies is one of them.
  std::size_t kept = 0;
  for (std::size_t i = 0; i < estimates_.size(); ++i) {
    const bool leads = std::ranges::find(leaders_, estimates_[i].peer) != leaders_.end();
    if (estimates_[i].share < 1.0 && !leads) continue;
    estimates_[kept] = estimates_[i];
    stamped_[kept++] = stamped_[i];
  }
  estimates_.resize(kept);
  stamped_.resize(kept);
}

Peer::Impl::Heard& Peer::Impl::heard_from(Shared& shared, PeerId peer, SessionTime now) {
  auto it = std::lower_bound(shared.heard.begin(), shared.heard.end(), peer,
                             [](const Heard& h, PeerId id) { return h.peer < id; });
  if (it == shared.heard.end() || it->peer != peer) {
    it = shared.heard.insert(it, {.peer = peer, .last = now, .memory = {}});
  } else if (seconds(now - it->last) > options_.influence.max_age) {
    *it = {.peer = peer, .last = now, .memory = {}};  // away, or started again
  }
  it->last = now;
  return *it;
}

double Peer::Impl::announced(const Shared& shared) const {
  if (ownership_ != nullptr && !shared.def.owner.has_value()) {
    return ownership_->mine(index_of(shared)) ? 1.0 : 0.0;
  }
  if (shared.def.owner.has_value()) return shared.def.owner == transport_.self() ? 1.0 : 0.0;
  return confidence() * announced_share(options_.influence, springs_.holds_alone(shared.def.body),
                                        shared.initiative.strength() >= 1.0);
}

double Peer::Impl::confidence() const {
  if (options_.authority_ramp <= 0.0) return 1.0;
  const double since = started_ == 0 ? 0.0 : seconds(now_ - started_);
  return std::clamp(since / options_.authority_ramp, 0.0, 1.0);
}

}  // namespace tandem::consensus
