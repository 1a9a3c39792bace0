// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "agree/remote_states.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/body_state.h"
#include "common/ranges.h"
#include "common/session_time.h"
#include "tandem/consensus/compact.h"
#include "tandem/consensus/influence.h"
#include "tandem/pbd/math.h"

namespace tandem::consensus {
namespace {

/// rad: largest rotation by rounding. Half a quantum in each of three components c changes the
/// largest, L >= 1/2, by at most (|a| + |b| + |c|) / L <= 3 of it, and rotates by twice the length
/// of all four: 2 sqrt(3 + 9) half quanta.
constexpr double kRoundedAngle = 3.4641016151377544 * kOrientationQuantum;

/// `value` moved towards zero by at most `limit`.
double shrunk(double value, double limit) {
  return std::copysign(std::max(0.0, std::abs(value) - limit), value);
}

/// The value nearest to `own` that rounds to `value`, component by component.
pbd::Vec3 nearest(const pbd::Vec3& own, const pbd::Vec3& value, double half_quantum) {
  pbd::Vec3 out;
  for (int i = 0; i < 3; ++i) out[i] = own[i] + shrunk(value[i] - own[i], half_quantum);
  return out;
}

/// Checks lengths too: rotations and distances are computed from them.
bool finite(const Prediction& p) {
  return std::isfinite(p.translation.squaredNorm()) && std::isfinite(p.rotation.squaredNorm()) &&
         std::isfinite(p.twist.linear.squaredNorm()) &&
         std::isfinite(p.twist.angular.squaredNorm());
}

}  // namespace

RemoteStates::RemoteStates(PeerData& data)
    : data_(data),
      predictor_(data.options.own_predictor != nullptr
                     ? data.options.own_predictor
                     : make_predictor(data.options.predictor, data.options.prediction)),
      as_stamped_(make_predictor(PredictorKind::None)) {}

const StateUpdate& RemoteStates::as_meant(const Inbox::Received& received,
                                          const SharedBody& shared) {
  const StateUpdate& update = received.update;
  const bool oriented = update.oriented && shared.def.orientation;
  const SessionTime ahead = update.stamp - data_.now;
  if (!update.flags.resting && !update.rounded && oriented && ahead <= 0) return update;
  meant_ = update;
  meant_.stamp = std::min(data_.inbox.holds_until(received), data_.now);
  if (ahead > 0) {
    // The sender's clock is ahead: extrapolate back to now, as there is no own state of the future.
    meant_.pose = carried({update.pose, update.twist}, -seconds(ahead)).pose;
  }
  const pbd::BodyState own =
      data_.history.state_beside(shared.def.body.index, meant_.stamp, update.twist);
  if (!oriented) meant_.pose.orientation = own.pose.orientation;
  if (!update.rounded) return meant_;
  // Values that round alike count as equal: else bodies would be drawn to the lattice, and one that
  // slows down would be kept at a multiple of the speed's quantum.
  meant_.pose.position = nearest(own.pose.position, meant_.pose.position, 0.5 * kPositionQuantum);
  meant_.twist.linear = nearest(own.twist.linear, update.twist.linear, 0.5 * kLinearSpeedQuantum);
  meant_.twist.angular =
      nearest(own.twist.angular, update.twist.angular, 0.5 * kAngularSpeedQuantum);
  if (oriented) {
    const pbd::Vec3 turn = pbd::rotation_between(own.pose.orientation, meant_.pose.orientation);
    const double angle = turn.norm();
    const double left = angle > 0.0 ? shrunk(angle, kRoundedAngle) / angle : 0.0;
    meant_.pose.orientation = pbd::rotated(own.pose.orientation, left * turn);
  }
  return meant_;
}

Stamped RemoteStates::compare(const SharedBody& shared, const StateUpdate& update,
                              pbd::Correction& missing) const {
  const pbd::BodyState then =
      data_.history.state_beside(shared.def.body.index, update.stamp, update.twist);
  Stamped there{update.stamp, {update.pose, update.twist}};
  if (!update.oriented || !shared.def.orientation) {
    there.state.pose.orientation = then.pose.orientation;
  }
  missing = gap(then, there.state);
  const double age = seconds(data_.now - update.stamp);
  // Acts on it were applied here later than at the stamp.
  const pbd::Correction behind = data_.history.lag(shared.def.body.index, update.stamp,
                                                   std::numeric_limits<SessionTime>::max());
  const pbd::Vec3 far = missing.translation + behind.translation;
  const pbd::Vec3 turned = missing.rotation + behind.rotation;
  const double way = far.norm() + kLeverArm * turned.norm();
  there.apart = way + age * speed(missing.twist) > data_.options.replay.tolerance;
  return there;
}

void RemoteStates::as_of_now(const SharedBody& shared, std::span<const Inbox::Received> newest,
                             std::vector<StateUpdate>& out) {
  const pbd::BodyState& own = data_.world.state(shared.def.body);
  for (const Inbox::Received& received : newest) {
    StateUpdate update = as_meant(received, shared);
    const double age = std::max(0.0, seconds(data_.now - update.stamp));
    pbd::Correction missing;
    (void)compare(shared, update, missing);
    missing.translation += age * missing.twist.linear;
    const pbd::BodyState now = moved(own, missing);
    update.pose = now.pose;
    update.twist = now.twist;
    update.stamp = data_.now;
    out.push_back(update);
  }
}

Prediction RemoteStates::carry(SharedBody& shared, PeerId from, const StateUpdate& update) {
  const OwnMotion own(data_.history, shared.def.body.index);
  const PredictionContext context = context_of(shared, from);
  Prediction prediction = predictor_->predict(update, own, context);
  // Values of an application's predictor enter the world only if finite.
  if (!finite(prediction)) prediction = as_stamped_->predict(update, own, context);
  if (!update.oriented || !shared.def.orientation) prediction.rotation.setZero();
  return prediction;
}

void RemoteStates::observe(SharedBody& shared, PeerId from, const StateUpdate& update,
                           const Prediction& prediction) {
  if (observer_ == nullptr) return;
  const OwnMotion own(data_.history, shared.def.body.index);
  observer_->on_estimate({from, update, own, context_of(shared, from), prediction,
                          data_.world.pose(shared.def.body).position + prediction.translation,
                          seconds(data_.now - update.stamp)});
}

PredictionContext RemoteStates::context_of(SharedBody& shared, PeerId from) {
  const double scale = data_.world.all_props()[shared.def.body.index].gravity_scale;
  return {.now = data_.now,
          .gravity = scale * data_.world.gravity(),
          .memory = predictor_->remembers() ? &heard_from(shared, from).memory : nullptr};
}

Heard& RemoteStates::heard_from(SharedBody& shared, PeerId peer) const {
  auto it = ranges::lower_bound(shared.heard, peer, &Heard::peer);
  if (it == shared.heard.end() || it->peer != peer) {
    it = shared.heard.insert(it, {.peer = peer, .last = data_.now, .memory = {}});
  } else if (seconds(data_.now - it->last) > data_.options.influence.max_age) {
    *it = {.peer = peer, .last = data_.now, .memory = {}};  // it was away, or restarted
  }
  it->last = data_.now;
  return *it;
}

}  // namespace tandem::consensus
