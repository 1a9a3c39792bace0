// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "agree/trust.h"

#include <algorithm>
#include <cmath>

#include "common/body_state.h"
#include "tandem/consensus/influence.h"
#include "tandem/consensus/robust.h"
#include "tandem/pbd/math.h"
#include "tandem/pbd/validate.h"

namespace tandem::consensus {
namespace {

/// A state further than kOutlier (m, see StateOffset) from the others on average, and kFar times as
/// costly as the best one, is noted as an outlier. With kFar three times as large the liars of
/// tests/consensus/malicious_test.cpp are not noted.
constexpr double kOutlier = 0.05;
constexpr double kFar = 1.5;

/// If nobody leads, no honest peer's weight exceeds the next one's by this factor.
constexpr double kMoreThanOthers = 4.0;

/// A shift this small (m per 1/60 s), this fraction of the body's own motion, or a change of speed
/// this small (m/s) goes unnoticed.
constexpr double kUnseen = 0.003;
constexpr double kUnseenPart = 0.1;
constexpr double kUnseenKick = 0.05;

/// `v` shortened to at most `longest`.
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
  positive(max_pull_speed, "max_pull_speed");
  positive(max_reach, "max_reach");
  require(max_springs_per_body >= 1, "RobustOptions", "max_springs_per_body", max_springs_per_body,
          "at least 1");
}

bool Trust::believes_lead(SharedBody& shared, PeerId from) {
  const bool holds = data_.springs.held_by(from, shared.def.body) > 0 ||
                     data_.bodies.owns_any(from) || data_.acts.acted(from, shared.def.body);
  if (!data_.options.robust.outvote || shared.lead_claims.founded(from, holds, data_.now))
    return true;
  ++data_.report_of(from).unfounded_leads;
  return false;
}

bool Trust::believes_hands(std::size_t others) const {
  return !data_.options.robust.outvote || others < 2 || data_.options.mode != InputMode::Soft;
}

bool Trust::outvoted_at_stamp(const SharedBody& shared, std::span<const Inbox::Received> newest,
                              std::size_t i) {
  turns_.clear();
  std::size_t place = 0;
  for (std::size_t k = 0; k < newest.size(); ++k) {
    const StateUpdate& update = newest[k].update;
    if (k == i) place = turns_.size();
    if (k != i && !(update.influence > 0.0F)) continue;  // a newcomer's
    const pbd::Quat then =
        data_.history.state_at(shared.def.body.index, update.stamp).pose.orientation;
    turns_.push_back(
        {.peer = newest[k].peer, .turn = pbd::rotation_between(then, update.pose.orientation)});
  }
  return outvoted(turns_, place, data_.self());
}

void Trust::weigh_votes(const pbd::BodyState& own, double equal,
                        std::span<PeerEstimate> estimates) {
  double first = 0.0;
  double second = 0.0;
  for (PeerEstimate& estimate : estimates) {
    estimate.weight = weight_of_share(estimate.share);
    if (estimate.weight > first) {
      second = first;
      first = estimate.weight;
    } else {
      second = std::max(second, estimate.weight);
    }
  }
  if (!(second > 0.0) || std::isinf(first)) return;
  // No peer has more weight than the next one; but if the next one claims next to nothing, the
  // first keeps the weight of any peer.
  if (first > kMoreThanOthers * second) second = std::max(second, std::min(first, equal));
  votes_.clear();
  votes_.push_back({.at = {}, .weight = data_.confidence()});
  for (PeerEstimate& estimate : estimates) {
    if (estimate.weight > kMoreThanOthers * second) ++data_.report_of(estimate.peer).influence_cut;
    estimate.weight = std::min(estimate.weight, second);
    votes_.push_back({.at = offset_of(gap(own, {estimate.pose, estimate.twist})),
                      .weight = estimate.weight / second});
  }
  weigh_centrality(votes_);
  note_outliers(estimates);
  for (std::size_t i = 0; i < estimates.size(); ++i) {
    estimates[i].share = share_of_weight(estimates[i].weight * votes_[i + 1].central);
  }
}

void Trust::note_outliers(std::span<const PeerEstimate> estimates) {
  double least = votes_[0].cost;
  for (const Vote& vote : votes_) {
    if (vote.weight > 0.0) least = std::min(least, vote.cost);
  }
  for (std::size_t i = 0; i < estimates.size(); ++i) {
    const Vote& vote = votes_[i + 1];
    const bool far = vote.cost > kOutlier * static_cast<double>(estimates.size());
    if (far && vote.cost > kFar * least) ++data_.report_of(estimates[i].peer).outliers;
  }
}

void Trust::limit(const pbd::BodyState& own, Wanted& wanted) {
  pbd::PoseTarget& target = wanted.target;
  if (target.share >= 1.0) return;
  const RobustOptions& most = data_.options.robust;
  bool capped = false;
  const double inverse = 1.0 / target.share;
  const auto within = [&](const pbd::Vec3& there, const pbd::Vec3& here, double longest) {
    bool longer = false;
    const pbd::Vec3 way = cut(there - here, longest * inverse, longer);
    capped = capped || longer;
    return longer ? pbd::Vec3(here + way) : there;
  };
  // A newcomer that has placed its copies corrects them slowly and unseen.
  double step = most.max_correction;
  double kick = most.max_velocity_correction;
  if (wanted.shared->joined && data_.confidence() < 1.0) {
    kick = std::min(kick, kUnseenKick);
    step = std::min(step, kUnseen + kUnseenPart * data_.step_dt * own.twist.linear.norm());
  }
  target.pose.position = within(target.pose.position, own.pose.position, step);
  target.twist.linear = within(target.twist.linear, own.twist.linear, kick);
  target.twist.angular = within(target.twist.angular, own.twist.angular, most.max_spin_correction);
  const pbd::Vec3 turn = target.use_rotation_error
                             ? target.rotation_error
                             : pbd::rotation_between(own.pose.orientation, target.pose.orientation);
  bool too_far = false;
  const pbd::Vec3 less = cut(turn, most.max_turn * inverse, too_far);
  if (too_far) {
    capped = true;
    target.rotation_error = less;
    target.use_rotation_error = true;
  }
  if (capped) ++data_.report_of(wanted.heaviest).capped;
}

}  // namespace tandem::consensus
