// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "input/hard_input.h"

#include "common/body_state.h"
#include "peer_data.h"
#include "tandem/pbd/math.h"
#include "tandem/pbd/portable.h"

namespace tandem::consensus {
namespace {

/// s: time constant of the low-pass on a dragged body's velocity.
constexpr double kVelocityFilter = 0.025;
constexpr int kSweeps = 10;  ///< a sweep over two hands reduces the error to about a third

}  // namespace

pbd::Pose dragged(const pbd::BodyProps& props, const pbd::Pose& pose,
                  std::span<const Springs::Hand> hands) {
  pbd::Pose result = pose;
  if (!(props.inverse_mass > 0.0)) return result;
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    for (const Springs::Hand& hand : hands) {
      const pbd::Vec3 arm = result.orientation * hand.attachment_l;
      const pbd::Vec3 missing = hand.anchor_w - (result.position + arm);
      const pbd::Mat3 inverse_inertia =
          pbd::tensor_to_world(result.orientation, props.inverse_inertia);
      const pbd::Mat3 cross = pbd::skew(arm);
      const pbd::Mat3 inverse_mass =
          pbd::Mat3(props.inverse_mass * pbd::Mat3::Identity()) - cross * inverse_inertia * cross;
      const pbd::Vec3 impulse = inverse_mass.ldlt().solve(missing);
      result.position += props.inverse_mass * impulse;
      result.orientation = pbd::rotated(result.orientation, inverse_inertia * arm.cross(impulse));
      if (hands.size() == 1 && missing.norm() == 0.0) return result;
    }
  }
  return result;
}

bool HardInputs::drag(SharedBody& shared, std::vector<PeerEstimate>& others) {
  hands_.clear();
  data_.springs.hands(shared.def.body, data_.now, hands_);
  HardInput& hard = shared.hard;
  if (hands_.empty()) {
    hard.active = false;
    return false;
  }
  const pbd::BodyState last = hard.own;
  const pbd::BodyState& shown = data_.world.state(shared.def.body);
  hard.own.pose = dragged(data_.world.props(shared.def.body), shown.pose, hands_);
  if (!hard.active) {
    hard.own.twist = {};
  } else if (data_.step_dt > 0.0) {
    // `last` is the extrapolated position for now: the difference to it is a change of velocity.
    const double part = 1.0 - pbd::portable::exp(-data_.step_dt / kVelocityFilter);
    hard.own.twist.linear += part / data_.step_dt * (hard.own.pose.position - last.pose.position);
    hard.own.twist.angular +=
        part / data_.step_dt *
        pbd::rotation_between(last.pose.orientation, hard.own.pose.orientation);
  }
  hard.active = true;
  std::erase_if(others, [](const PeerEstimate& estimate) { return estimate.share < 1.0; });
  hard.shown = hard.own;
  pbd::PoseTarget mean;
  if (!others.empty() && fuse(hard.own.pose, others, mean)) {
    const auto count = static_cast<double>(others.size());
    hard.shown = moved(hard.own, gap(hard.own, {mean.pose, mean.twist}), count / (1.0 + count));
  }
  data_.world.set_pose(shared.def.body, hard.shown.pose);
  data_.world.set_twist(shared.def.body, hard.shown.twist);
  return true;
}

void HardInputs::carry_on(SharedBody& shared, double dt) {
  HardInput& hard = shared.hard;
  if (!hard.active) return;
  hard.own = carried(hard.own, dt);
  hard.shown = carried(hard.shown, dt);
  data_.world.set_pose(shared.def.body, hard.shown.pose);
  data_.world.set_twist(shared.def.body, hard.shown.twist);
}

}  // namespace tandem::consensus
