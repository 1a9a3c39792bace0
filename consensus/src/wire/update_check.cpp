// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Range checks of updates. check() tests numbers at the precision in which they arrive, so that
// sender and receiver agree about a value at the edge of its range.
#include <cmath>

#include "tandem/consensus/update.h"
#include "wire/compact_wire.h"

namespace tandem::consensus {
namespace {

using pbd::Quat;
using pbd::Vec3;

/// Checks that the norm is finite and below `limit`. The details name field and rule.
CodecResult check_norm(const Vec3& v, double limit, const char* finite, const char* range) {
  if (!v.allFinite()) return fault(PacketFault::NotFinite, finite);
  // Not v.norm() < limit: an overflowing square must fail too, and does.
  if (!(v.squaredNorm() < limit * limit)) return fault(PacketFault::OutOfRange, range);
  return {};
}

/// check_norm() for a velocity sent as 32-bit floats, tested in that precision. (Not converted back
/// to 64 bits for it: g++ 12.2 drops both conversions at -O2, which its tests show.)
CodecResult check_sent_norm(const Vec3& v, double limit, const char* finite, const char* range) {
  if (!v.allFinite()) return fault(PacketFault::NotFinite, finite);
  const float sent_limit = static_cast<float>(limit);
  // A number far above the limit may not be representable as a float.
  if (!(v.cwiseAbs().maxCoeff() < 2.0 * limit)) return fault(PacketFault::OutOfRange, range);
  const Eigen::Vector3f sent = v.cast<float>();
  if (!(sent.squaredNorm() < sent_limit * sent_limit)) return fault(PacketFault::OutOfRange, range);
  return {};
}

CodecResult check_orientation(const Quat& q) {
  if (!q.coeffs().allFinite()) {
    return fault(PacketFault::NotFinite, "orientation: must be finite");
  }
  constexpr const char* kRule = "orientation: norm must be within 1e-3 of 1";
  if (!(q.coeffs().cwiseAbs().maxCoeff() < 1.5)) return fault(PacketFault::OutOfRange, kRule);
  double square = 0.0;
  for (const double component : {q.w(), q.x(), q.y(), q.z()}) {
    const double sent = from_fixed(to_fixed(component));
    square += sent * sent;
  }
  if (!(std::abs(std::sqrt(square) - 1.0) <= 1e-3)) return fault(PacketFault::OutOfRange, kRule);
  return {};
}

CodecResult check_stamp(SessionTime stamp) {
  if (stamp < -kMaxStamp || stamp > kMaxStamp) {
    return fault(PacketFault::OutOfRange, "timestamp: must be within 2^62 ns of 0");
  }
  return {};
}

CodecResult check_id(const SharedId& id) {
  return id.valid() ? CodecResult{} : fault(PacketFault::BadId, "id: must not be all zeros");
}

CodecResult check_parameter(double value, const char* finite, const char* range) {
  if (!std::isfinite(value)) return fault(PacketFault::NotFinite, finite);
  if (!(value >= 0.0 && value < kMaxSpringParameter)) return fault(PacketFault::OutOfRange, range);
  return {};
}

}  // namespace

CodecResult check(const StateUpdate& update) {
  const CodecResult result = check_id(update.id);
  return result.ok() ? check_state(update) : result;
}

CodecResult check_state(const StateUpdate& update) {
  CodecResult result = check_norm(update.pose.position, kMaxPosition, "position: must be finite",
                                  "position: norm must be below 1e7 m");
  if (!result.ok()) return result;
  result = check_sent_norm(update.twist.linear, kMaxLinearSpeed, "velocity: must be finite",
                           "velocity: norm must be below 1e5 m/s");
  if (!result.ok()) return result;
  result = check_orientation(update.pose.orientation);
  if (!result.ok()) return result;
  result =
      check_sent_norm(update.twist.angular, kMaxAngularSpeed, "angular velocity: must be finite",
                      "angular velocity: norm must be below 1e5 rad/s");
  if (!result.ok()) return result;
  if (!std::isfinite(update.influence)) {
    return fault(PacketFault::NotFinite, "influence: must be finite");
  }
  if (!(update.influence >= 0.0f && update.influence <= 1.0f)) {
    return fault(PacketFault::OutOfRange, "influence: must be 0 to 1");
  }
  return check_stamp(update.stamp);
}

CodecResult check(const SpringUpdate& update) {
  if (update.event < SpringEvent::Create || update.event > SpringEvent::Remove)
    return fault(PacketFault::BadCode, "event: must be 1 to 3");
  CodecResult result = check_id(update.body);
  if (!result.ok()) return result;
  result = check_norm(update.attachment_l, kMaxPosition, "attachment: must be finite",
                      "attachment: norm must be below 1e7 m");
  if (!result.ok()) return result;
  result = check_norm(update.anchor_w, kMaxPosition, "anchor: must be finite",
                      "anchor: norm must be below 1e7 m");
  if (!result.ok()) return result;
  result = check_norm(update.anchor_velocity, kMaxLinearSpeed, "anchor velocity: must be finite",
                      "anchor velocity: norm must be below 1e5 m/s");
  if (!result.ok()) return result;
  result = check_parameter(update.stiffness, "stiffness: must be finite",
                           "stiffness: must be 0 to below 1e12 N/m");
  if (!result.ok()) return result;
  result = check_parameter(update.damping, "damping: must be finite",
                           "damping: must be 0 to below 1e12 N s/m");
  if (!result.ok()) return result;
  result = check_parameter(update.max_force, "max force: must be finite",
                           "max force: must be 0 to below 1e12 N");
  if (!result.ok()) return result;
  return check_stamp(update.stamp);
}

CodecResult check_anchor(const AnchorUpdate& anchor) {
  CodecResult result = check_norm(anchor.anchor_w, kMaxPosition, "anchor: must be finite",
                                  "anchor: norm must be below 1e7 m");
  if (!result.ok()) return result;
  result = check_norm(anchor.anchor_velocity, kMaxLinearSpeed, "anchor velocity: must be finite",
                      "anchor velocity: norm must be below 1e5 m/s");
  return result.ok() ? check_stamp(anchor.stamp) : result;
}

CodecResult check(const Leave& leave) { return check_stamp(leave.stamp); }

CodecResult check(const Alive& alive) { return check_stamp(alive.stamp); }

CodecResult check(const OwnershipUpdate& update) {
  if (update.event != OwnershipEvent::Request && update.event != OwnershipEvent::Grant) {
    return fault(PacketFault::BadCode, "ownership: event must be 1 or 2");
  }
  const CodecResult result = check_id(update.body);
  if (!result.ok()) return result;
  if (update.to == 0) return fault(PacketFault::BadId, "ownership: to must not be 0");
  return check_stamp(update.stamp);
}

CodecResult check(const ActUpdate& act) {
  CodecResult result = check_id(act.body);
  if (!result.ok()) return result;
  // An act without effect would lead the body, and use up a name, for nothing.
  if (!act.pose && !act.twist && act.impulse.isZero(0.0) && act.angular_impulse.isZero(0.0)) {
    return fault(PacketFault::OutOfRange, "impulse: must not be zero where nothing else is done");
  }
  result = check_norm(act.impulse, kMaxImpulse, "impulse: must be finite",
                      "impulse: norm must be below 1e12 N s");
  if (!result.ok()) return result;
  result = check_norm(act.angular_impulse, kMaxImpulse, "angular impulse: must be finite",
                      "angular impulse: norm must be below 1e12 N m s");
  if (!result.ok()) return result;
  if (act.pose) {
    result = check_norm(act.pose->position, kMaxPosition, "position: must be finite",
                        "position: norm must be below 1e7 m");
    if (!result.ok()) return result;
    result = check_orientation(act.pose->orientation);
    if (!result.ok()) return result;
  }
  if (act.twist) {
    result = check_norm(act.twist->linear, kMaxLinearSpeed, "velocity: must be finite",
                        "velocity: norm must be below 1e5 m/s");
    if (!result.ok()) return result;
    result = check_norm(act.twist->angular, kMaxAngularSpeed, "angular velocity: must be finite",
                        "angular velocity: norm must be below 1e5 rad/s");
    if (!result.ok()) return result;
  }
  return check_stamp(act.stamp);
}

CodecResult check(const ActReceipt& receipt) {
  const CodecResult result = check_id(receipt.body);
  if (!result.ok()) return result;
  if (receipt.actor == 0) return fault(PacketFault::BadId, "receipt: actor must not be 0");
  return check_stamp(receipt.stamp);
}

}  // namespace tandem::consensus
