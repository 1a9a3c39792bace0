// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// How far others are believed: votes in place of a mean, limits of what is asked for, who gives
// way, and what is noted about whom.
#include <algorithm>
#include <cmath>

#include "peer_impl.h"
#include "tandem/consensus/robust.h"
#include "tandem/pbd/math.h"
#include "tandem/pbd/validate.h"

namespace tandem::consensus {
namespace {

/// Further than this (m, see StateOffset) from the others on average, and costing this much more
/// than the best: noted as an outlier.
constexpr double kOutlier = 0.05;
constexpr double kFar = 1.5;

/// No honest peer has so much more weight than the next one where nobody leads.
constexpr double kMoreThanOthers = 4.0;

/// Part of the ramp of authority in which a newcomer is put elsewhere where others correct what it
/// was told first, and how far (m) that has to be.
constexpr double kNewcomerPart = 0.3;
constexpr double kWrongPlace = 0.03;

/// Nobody sees that a body moved so far (m) in 1/60 s of itself, nor this part of its way, nor that
/// it went so much faster (m/s).
constexpr double kUnseen = 0.003;
constexpr double kUnseenPart = 0.1;
constexpr double kUnseenKick = 0.05;

/// `v` cut to a length.
pbd::Vec3 cut(const pbd::Vec3& v, double longest, bool& was_longer) {
  const double square = v.squaredNorm();
  if (square <= longest * longest) return v;
  was_longer = true;
  return v * (longest / std::sqrt(square));
}

}  // namespace

using pbd::detail::require;

void RobustOptions::validate() const {
  const auto positive = [](double value, const char* field) {
    require(value > 0.0, "RobustOptions", field, value, "> 0");
  };
  positive(max_correction, "max_correction");
  positive(max_turn, "max_turn");
  positive(max_velocity_correction, "max_velocity_correction");
  positive(max_spin_correction, "max_spin_correction");
  positive(max_pull, "max_pull");
  positive(max_stiffness, "max_stiffness");
  positive(max_damping, "max_damping");
  positive(max_reach, "max_reach");
  positive(max_hand_speed, "max_hand_speed");
  require(max_springs_per_body >= 1, "RobustOptions", "max_springs_per_body", max_springs_per_body,
          "at least 1");
}

PeerReport& Peer::Impl::report_of(PeerId peer) {
  auto it = std::lower_bound(reports_.begin(), reports_.end(), peer,
                             [](const PeerReport& r, PeerId id) { return r.peer < id; });
  if (it == reports_.end() || it->peer != peer) it = reports_.insert(it, PeerReport{.peer = peer});
  return *it;
}

std::span<const PeerReport> Peer::Impl::reports() {
  for (PeerReport& report : reports_) report.inbox = inbox_.counters(report.peer);
  return reports_;
}

void Peer::Impl::receive_spring(PeerId from, const SpringUpdate& update, pbd::BodyId body,
                                SessionTime now) {
  const Springs::Verdict verdict = springs_.receive(from, update, body, now);
  if (verdict == Springs::Verdict::Taken) return;
  PeerReport& report = report_of(from);
  if (verdict == Springs::Verdict::Limited) {
    ++report.springs_limited;
  } else {
    ++report.springs_refused;
    ++stats_.springs_refused;
  }
}

bool Peer::Impl::believes_lead(Shared& shared, PeerId from, SessionTime now) {
  const bool holds = springs_.held_by(from, shared.def.body) > 0 || owns_any(from);
  if (!options_.robust.outvote || shared.lead_claims.founded(from, holds, now)) return true;
  ++report_of(from).unfounded_leads;
  return false;
}

bool Peer::Impl::believes_hands(std::size_t others) const {
  return !options_.robust.outvote || others < 2 || options_.mode != InputMode::Soft;
}

bool Peer::Impl::owns_any(PeerId peer) const {
  return std::binary_search(owners_.begin(), owners_.end(), std::pair(peer, std::size_t{0}),
                            [](const auto& a, const auto& b) { return a.first < b.first; });
}

bool Peer::Impl::outvoted_at_stamp(const Shared& shared, std::span<const Inbox::Received> newest,
                                   std::size_t i) {
  turns_.clear();
  std::size_t place = 0;
  for (std::size_t k = 0; k < newest.size(); ++k) {
    const StateUpdate& update = newest[k].update;
    if (k == i) place = turns_.size();
    if (k != i && !(update.influence > 0.0F)) continue;  // a newcomer's
    const pbd::Quat then = history_.state_at(shared.def.body.index, update.stamp).pose.orientation;
    turns_.push_back(
        {.peer = newest[k].peer, .turn = pbd::rotation_between(then, update.pose.orientation)});
  }
  return outvoted(turns_, place, transport_.self());
}

void Peer::Impl::give_way(Shared& shared, std::span<const Inbox::Received> newest, bool several,
                          SessionTime now) {
  const Claim* to = nullptr;
  for (std::size_t i = 0; i < claims_.size() && to == nullptr; ++i) {
    const PeerId peer = claims_[i].peer;
    const bool other = !leaders_.empty() ? peer == leaders_.front()
                       : several         ? outvoted(claims_, i, transport_.self())
                                         : peer < transport_.self();
    if (other) to = &claims_[i];
  }
  if (to == nullptr) return;
  const auto estimate = std::find_if(estimates_.begin(), estimates_.end(),
                                     [to](const auto& e) { return e.peer == to->peer; });
  if (estimate == estimates_.end()) return;
  // A newcomer took over what it heard first, which may have been a lie.
  const bool newcomer =
      several && confidence() < kNewcomerPart && leaders_.empty() && to->way.norm() > kWrongPlace;
  if (newcomer && shared.joined) {
    place(shared, {estimate->pose, estimate->twist});
    return;
  }
  const auto sent = std::find_if(newest.begin(), newest.end(),
                                 [to](const auto& r) { return r.peer == to->peer; });
  if (shared.held || sent->update.flags.held) return;
  if (!shared.lead.parted(to->way, to->turn, shared.blocked, now)) return;
  place_apart(shared, {estimate->pose, estimate->twist}, to->peer, now);
}

void Peer::Impl::weigh_votes(const pbd::BodyState& own) {
  double first = 0.0;
  double second = 0.0;
  for (PeerEstimate& estimate : estimates_) {
    estimate.weight = weight_of_share(estimate.share);
    if (estimate.weight > first) {
      second = first;
      first = estimate.weight;
    } else {
      second = std::max(second, estimate.weight);
    }
  }
  if (!(second > 0.0) || std::isinf(first)) return;
  // Nobody has more to say than the next one.
  votes_.clear();
  votes_.push_back({.at = {}, .weight = confidence()});
  for (PeerEstimate& estimate : estimates_) {
    if (estimate.weight > kMoreThanOthers * second) ++report_of(estimate.peer).influence_cut;
    estimate.weight = std::min(estimate.weight, second);
    votes_.push_back({.at = offset_of(gap(own, {estimate.pose, estimate.twist})),
                      .weight = estimate.weight / second});
  }
  weigh_centrality(votes_);
  note_outliers();
  for (std::size_t i = 0; i < estimates_.size(); ++i) {
    estimates_[i].share = share_of_weight(estimates_[i].weight * votes_[i + 1].central);
  }
}

void Peer::Impl::note_outliers() {
  double least = votes_[0].cost;
  for (const Vote& vote : votes_) {
    if (vote.weight > 0.0) least = std::min(least, vote.cost);
  }
  for (std::size_t i = 0; i < estimates_.size(); ++i) {
    const Vote& vote = votes_[i + 1];
    const bool far = vote.cost > kOutlier * static_cast<double>(estimates_.size());
    if (far && vote.cost > kFar * least) ++report_of(estimates_[i].peer).outliers;
  }
}

void Peer::Impl::limit(const pbd::BodyState& own, Wanted& wanted) {
  pbd::PoseTarget& target = wanted.target;
  if (target.share >= 1.0) return;
  const RobustOptions& most = options_.robust;
  bool capped = false;
  const double inverse = 1.0 / target.share;
  const auto within = [&](const pbd::Vec3& there, const pbd::Vec3& here, double longest) {
    bool longer = false;
    const pbd::Vec3 way = cut(there - here, longest * inverse, longer);
    capped = capped || longer;
    return longer ? pbd::Vec3(here + way) : there;
  };
  // Who has put its copies where the others have them shows them, and gives itself time.
  double step = most.max_correction;
  double kick = most.max_velocity_correction;
  if (wanted.shared->joined && confidence() < 1.0) {
    kick = std::min(kick, kUnseenKick);
    step = std::min(step, kUnseen + kUnseenPart * step_dt_ * own.twist.linear.norm());
  }
  target.pose.position = within(target.pose.position, own.pose.position, step);
  target.twist.linear = within(target.twist.linear, own.twist.linear, kick);
  target.twist.angular = within(target.twist.angular, own.twist.angular, most.max_spin_correction);
  if (target.use_rotation_error) {
    target.rotation_error = cut(target.rotation_error, most.max_turn * inverse, capped);
  }
  if (capped) ++report_of(wanted.heaviest).capped;
}

}  // namespace tandem::consensus
