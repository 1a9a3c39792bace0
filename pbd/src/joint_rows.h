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

/// The coordinates of a joint, their gradients, and what is left of them.
/// Legend: rel = rotation of frame b in frame a = swing * twist about x; e = x axis of b in frame
/// a; phi = angle between the x axes; u = unit axis of the swing.
namespace tandem::pbd {

/// Displacements x y z, twist, swing y, swing z, cone (= phi), and the turn since the substep began
/// about the three axes of frame a, where a drive acts.
inline constexpr int kCoordinates = 10;
inline constexpr int kTwist = 3;
inline constexpr int kCone = 6;
inline constexpr int kDrive = 7;

/// Angle equal to `angle` up to whole turns, nearest to `near`.
inline double nearest_turn(double angle, double near) {
  constexpr double kTurn = 2.0 * std::numbers::pi;
  return angle + kTurn * std::round((near - angle) / kTurn);
}

/// Where the frames of a joint stand, in the world.
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

/// Rotation of frame b in frame a, as twist and swing. Beyond half a turn of swing there is no
/// telling it from twist, so what turns about one axis alone has that as its x: see
/// JointRecord::turning.
struct JointTurn {
  double twist;  ///< rad, -pi to pi
  double phi;    ///< rad, 0 to pi
  Vec3 e;        ///< x axis of b in frame a
  Vec3 u;        ///< axis of the swing, in frame a; any one across x where there is none
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
  /// Component of the rotation vector of the swing, axis 1 (y) or 2 (z).
  double swing(int axis) const { return phi * u[axis]; }
  /// d twist / d(rotation of b against a), in frame a.
  Vec3 twist_gradient() const { return (Vec3::UnitX() + e) / std::max(1.0 + e.x(), 1e-6); }
  /// The same for the swing's component: along u the angle changes, across it the direction.
  Vec3 swing_gradient(int axis) const {
    return u[axis] * u + scale * Vec3::UnitX().cross(u)[axis] * e.cross(u);
  }
};

/// The same rotation where `axis` is called x, and those that follow it y and z.
inline Quat turned_axes(const Quat& rel, int axis) {
  const Vec3 v = rel.vec();
  return {rel.w(), v[axis], v[(axis + 1) % 3], v[(axis + 2) % 3]};
}

/// What the displacement channel left of a rigid row that should have kept `bound`. A soft row
/// has none: its stretch is a force.
inline double residual_of(const JointAxis& axis, double c, double bound) {
  if (axis.compliance > 0.0 || axis.freedom == Freedom::Free) return 0.0;
  if (axis.freedom == Freedom::Locked) return c - bound;
  return c - std::clamp(c, std::min(axis.lower, bound), std::max(axis.upper, bound));
}

/// The same where nothing was kept: all that the row violates.
inline double residual_of(const JointAxis& axis, double c) {
  return residual_of(axis, c,
                     axis.freedom == Freedom::Locked ? 0.0 : std::clamp(c, axis.lower, axis.upper));
}

/// m or rad. Of what contacts leave of a row more than this is a gap and closes by displacement:
/// two capsules that overlap by 4 cm at first and hang on ball joints came to 24 J by closing it
/// with velocity.
inline constexpr double kLeft = 2e-3;

/// The residual of a row as a substep begins. What contacts, which are solved after joints, have
/// left of it is no violation that the next substep may take back, with the velocity of a whole
/// closing in a substep: joints and contacts would reflect where they should project, so that limbs
/// that lie on the ground tremble for ever, and those that fall on their end are thrown up.
/// @param left  by contacts, in the last substep of this step: between steps applications move
/// @param displaced  the displacement channel closes it
/// @param most  of it closes with velocity
inline double residual_at_start(const JointAxis& axis, double c, double residual, bool left,
                                bool displaced, double h, double most = kUnlimited) {
  if (left) residual = residual_of(axis, c);
  if (displaced) return residual;
  return residual - std::clamp(residual, -most, most) * (1.0 - residual_decay(h));
}

/// Of a joint that was added, or whose bodies were put, away from where it wants them: what it
/// violates closes by displacement, no faster than this. A blow of that size would be a hard one;
/// limbs that start outside their limits are back within half a second.
inline constexpr double kClosingSpeed = 5.0;  // m/s, of anchors
inline constexpr double kClosingSpin = 10.0;  // rad/s

/// What is left of a gap where a row has come to c that was to come to `bound`, and to leave
/// `rest`.
inline double gap_left(const JointAxis& axis, double c, double bound, double rest) {
  const double left = residual_of(axis, c, bound);
  if (axis.freedom != Freedom::Limited) return rest + left;
  // No more than what it violates, on the side on which it does.
  const double violated = residual_of(axis, c);
  const auto within = [&](double gap) {
    return std::clamp(gap, std::min(violated, 0.0), std::max(violated, 0.0));
  };
  return within(within(rest) + left);
}

/// The angle, up to whole turns, that lies within the limits: as near to `near` as it can be there,
/// and where no turn lies within, the one that is nearest to them.
inline double turn_within(double angle, double near, double lower, double upper) {
  constexpr double kTurn = 2.0 * std::numbers::pi;
  const double at = nearest_turn(angle, near);
  if (at >= lower && at <= upper) return at;
  // The last one below the range that it is outside of, and the first one above.
  const double stop = at < lower ? lower : upper;
  const double below = at + kTurn * std::floor((stop - at) / kTurn);
  const double above = below + kTurn;
  const auto beyond = [&](double t) { return std::max({0.0, lower - t, t - upper}); };
  return beyond(below) <= beyond(above) ? below : above;
}

/// How far c is beyond a rigid lock or limit, m or rad.
inline double violation(const JointAxis& axis, double c) {
  if (axis.compliance > 0.0 || axis.freedom == Freedom::Free) return 0.0;
  if (axis.freedom == Freedom::Locked) return std::abs(c);
  return std::max({0.0, axis.lower - c, c - axis.upper});
}

}  // namespace tandem::pbd
