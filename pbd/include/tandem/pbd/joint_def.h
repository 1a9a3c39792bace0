// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <limits>
#include <numbers>

#include "tandem/pbd/body.h"
#include "tandem/pbd/export.h"

namespace tandem::pbd {

class World;

/// No bound on a force, speed or angle.
inline constexpr double kUnlimited = std::numeric_limits<double>::infinity();
/// Compliances are 0 (rigid) or at least this: their inverse is a stiffness.
inline constexpr double kMinCompliance = 1e-100;

/// A point and three axes of a body. Hinges turn about x, sliders move along x, and twist is the
/// rotation about x.
struct TANDEM_API JointFrame {
  Vec3 anchor = Vec3::Zero();     ///< m, frame of the body (world frame for the world)
  Quat basis = Quat::Identity();  ///< axes to the frame of the body
};

enum class Freedom : std::uint8_t { Free, Locked, Limited };
enum class MotorMode : std::uint8_t { Off, Velocity, Position };

/// Pulls a coordinate to `rest`. Units: N/m, m, N s/m for displacements; N m/rad, rad, N m s/rad.
///
/// Given by stiffness and damping, or by frequency and damping ratio. The latter are converted with
/// the inertia of the coordinate at the time the joint is added or set: the reduced mass for a
/// slider, the inertia about its hinge for a door. Such a spring follows its closed form if a
/// substep is at most a twelfth of its period; a faster one is braked.
struct TANDEM_API JointSpring {
  double stiffness = 0.0;  ///< >= 0; 0 = no spring
  double rest = 0.0;
  double damping = 0.0;    ///< >= 0; works without stiffness, too
  double frequency = 0.0;  ///< Hz, >= 0, undamped; above 0, it and damping_ratio define the spring
  double damping_ratio = 0.0;  ///< >= 0; 1 = critical: no overshoot
};

/// Drives a coordinate with as much force as it needs, up to max_force. A limit is stronger than
/// any motor.
///
/// With a stiffness or damping it is a compliant servo. Its force, cut at max_force, is
/// stiffness (target - position) - damping speed (Position), or damping (target - speed)
/// (Velocity). A spring and dry friction act in addition.
struct TANDEM_API JointMotor {
  MotorMode mode = MotorMode::Off;
  double target = 0.0;            ///< m/s or rad/s (Velocity), m or rad (Position)
  double max_force = kUnlimited;  ///< N or N m, > 0
  double max_speed = kUnlimited;  ///< m/s or rad/s, > 0: on the way to a position, not of servos
  double stiffness = 0.0;         ///< N/m or N m/rad, >= 0: of a position servo
  double damping = 0.0;           ///< N s/m or N m s/rad, >= 0: of a servo

  bool is_servo() const { return mode != MotorMode::Off && (stiffness > 0.0 || damping > 0.0); }
};

/// One coordinate. Compliance (m/N or rad/(N m)) and damping (N s/m or N m s/rad) belong to the
/// lock or the stops, and are 0 where there are none. Compliance 0 is rigid, and damping has no
/// effect on a rigid row. A free coordinate is damped by `spring.damping`.
struct TANDEM_API JointAxis {
  Freedom freedom = Freedom::Free;
  double lower = 0.0;  ///< m or rad, where Limited; <= upper
  double upper = 0.0;
  double compliance = 0.0;
  double damping = 0.0;
  JointSpring spring = {};  ///< none where Locked
  JointMotor motor = {};    ///< none where Locked
  /// N or N m, >= 0, none where Locked: dry friction, the largest force that resists motion. A
  /// motor that is on replaces it, unless it is a servo.
  double friction = 0.0;
  /// kg or kg m^2, >= 0, none where Locked: inertia of the coordinate alone, as of a motor behind a
  /// gear. Contacts do not feel it, World::set_twist() does not move it, and
  /// World::kinetic_energy() does not count it.
  double armature = 0.0;
};

/// Turns frame b within frame a about all three axes at once; none of them may be locked. Torques
/// are about the axes of frame a, whatever twist and swing are, at any angle.
struct TANDEM_API BallDrive {
  struct TANDEM_API Spring {
    double stiffness = 0.0;  ///< N m/rad, >= 0
    double damping = 0.0;    ///< N m s/rad, >= 0; works without stiffness, too
    /// As in JointSpring: exact about axes of frame a that are principal axes of the bodies.
    double frequency = 0.0;  ///< Hz, >= 0
    double damping_ratio = 0.0;
    Quat rest = Quat::Identity();  ///< frame b to frame a; pulls the shorter way
  };
  struct TANDEM_API Motor {
    MotorMode mode = MotorMode::Off;
    Vec3 velocity = Vec3::Zero();    ///< rad/s, of b against a, axes of frame a (Velocity)
    Quat target = Quat::Identity();  ///< frame b to frame a, the shorter way (Position)
    double max_torque = kUnlimited;  ///< N m, > 0
    double max_speed = kUnlimited;   ///< rad/s, > 0: on the way to a target
  };
  Spring spring = {};
  Motor motor = {};
  double friction = 0.0;  ///< N m, >= 0; replaced by a motor that is on
  double armature = 0.0;  ///< kg m^2, >= 0, about each axis; see JointAxis::armature
};

/// The general joint; the others are short forms of it. Body b moves in the frame of body a.
struct TANDEM_API SixDofJointDef {
  BodyId a = {};  ///< the invalid id stands for the world
  BodyId b = {};
  JointFrame frame_a = {}, frame_b = {};
  std::array<JointAxis, 3> linear = {};   ///< along the axes of frame a
  std::array<JointAxis, 3> angular = {};  ///< twist about x, swing about y, swing about z
  /// rad, > 0: largest angle between the x axes; used instead of limits on the two swings.
  double cone = kUnlimited;
  double cone_compliance = 0.0;  ///< rad/(N m), >= 0
  double cone_damping = 0.0;     ///< N m s/rad, >= 0; without effect where the cone is rigid
  BallDrive drive = {};          ///< used instead of springs, motors and friction of angular axes
  double break_force = 0.0;      ///< N, >= 0; a larger force disables the joint; 0 = never
  double break_torque = 0.0;     ///< N m, >= 0; a larger torque disables the joint; 0 = never
  /// rad: the joint is added on the turn that lies within its limits; if there are several, on the
  /// one nearest to this.
  double start = 0.0;
  bool enabled = true;
  /// Whether the bodies have contacts with each other while the joint holds them. A disabled or
  /// broken joint prevents no contacts.
  bool collide_connected = true;
};

// Short forms. Their first fields are the same in all; compliances and dampings belong to the
// coordinates that the joint locks or stops.

/// Fixes b to a: no freedom.
struct TANDEM_API FixedJointDef {
  BodyId a = {}, b = {};  ///< see SixDofJointDef
  JointFrame frame_a = {}, frame_b = {};
  double compliance = 0.0;          ///< m/N
  double damping = 0.0;             ///< N s/m
  double angular_compliance = 0.0;  ///< rad/(N m)
  double angular_damping = 0.0;     ///< N m s/rad
  double break_force = 0.0;         ///< N
  double break_torque = 0.0;        ///< N m
  bool collide_connected = true;    ///< see SixDofJointDef
  operator SixDofJointDef() const;  // NOLINT(google-explicit-constructor): a short form of it
};

/// Holds a point of b at a point of a.
struct TANDEM_API BallJointDef {
  BodyId a = {}, b = {};  ///< see SixDofJointDef
  JointFrame frame_a = {}, frame_b = {};
  double compliance = 0.0;          ///< m/N
  double damping = 0.0;             ///< N s/m
  double angular_compliance = 0.0;  ///< rad/(N m)
  double angular_damping = 0.0;     ///< N m s/rad
  double break_force = 0.0;         ///< N
  double break_torque = 0.0;        ///< N m
  double cone = kUnlimited;         ///< rad, largest swing of the x axis
  bool limit_twist = false;         ///< limit twist to lower_twist .. upper_twist
  double lower_twist = 0.0;         ///< rad
  double upper_twist = 0.0;         ///< rad
  BallDrive drive = {};             ///< motor, spring and friction of the ball
  bool collide_connected = true;    ///< see SixDofJointDef
  operator SixDofJointDef() const;  // NOLINT(google-explicit-constructor)
};

/// Lets b turn about the x axis of a. Limits, spring and motor are those of `axis`.
struct TANDEM_API HingeJointDef {
  BodyId a = {}, b = {};  ///< see SixDofJointDef
  JointFrame frame_a = {}, frame_b = {};
  double compliance = 0.0;          ///< m/N
  double damping = 0.0;             ///< N s/m
  double angular_compliance = 0.0;  ///< rad/(N m)
  double angular_damping = 0.0;     ///< N m s/rad
  double break_force = 0.0;         ///< N
  double break_torque = 0.0;        ///< N m
  JointAxis axis = {};              ///< rad, N m
  double start = 0.0;               ///< rad, see SixDofJointDef
  bool collide_connected = true;    ///< see SixDofJointDef
  operator SixDofJointDef() const;  // NOLINT(google-explicit-constructor)
};

/// Lets b move along the x axis of a, without turning. Limits, spring and motor are those of
/// `axis`.
struct TANDEM_API SliderJointDef {
  BodyId a = {}, b = {};  ///< see SixDofJointDef
  JointFrame frame_a = {}, frame_b = {};
  double compliance = 0.0;          ///< m/N
  double damping = 0.0;             ///< N s/m
  double angular_compliance = 0.0;  ///< rad/(N m)
  double angular_damping = 0.0;     ///< N m s/rad
  double break_force = 0.0;         ///< N
  double break_torque = 0.0;        ///< N m
  JointAxis axis = {};              ///< m, N
  bool collide_connected = true;    ///< see SixDofJointDef
  operator SixDofJointDef() const;  // NOLINT(google-explicit-constructor)
};

/// Holds a wheel b under a chassis a. The wheel turns about x, the axle, and moves along z, the
/// direction of its suspension. Steering turns the axle about z: JointBlock::set() with another
/// angle.
struct TANDEM_API WheelJointDef {
  BodyId a = {}, b = {};  ///< see SixDofJointDef
  JointFrame frame_a = {}, frame_b = {};
  double compliance = 0.0;          ///< m/N
  double damping = 0.0;             ///< N s/m
  double angular_compliance = 0.0;  ///< rad/(N m)
  double angular_damping = 0.0;     ///< N m s/rad
  double break_force = 0.0;         ///< N
  double break_torque = 0.0;        ///< N m
  JointAxis suspension = {};        ///< m, N: spring and stops along z, positive when compressed
  double steer = 0.0;               ///< rad, about z
  JointMotor drive = {};            ///< axle motor, rad/s, N m
  double brake = 0.0;  ///< N m, >= 0: above 0 it brakes the axle and switches the drive off
  bool collide_connected = true;    ///< see SixDofJointDef
  operator SixDofJointDef() const;  // NOLINT(google-explicit-constructor)
};

/// Frames at the world point `anchor_w` (m) with x along `axis_w` (longer than 1e-9); all
/// coordinates are 0 at the current poses. They throw std::invalid_argument on a bad body or axis.
TANDEM_API SixDofJointDef six_dof_joint_at(const World& world, BodyId a, BodyId b,
                                           const Vec3& anchor_w,
                                           const Vec3& axis_w = Vec3::UnitX());
TANDEM_API FixedJointDef fixed_joint_at(const World& world, BodyId a, BodyId b,
                                        const Vec3& anchor_w);
TANDEM_API BallJointDef ball_joint_at(const World& world, BodyId a, BodyId b, const Vec3& anchor_w,
                                      const Vec3& twist_axis_w = Vec3::UnitX());
TANDEM_API HingeJointDef hinge_joint_at(const World& world, BodyId a, BodyId b,
                                        const Vec3& anchor_w, const Vec3& axis_w);
TANDEM_API SliderJointDef slider_joint_at(const World& world, BodyId a, BodyId b,
                                          const Vec3& anchor_w, const Vec3& axis_w);
/// @param up_w  direction of the suspension: z is its part perpendicular to the axle, longer than
///   1e-9
TANDEM_API WheelJointDef wheel_joint_at(const World& world, BodyId chassis, BodyId wheel,
                                        const Vec3& anchor_w, const Vec3& axle_w, const Vec3& up_w);

/// @throws std::invalid_argument naming the field, its value and the rule
TANDEM_API void check_joint(const World& world, const SixDofJointDef& def);

}  // namespace tandem::pbd
