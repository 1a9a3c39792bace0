// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "agree/agreement.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "common/body_state.h"
#include "common/stable_share.h"
#include "tandem/consensus/influence.h"
#include "tandem/pbd/cpu_timer.h"

namespace tandem::consensus {

void Agreement::aggregate() {
  const pbd::CpuTimer timer(data_.stats.aggregate_s);
  targets_.clear();
  targeted_.clear();
  wanted_.clear();
  apart_ = false;
  if (replay_ != nullptr) replay_->begin();
  if (replays()) {
    latecomers_.look();
  } else {
    latecomers_.forget();
  }
  const PeerId self = data_.self();
  for (std::size_t i = 0; i < data_.bodies.size(); ++i) {
    SharedBody& shared = data_.bodies[i];
    const pbd::Vec3 asked = std::exchange(shared.asked, pbd::Vec3::Zero());
    if (!data_.world.contains(shared.def.body)) continue;
    const bool unheard = shared.stands || (data_.options.coupling == Coupling::None &&
                                           !shared.def.owner.has_value());
    if (unheard || shared.def.owner == self) {
      found_.states.clear();
      hard_.drag(shared, found_.states);
      continue;
    }
    bool guessed = false;
    const auto in_time = latecomers_.in_time(shared, data_.inbox.newest_at(i), guessed);
    const auto newest = data_.acts.knowing(shared.def.body, data_.inbox, in_time);
    const bool replayed = replays() && !guessed;
    estimator_.estimate(shared, newest, replayed, found_);
    for (const Stamped& owners : found_.prescribed) {
      replay_->prescribe(
          {.slot = shared.def.body.index, .from = owners.state, .stamp = owners.stamp});
    }
    if (hard_.drag(shared, found_.states) || found_.states.empty()) continue;
    ++data_.stats.bodies_aggregated;
    want(shared, asked, replayed);
  }
  if (replay_ != nullptr) {
    if (apart_) {
      const PeerId slow = replay_->update(data_.stats.replay);
      if (slow != 0) ++data_.report_of(slow).without;
    } else {
      replay_->drop();
    }
  }
  for (Wanted& wanted : wanted_) aim(wanted);
}

void Agreement::want(SharedBody& shared, const pbd::Vec3& asked, bool replayed) {
  const std::uint32_t slot = shared.def.body.index;
  const pbd::BodyState& own = data_.world.states()[slot];
  if (found_.votes) {
    trust_.weigh_votes(own, 1.0 - shared.initiative.strength(), found_.states);
    // A state that the votes left without weight is not replayed.
    found_.keep([](const PeerEstimate& estimate) { return estimate.share > 0.0; });
  }
  Wanted wanted{.shared = &shared, .placed = shared.placed, .asked = asked};
  pbd::PoseTarget& target = wanted.target;
  target.body = shared.def.body;
  target.motion = found_.motion;
  if (!fuse(own.pose, found_.states, target)) return;
  wanted.heaviest = std::max_element(found_.states.begin(), found_.states.end(),
                                     [](const PeerEstimate& l, const PeerEstimate& r) {
                                       return l.weight < r.weight;
                                     })
                        ->peer;
  if (found_.by_hand || !replayed) {
    wanted_.push_back(wanted);
    return;
  }
  // Upper bound on the motion between the stamps and now.
  double way = 0.0;
  bool apart = false;
  SessionTime oldest = data_.now;
  for (const Stamped& there : found_.stamped) {
    const double age = std::max(0.0, seconds(data_.now - there.stamp));
    way = std::max(way, age * std::max(speed(own.twist), speed(there.state.twist)));
    apart = apart || there.apart;
    oldest = std::min(oldest, there.stamp);
  }
  const double least = found_.leaders.empty() ? 0.0 : following_share(seconds(data_.now - oldest));
  if (target.share < 1.0) target.share = std::max(data_.options.replay.share, least);
  if (way <= data_.options.replay.tolerance) {
    // If the body was placed since, its earlier pose does not matter.
    if (!apart || data_.history.placed_since(slot, oldest)) return;
    stay(data_.history.state_at(slot, oldest), target);
  } else {
    const SessionTime known = data_.history.frame(data_.history.first()).time;
    for (std::size_t i = 0; i < found_.stamped.size(); ++i) {
      const Stamped& there = found_.stamped[i];
      if (there.stamp < known) continue;  // before the recorded history
      const PeerEstimate& estimate = found_.states[i];
      // An owner's state is the only one to use: the replay goes back to it.
      replay_->add({.slot = slot,
                    .peer = estimate.peer,
                    .stamp = there.stamp,
                    .weight = weight_of_share(estimate.share),
                    .carried = estimate.share < 1.0 && latecomers_.is_carried(estimate.peer),
                    .state = there.state});
    }
    wanted.replayed = true;
    wanted.oldest = oldest;
    apart_ = apart_ || apart;
  }
  wanted_.push_back(wanted);
}

void Agreement::stay(const pbd::BodyState& then, pbd::PoseTarget& target) {
  for (std::size_t i = 0; i < found_.stamped.size(); ++i) {
    found_.states[i].pose = found_.stamped[i].state.pose;
    found_.states[i].twist = found_.stamped[i].state.twist;
  }
  pbd::PoseTarget fused;
  fuse(then.pose, found_.states, fused);
  const pbd::BodyState mean = mean_with(then, fused);
  target.pose = mean.pose;
  target.twist = mean.twist;
  target.use_rotation_error = false;
}

void Agreement::ease_in(const pbd::BodyState& own, Wanted& wanted) const {
  pbd::PoseTarget& target = wanted.target;
  if (target.share >= 1.0) return;
  const pbd::Vec3 gap = target.pose.position - own.pose.position;
  const double distance = gap.norm();
  if (!(distance > 0.0)) return;
  const double age = std::max(data_.step_dt, seconds(data_.now - wanted.oldest));
  const double faster = (target.twist.linear - own.twist.linear).norm();  // m/s
  const double growth = 2.0 * std::max(distance / age, faster) * data_.step_dt / age;
  const double most = std::max(0.0, wanted.asked.dot(gap) / distance) + growth * data_.step_dt;
  const double full = share_per_step(target.share, data_.step_dt) * distance;
  if (full > most) target.share *= most / full;
}

void Agreement::aim(Wanted& wanted) {
  SharedBody& shared = *wanted.shared;
  pbd::PoseTarget& target = wanted.target;
  const pbd::BodyState& own = data_.world.states()[shared.def.body.index];
  // Another body's placement has moved this one along to the leader's: the earlier comparison is
  // void. A replayed mean is compared only below.
  if (!wanted.replayed && wanted.placed != shared.placed) return;
  if (wanted.replayed) {
    const pbd::Correction* const missing = replay_->find(shared.def.body.index);
    if (missing == nullptr) return;
    const pbd::BodyState mean = moved(own, *missing);
    target.pose = mean.pose;
    target.twist = mean.twist;
    target.use_rotation_error = false;
    if (!shared.def.orientation) target.pose.orientation = own.pose.orientation;
  }
  if (data_.world.props(target.body).type == pbd::BodyType::Kinematic) {
    // The solver does not pull at kinematic bodies: this one follows its owner's hand and pushes
    // what is in its way.
    if (target.share < 1.0) return;
    const pbd::BodyState there = carried(mean_with(own, target), data_.step_dt);
    return data_.world.set_kinematic_target(target.body, there.pose);
  }
  trust_.limit(own, wanted);
  if (wanted.replayed) ease_in(own, wanted);
  shared.asked =
      share_per_step(target.share, data_.step_dt) * (target.pose.position - own.pose.position);
  targets_.push_back(target);
  targeted_.push_back(&shared);
}

}  // namespace tandem::consensus
