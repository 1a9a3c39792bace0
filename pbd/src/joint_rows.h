// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "joint_law.h"
#include "tandem/pbd/corrections.h"
#include "tandem/pbd/joint_def.h"
#include "tandem/pbd/portable.h"

/// The coordinates of a joint, their gradients and residuals.
/// Legend: rel = rotation of frame b in frame a = swing * twist about x; e = x axis of b in frame
/// a; phi = angle between the x axes; u = unit axis of the swing.
namespace tandem::pbd {

/// Displacements x y z, twist, swing y, swing z, cone (= phi), and the turn since the start of the
/// substep about the three axes of frame a, where a drive acts.
inline constexpr int kCoordinates = 10;
inline constexpr int kTwist = 3;
inline constexpr int kCone = 6;
inline constexpr int kDrive = 7;

/// Angle equal to `angle` modulo 2 pi, nearest to `near`.
inline double nearest_turn(double angle, double near) {
  constexpr double kTurn = 2.0 * std::numbers::pi;
  return angle + kTurn * std::round((near - angle) / kTurn);
}

/// Frames of a joint in the world.
struct JointPlace {
  Vec3 r_a, r_b;  ///< m, from the centres of mass to the anchors
  Vec3 d;         ///< m, from the anchor of a to that of b

  [[gnu::always_inline]] static JointPlace of(const SixDofJointDef& def, const SolverBody& a,
                                              const SolverBody& b) {
    JointPlace place;
    place.r_a = rotate(a.q, def.frame_a.anchor);
    place.r_b = rotate(b.q, def.frame_b.anchor);
    place.d = (b.x + place.r_b) - (a.x + place.r_a);
    return place;
  }
};

/// Rotation of frame b in frame a, as twist and swing. Beyond half a turn of swing the two are
/// ambiguous, so a joint with a single free axis uses that as its x: see JointRecord::turning.
struct JointTurn {
  double twist;  ///< rad, -pi to pi
  double phi;    ///< rad, 0 to pi
  Vec3 e;        ///< x axis of b in frame a
  Vec3 u;        ///< axis of the swing, in frame a; any axis perpendicular to x if the swing is 0
  double scale;  ///< phi / sin(phi), bounded

  static JointTurn of(const Quat& rel) {
    JointTurn turn;
    turn.twist = nearest_turn(2.0 * portable::atan2(rel.x(), rel.w()), 0.0);
    const double sine = std::sqrt(rel.y() * rel.y() + rel.z() * rel.z());
    const double cosine = std::sqrt(rel.w() * rel.w() + rel.x() * rel.x());
    turn.phi = 2.0 * portable::atan2(sine, cosine);
    turn.e = Vec3(cosine * cosine - sine * sine, 2.0 * (rel.x() * rel.y() + rel.w() * rel.z()),
                  2.0 * (rel.x() * rel.z() - rel.w() * rel.y()));
    const double across = 2.0 * sine * cosine;  // sin(phi)
    constexpr double kSmall = 1e-9;
    turn.u = across > kSmall ? Vec3(0.0, -turn.e.z() / across, turn.e.y() / across) : Vec3::UnitY();
    turn.scale =
        across > kSmall ? std::min(turn.phi / across, 1e3) : (turn.e.x() > 0.0 ? 1.0 : 1e3);
    return turn;
  }
  /// Component of the swing's rotation vector, axis 1 (y) or 2 (z).
  double swing(int axis) const { return phi * u[axis]; }
  /// d twist / d(rotation of b relative to a), in frame a.
  Vec3 twist_gradient() const { return (Vec3::UnitX() + e) / std::max(1.0 + e.x(), 1e-6); }
  /// The gradient of the swing's component: along u the angle changes, across it the direction.
  Vec3 swing_gradient(int axis) const {
    return u[axis] * u + scale * Vec3::UnitX().cross(u)[axis] * e.cross(u);
  }
};

/// The same rotation with axes renamed cyclically: `axis` becomes x.
inline Quat turned_axes(const Quat& rel, int axis) {
  const Vec3 v = rel.vec();
  return {rel.w(), v[axis], v[(axis + 1) % 3], v[(axis + 2) % 3]};
}

/// What the displacement channel left of a rigid row that should have kept `bound`. 0 for a soft
/// row: its stretch is a force.
inline double residual_of(const JointAxis& axis, double c, double bound) {
  if (axis.compliance > 0.0 || axis.freedom == Freedom::Free) return 0.0;
  if (axis.freedom == Freedom::Locked) return c - bound;
  return c - std::clamp(c, std::min(axis.lower, bound), std::max(axis.upper, bound));
}

/// The whole violation of a row, if nothing was kept.
inline double residual_of(const JointAxis& axis, double c) {
  return residual_of(axis, c,
                     axis.freedom == Freedom::Locked ? 0.0 : std::clamp(c, axis.lower, axis.upper));
}

/// m or rad. A residual larger than this that contacts leave of a row is a gap and closes by
/// displacement: two capsules with an initial overlap of 4 cm on ball joints came to 24 J when it
/// was closed with velocity.
inline constexpr double kLeft = 2e-3;

/// The residual of a row at the start of a substep. Contacts are solved after joints. What they
/// leave of a row must not be taken back with the velocity that closes all of it in the next
/// substep: joints and contacts would then reflect instead of project, so that limbs on the ground
/// tremble for ever, and those that fall on their end are thrown up.
/// @param left  by contacts, in the last substep of this step: between steps applications move
///   bodies
/// @param displaced  the displacement channel closes it
/// @param most  bound on the part that closes with velocity
inline double residual_at_start(const JointAxis& axis, double c, double residual, bool left,
                                bool displaced, double h, double most = kUnlimited) {
  if (left) residual = residual_of(axis, c);
  if (displaced) return residual;
  return residual - std::clamp(residual, -most, most) * (1.0 - residual_decay(h));
}

/// Bounds on closing by displacement, for joints that were added violated or whose bodies were
/// placed. An impact at these speeds would be a hard one; limbs that start outside their limits are
/// back within half a second.
inline constexpr double kClosingSpeed = 5.0;  // m/s, of anchors
inline constexpr double kClosingSpin = 10.0;  // rad/s

/// Remaining gap of a row that has reached c and aimed at `bound`, with `rest` left over.
inline double gap_left(const JointAxis& axis, double c, double bound, double rest) {
  const double left = residual_of(axis, c, bound);
  if (axis.freedom != Freedom::Limited) return rest + left;
  // At most the violation, on the violated side.
  const double violated = residual_of(axis, c);
  const auto within = [&](double gap) {
    return std::clamp(gap, std::min(violated, 0.0), std::max(violated, 0.0));
  };
  return within(within(rest) + left);
}

/// The angle, modulo 2 pi, that lies within the limits and is nearest to `near`; if there is none,
/// the one nearest to the limits.
inline double turn_within(double angle, double near, double lower, double upper) {
  constexpr double kTurn = 2.0 * std::numbers::pi;
  const double at = nearest_turn(angle, near);
  if (at >= lower && at <= upper) return at;
  // The candidates on both sides of the violated limit.
  const double stop = at < lower ? lower : upper;
  const double below = at + kTurn * std::floor((stop - at) / kTurn);
  const double above = below + kTurn;
  const auto beyond = [&](double t) { return std::max({0.0, lower - t, t - upper}); };
  return beyond(below) <= beyond(above) ? below : above;
}

/// Violation of a rigid lock or limit, m or rad.
inline double violation(const JointAxis& axis, double c) {
  if (axis.compliance > 0.0 || axis.freedom == Freedom::Free) return 0.0;
  if (axis.freedom == Freedom::Locked) return std::abs(c);
  return std::max({0.0, axis.lower - c, c - axis.upper});
}

}  // namespace tandem::pbd
