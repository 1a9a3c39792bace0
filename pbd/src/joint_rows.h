// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "tandem/pbd/corrections.h"
#include "tandem/pbd/joint_def.h"
#include "tandem/pbd/portable.h"

/// The coordinates of a joint, their gradients and their force laws.
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

/// A piece of a force law: (c - target) + at (lambda - offset) = 0, for multipliers low to high.
struct Segment {
  enum class Kind : std::uint8_t { None, Lock, Lower, Upper, Motor, Spring };
  Kind kind = Kind::None;  ///< None: lambda stays what it is
  double target = 0.0;     ///< m or rad
  double at = 0.0;         ///< compliance / h^2
  double offset = 0.0;     ///< N s^2 or N m s^2
  double low = -kUnlimited, high = kUnlimited;

  /// What a multiplier on it leaves of the row.
  double left(double c, double lambda) const { return -(c - target) - at * (lambda - offset); }
};

/// Multiplier as a function of the coordinate at the end of the substep: a decreasing graph of
/// straight pieces (spring and damper), steps (motor) and walls (lock, limits). The multipliers of
/// a part are the ones that minimise what its joints do, a convex sum with such a graph for each
/// row: no other ones take as much energy (see joint_six_dof::gather()).
struct ForceLaw {
  bool locked = false;
  bool limited = false;
  double target = 0.0;  ///< locked: where
  double at = 0.0;      ///< locked: compliance / h^2
  double lower = -kUnlimited, upper = kUnlimited;
  double stop_k = 0.0;  ///< h^2 / compliance + h damping of the stops; 0 = rigid
  double lower_target = 0.0, upper_target = 0.0;  ///< where a soft stop's force is 0
  double spring_k = 0.0;                          ///< h^2 stiffness + h damping; 0 = none
  double spring_target = 0.0;
  double motor_max = 0.0;  ///< h^2 max_force; 0 = none
  double motor_target = 0.0;
  bool powered = false;  ///< the motor or spring can do work

  /// Whether a multiplier alone does not tell the piece: it is at the bound of a motor or brake, or
  /// a limit has none.
  bool is_corner(double lambda) const {
    return !locked && spring_k == 0.0 && std::abs(lambda) == motor_max;
  }
  /// The multiplier on the graph that is nearest to one of another substep; corners, which its
  /// length may have rounded, are hit.
  double nearest(double lambda) const {
    constexpr double kRounding = 1e-12;  // of the multiplier
    if (locked || spring_k > 0.0) return lambda;
    const double size = std::abs(lambda);
    const bool beyond = limited && size > motor_max * (1.0 + kRounding);
    return beyond || size < motor_max * (1.0 - kRounding) ? lambda
                                                          : std::copysign(motor_max, lambda);
  }
  /// The piece of the graph that lambda lies on; at a corner, the one that leads towards c.
  Segment segment(double c, double lambda) const {
    using Kind = Segment::Kind;
    if (locked) return {Kind::Lock, target, at};
    const auto spring = [&](double c_at) {
      return spring_k > 0.0 ? -spring_k * (c_at - spring_target) : 0.0;
    };
    const auto before = [&](double c_corner, double corner) {
      return lambda == corner ? c < c_corner : lambda > corner;
    };
    const auto stop = [&](Kind kind, double at_stop, double push) -> Segment {
      if (stop_k == 0.0) return {kind, at_stop};
      const double k = spring_k + stop_k;
      return {kind, (spring_k * spring_target + stop_k * at_stop) / k, 1.0 / k, push};
    };
    double push = motor_max;
    double high = kUnlimited;
    if (limited) {
      high = spring(lower) + push;
      if (before(lower, high)) {
        Segment s = stop(Kind::Lower, lower_target, push);
        s.low = high;
        return s;
      }
    }
    double low = -kUnlimited;
    bool found = false;
    if (motor_max > 0.0) {
      const double force = spring(motor_target);
      if (before(motor_target, force + motor_max)) {
        low = force + motor_max;
        found = true;
      } else if (before(motor_target, force - motor_max)) {
        return {Kind::Motor, motor_target, 0.0, 0.0, force - motor_max, force + motor_max};
      } else {
        push = -motor_max;
        high = force - motor_max;
      }
    }
    if (!found && limited) {
      low = spring(upper) + push;
      if (lambda == low ? c > upper : lambda < low) {
        Segment s = stop(Kind::Upper, upper_target, push);
        s.high = low;
        return s;
      }
    }
    if (spring_k > 0.0) return {Kind::Spring, spring_target, 1.0 / spring_k, push, low, high};
    return {};
  }

  /// The change of the multiplier that a row by itself calls for: along the graph, which has five
  /// pieces at most.
  double multiplier(double c, double lambda, double w) const {
    const double before = lambda;
    for (int piece = 0; piece < 5; ++piece) {
      const Segment s = segment(c, lambda);
      if (s.kind == Segment::Kind::None || w + s.at <= 0.0) break;
      const double wanted = lambda + s.left(c, lambda) / (w + s.at);
      const double next = std::clamp(wanted, s.low, s.high);
      c += w * (next - lambda);
      lambda = next;
      if (next == wanted) break;
    }
    return lambda - before;
  }
};

/// Whether a spring or motor can do work; a motor that is to stand still is a brake.
inline bool is_powered(const JointAxis& axis) {
  const JointMotor& motor = axis.motor;
  return axis.spring.stiffness > 0.0 || axis.spring.frequency > 0.0 ||
         motor.mode == MotorMode::Position ||
         (motor.mode == MotorMode::Velocity && motor.target != 0.0);
}

/// The law of an axis in the real channel.
/// @param c_start   coordinate at the start of the substep
/// @param residual  what agreement left
inline ForceLaw force_law(const JointAxis& axis, double c_start, double residual, double h) {
  ForceLaw law;
  const double h2 = h * h;
  const bool rigid = axis.compliance == 0.0;
  const double k = rigid ? 0.0 : h2 / axis.compliance + h * axis.damping;
  // Where a spring to `rest` with that damping pulls to: the damper holds on to the start.
  const auto soft = [&](double rest) {
    return (h2 / axis.compliance * rest + h * axis.damping * c_start) / k;
  };
  if (axis.freedom == Freedom::Locked) {
    law.locked = true;
    law.target = (rigid ? 0.0 : soft(0.0)) + residual;
    law.at = rigid ? 0.0 : 1.0 / k;
    return law;
  }
  if (axis.freedom == Freedom::Limited) {
    law.limited = true;
    law.lower = axis.lower + std::min(residual, 0.0);
    law.upper = axis.upper + std::max(residual, 0.0);
    law.stop_k = k;
    law.lower_target = rigid ? law.lower : soft(law.lower);
    law.upper_target = rigid ? law.upper : soft(law.upper);
  }
  law.spring_k = h2 * axis.spring.stiffness + h * axis.spring.damping;
  if (law.spring_k > 0.0) {
    law.spring_target =
        (h2 * axis.spring.stiffness * axis.spring.rest + h * axis.spring.damping * c_start) /
        law.spring_k;
  }
  if (axis.motor.mode != MotorMode::Off) {
    law.motor_max = h2 * axis.motor.max_force;
    double move = h * axis.motor.target;
    if (axis.motor.mode == MotorMode::Position) {
      const double reach = h * axis.motor.max_speed;
      move = std::clamp(axis.motor.target - c_start, -reach, reach);
    }
    // A limit is stronger than any motor: it never aims beyond.
    law.motor_target = std::clamp(c_start + move, law.lower, law.upper);
  }
  law.powered = is_powered(axis);
  return law;
}

/// The same for the displacement channel: keep `bound`, what Real has, no more and no less.
/// Springs resist; motors do where they could hold against anything.
inline ForceLaw displacement_law(const JointAxis& axis, double bound, double h) {
  ForceLaw law;
  if (axis.freedom == Freedom::Locked) {
    law.locked = true;
    law.target = bound;
    law.at = axis.compliance / (h * h);
    return law;
  }
  if (axis.freedom == Freedom::Limited && axis.compliance == 0.0) {
    law.limited = true;
    law.lower = law.lower_target = std::min(axis.lower, bound);
    law.upper = law.upper_target = std::max(axis.upper, bound);
  }
  law.spring_k = h * h * axis.spring.stiffness;
  law.spring_target = bound;
  if (axis.motor.mode != MotorMode::Off && axis.motor.max_force == kUnlimited) {
    law.motor_max = kUnlimited;
    law.motor_target = bound;
  }
  return law;
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

/// Whether the displacement channel closes what a joint violates, and whether contacts hold it.
struct Displaced {
  bool any = false;
  bool held = false;

  Displaced(const SolverBody& a, const SolverBody& b)
      : any(a.shared || b.shared), held(a.held || b.held) {}
};

/// The residual of a row that contacts, which are solved after joints, may have opened. What they
/// left is no violation that the next substep may take back, with the velocity of a whole closing
/// in a substep: joints and contacts would reflect where they should project, so that limbs that
/// lie on the ground tremble for ever, and those that fall on their end are thrown up. Where
/// agreement is about, which closes all residuals without velocity, only blows are left: tyres
/// would not feel it, and a car go round too large a circle.
inline double residual_left(const JointAxis& axis, double c, double residual, bool held, double h) {
  constexpr double kBlow = 0.3;  // m/s
  const double left = residual_of(axis, c);
  return held && std::abs(left - residual) <= kBlow * h ? residual : left;
}
/// The same as a substep begins.
/// @param most  of it closes with velocity
/// @param left  by contacts, in the last substep of this step: between steps applications move
inline double residual_at_start(const JointAxis& axis, double c, double residual, bool left,
                                Displaced displaced, double h, double most = kUnlimited) {
  if (left) residual = residual_left(axis, c, residual, displaced.held, h);
  if (displaced.any) return residual;
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
