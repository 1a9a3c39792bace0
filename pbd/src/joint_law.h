// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "tandem/pbd/joint_def.h"

/// Force of a joint coordinate as a function of its value at the end of a substep.
namespace tandem::pbd {

/// A piece of a force law: (c - target) + at (lambda - offset) = 0, for multipliers low to high.
struct Segment {
  enum class Kind : std::uint8_t { None, Lock, Lower, Upper, Motor, Spring };
  Kind kind = Kind::None;  ///< None: lambda is kept
  double target = 0.0;     ///< m or rad
  double at = 0.0;         ///< compliance / h^2
  double offset = 0.0;     ///< N s^2 or N m s^2
  double low = -kUnlimited, high = kUnlimited;

  /// Residual of the row at a multiplier on this piece.
  double left(double c, double lambda) const { return -(c - target) - at * (lambda - offset); }
};

/// Multiplier as a function of the coordinate at the end of the substep: a decreasing graph of
/// linear pieces (spring and damper), steps (motor) and walls (lock, limits). The multipliers of a
/// part minimise the work of its joints, a convex sum with such a graph per row; no others take as
/// much energy (see joint_six_dof::gather()).
struct ForceLaw {
  bool locked = false;
  bool limited = false;
  double target = 0.0;  ///< locked: held value
  double at = 0.0;      ///< locked: compliance / h^2
  double lower = -kUnlimited, upper = kUnlimited;
  double stop_k = 0.0;  ///< h^2 / compliance + h damping of the stops; 0 = rigid
  double lower_target = 0.0, upper_target = 0.0;  ///< position of zero force of a soft stop
  double spring_k = 0.0;                          ///< h^2 stiffness + h damping; 0 = none
  double spring_target = 0.0;
  double servo_k = 0.0;  ///< the same for a servo; 0 = none
  double servo_target = 0.0;
  double servo_max = 0.0;  ///< h^2 max_force of the servo
  double motor_max = 0.0;  ///< h^2 max_force; 0 = none
  double motor_target = 0.0;
  bool powered = false;  ///< the motor or spring can do work

  /// Whether the multiplier alone does not determine the piece: it is at the bound of a motor or
  /// brake, or a limit has none.
  bool is_corner(double lambda) const {
    return !locked && spring_k == 0.0 && std::abs(lambda) == motor_max + servo_max;
  }
  /// The multiplier on the graph nearest to one of another substep. Snaps to corners, which a
  /// different substep length may have rounded.
  double nearest(double lambda) const {
    constexpr double kRounding = 1e-12;  // of the multiplier
    if (locked || spring_k > 0.0) return lambda;
    const double most = motor_max + servo_max;
    const double size = std::abs(lambda);
    const bool beyond = limited && size > most * (1.0 + kRounding);
    return beyond || size < most * (1.0 - kRounding) ? lambda : std::copysign(most, lambda);
  }
  /// The piece of the graph at lambda; at a corner, the one towards c.
  Segment segment(double c, double lambda) const {
    using Kind = Segment::Kind;
    if (locked) return {Kind::Lock, target, at};
    const auto before = [&](double c_corner, double corner) {
      return lambda == corner ? c < c_corner : lambda > corner;
    };
    const auto stop = [&](Kind kind, double at_stop, double push, double low, double high) {
      if (stop_k == 0.0) return Segment{kind, at_stop, 0.0, 0.0, low, high};
      const double k = spring_k + stop_k;
      const Segment straight{
          kind, (spring_k * spring_target + stop_k * at_stop) / k, 1.0 / k, push, low, high};
      return servo_k > 0.0 ? bent(straight, c, lambda) : straight;
    };
    double push = motor_max;
    double high = kUnlimited;
    if (limited) {
      high = soft(lower) + push;
      if (before(lower, high)) return stop(Kind::Lower, lower_target, push, high, kUnlimited);
    }
    double low = -kUnlimited;
    bool found = false;
    if (motor_max > 0.0) {
      const double force = soft(motor_target);
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
      low = soft(upper) + push;
      if (lambda == low ? c > upper : lambda < low) {
        return stop(Kind::Upper, upper_target, push, -kUnlimited, low);
      }
    }
    if (servo_k > 0.0) {
      const double at_spring = spring_k > 0.0 ? 1.0 / spring_k : kUnlimited;
      return bent({Kind::Spring, spring_target, at_spring, push, low, high}, c, lambda);
    }
    if (spring_k > 0.0) return {Kind::Spring, spring_target, 1.0 / spring_k, push, low, high};
    return {};
  }

  /// The coordinate at a multiplier, with a spring or armature: its graph then has one.
  double coordinate(double lambda) const {
    const Segment s = segment(0.0, lambda);
    return s.target - s.at * (lambda - s.offset);
  }
  /// The change of the multiplier that a row alone asks for: along the graph, which has at most
  /// five pieces, and two more with a servo.
  double multiplier(double c, double lambda, double w) const {
    const double before = lambda;
    for (int piece = 0; piece < 7; ++piece) {
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

 private:
  /// Multiplier of spring and servo at c.
  double soft(double c) const {
    const double spring = spring_k > 0.0 ? -spring_k * (c - spring_target) : 0.0;
    if (servo_k == 0.0) return spring;
    return spring + std::clamp(-servo_k * (c - servo_target), -servo_max, servo_max);
  }
  /// Adds the servo to a piece: steeper while the servo is within its bound, else shifted. A piece
  /// of infinite compliance is the servo alone.
  Segment bent(Segment piece, double c, double lambda) const {
    const double k = piece.at < kUnlimited ? 1.0 / piece.at : 0.0;
    const auto corner = [&](double c_at, double most) {
      return (k > 0.0 ? -k * (c_at - piece.target) : 0.0) + piece.offset + most;
    };
    const double reach = servo_max / servo_k;
    const double first = corner(servo_target - reach, servo_max);
    const double last = corner(servo_target + reach, -servo_max);
    if (lambda == first ? c < servo_target - reach : lambda > first) {
      piece.offset += servo_max;
      piece.low = std::max(piece.low, first);
    } else if (lambda == last ? c > servo_target + reach : lambda < last) {
      piece.offset -= servo_max;
      piece.high = std::min(piece.high, last);
    } else {
      piece.target = (k * piece.target + servo_k * servo_target) / (k + servo_k);
      piece.at = 1.0 / (k + servo_k);
      piece.low = std::max(piece.low, last);
      piece.high = std::min(piece.high, first);
      return piece;
    }
    return k > 0.0 ? piece : Segment{};
  }
};

/// Whether a spring or motor can do work; a motor with target speed 0 is a brake.
inline bool is_powered(const JointAxis& axis) {
  const JointMotor& motor = axis.motor;
  return axis.spring.stiffness > 0.0 || axis.spring.frequency > 0.0 ||
         motor.mode == MotorMode::Position ||
         (motor.mode == MotorMode::Velocity && motor.target != 0.0);
}

/// Adds a servo and dry friction.
inline void add_servo(ForceLaw& law, const JointAxis& axis, double c_start, double h) {
  const JointMotor& motor = axis.motor;
  const double pull = h * h * motor.stiffness;
  const double brake = h * motor.damping;
  const bool to_speed = motor.mode == MotorMode::Velocity;
  const double k = pull + brake;
  const double target =
      to_speed ? c_start + h * motor.target : (pull * motor.target + brake * c_start) / k;
  law.servo_k = k;
  law.servo_target = target;
  law.servo_max = h * h * motor.max_force;
  law.motor_max = h * h * axis.friction;
  law.motor_target = std::clamp(c_start, law.lower, law.upper);
}

/// Sets the law of an axis in the real channel, in place: copied, a law of single numbers is read
/// in pairs, which the processor cannot forward (a tenth of the time of doors).
/// @param c_start   coordinate at the start of the substep
/// @param residual  left by agreement
inline void set_force_law(ForceLaw& law, const JointAxis& axis, double c_start, double residual,
                          double h) {
  law = {};
  const double h2 = h * h;
  const bool rigid = axis.compliance == 0.0;
  const double k = rigid ? 0.0 : h2 / axis.compliance + h * axis.damping;
  // Rest position of a spring with that damping: the damper pulls to the start.
  const auto soft = [&](double rest) {
    return (h2 / axis.compliance * rest + h * axis.damping * c_start) / k;
  };
  if (axis.freedom == Freedom::Locked) {
    law.locked = true;
    law.target = (rigid ? 0.0 : soft(0.0)) + residual;
    law.at = rigid ? 0.0 : 1.0 / k;
    return;
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
  if (axis.motor.is_servo()) {
    add_servo(law, axis, c_start, h);
  } else if (axis.motor.mode != MotorMode::Off) {
    law.motor_max = h2 * axis.motor.max_force;
    double move = h * axis.motor.target;
    if (axis.motor.mode == MotorMode::Position) {
      const double reach = h * axis.motor.max_speed;
      move = std::clamp(axis.motor.target - c_start, -reach, reach);
    }
    // A limit is stronger than any motor: the motor never aims beyond it.
    law.motor_target = std::clamp(c_start + move, law.lower, law.upper);
  }
  law.powered = is_powered(axis);
}

/// Adds a rotor's inertia, in the real channel: a force in proportion to the difference from the
/// value to which the rotor goes on without one.
inline void add_armature(ForceLaw& law, double armature, double ahead) {
  const double k = law.spring_k + armature;
  law.spring_target = (law.spring_k * law.spring_target + armature * ahead) / k;
  law.spring_k = k;
  law.powered = true;
}

inline ForceLaw force_law(const JointAxis& axis, double c_start, double residual, double h) {
  ForceLaw law;
  set_force_law(law, axis, c_start, residual, h);
  return law;
}

/// Law in the displacement channel: keep `bound`, the real channel's value, exactly. Springs
/// resist; motors do if they could hold against anything.
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
  if (axis.motor.is_servo()) {
    if (axis.motor.max_force == kUnlimited) law.spring_k += h * h * axis.motor.stiffness;
  } else if (axis.motor.mode != MotorMode::Off && axis.motor.max_force == kUnlimited) {
    law.motor_max = kUnlimited;
    law.motor_target = bound;
  }
  return law;
}

}  // namespace tandem::pbd
