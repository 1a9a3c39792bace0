// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "hard_input.h"

#include "tandem/pbd/math.h"

namespace tandem::consensus {
namespace {

constexpr int kSweeps = 10;  ///< a sweep over two hands leaves about a third of the error

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
          pbd::tensor_to_world(result.orientation, props.inverse_inertia_l);
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

}  // namespace tandem::consensus
