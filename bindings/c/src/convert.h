// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <string>

#include "tandem/c/tandem.h"
#include "tandem/collision/contact_source.h"
#include "tandem/consensus/update.h"
#include "tandem/pbd/body.h"
#include "tandem/pbd/joint.h"
#include "tandem/pbd/validate.h"

namespace tandem::c {

inline pbd::Vec3 from_c(const tandem_vec3& v) { return {v.x, v.y, v.z}; }
inline tandem_vec3 to_c(const pbd::Vec3& v) { return {v.x(), v.y(), v.z()}; }
inline pbd::Pose from_c(const tandem_pose& pose) {
  const tandem_quat& q = pose.orientation;
  return {from_c(pose.position), pbd::Quat(q.w, q.x, q.y, q.z)};
}
inline tandem_pose to_c(const pbd::Pose& pose) {
  const pbd::Quat& q = pose.orientation;
  return {to_c(pose.position), {q.x(), q.y(), q.z(), q.w()}};
}
inline pbd::Twist from_c(const tandem_twist& twist) {
  return {from_c(twist.linear), from_c(twist.angular)};
}
inline tandem_twist to_c(const pbd::Twist& twist) {
  return {to_c(twist.linear), to_c(twist.angular)};
}
inline tandem_state to_c(const pbd::BodyState& state) {
  return {to_c(state.pose), to_c(state.twist)};
}

inline pbd::BodyId from_c(tandem_body id) { return {id.index, id.generation}; }
inline tandem_body to_c(const pbd::BodyId& id) { return {id.index, id.generation}; }
inline collision::ColliderId from_c(tandem_collider id) { return {id.index, id.generation}; }
inline tandem_collider to_c(const collision::ColliderId& id) { return {id.index, id.generation}; }
inline pbd::JointId from_c(tandem_joint id) { return {id.index, id.generation}; }
inline tandem_joint to_c(const pbd::JointId& id) { return {id.index, id.generation}; }

/// Row by row.
inline pbd::Mat3 matrix_from_c(const double (&m)[9]) {
  pbd::Mat3 result;
  result << m[0], m[1], m[2], m[3], m[4], m[5], m[6], m[7], m[8];
  return result;
}
inline void matrix_to_c(const pbd::Mat3& from, double (&m)[9]) {
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) m[3 * row + column] = from(row, column);
  }
}

inline constexpr tandem_pose kAtOrigin = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0, 1.0}};

/// A session time within half of the range, so that sums of two do not overflow.
inline std::int64_t checked_time(const char* field, std::int64_t time, std::int64_t least) {
  if (time < least || time > consensus::kMaxStamp) {
    pbd::detail::refuse(
        field, "from " + std::to_string(least) + " to " + std::to_string(consensus::kMaxStamp),
        std::to_string(time));
  }
  return time;
}

}  // namespace tandem::c
