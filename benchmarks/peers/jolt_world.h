// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

/// Jolt behind plain types. Users of Jolt must be compiled for its instruction set, with which
/// Eigen's types have another layout: so no file includes both.
namespace tandem::bench::jolt {

struct Vector {
  double x = 0.0, y = 0.0, z = 0.0;
};
struct Rotation {
  double x = 0.0, y = 0.0, z = 0.0, w = 1.0;
};

struct State {
  Vector position;  ///< m
  Rotation orientation;
  Vector linear, angular;  ///< m/s, rad/s
};

enum class Form { None, Box, Sphere, Capsule, Cylinder, Plane, Mesh, Hull };

struct Body {
  Form form = Form::None;
  Vector size;          ///< m: half extents of a box; normal of a plane
  double radius = 0.0;  ///< m: radius of a round shape; offset of a plane
  double half = 0.0;    ///< m: half length of a capsule's segment or of a cylinder, along z
  std::vector<Vector> vertices;  ///< of a mesh; of a hull
  std::vector<std::array<std::uint32_t, 3>> triangles;
  bool dynamic = true;
  bool collides = true;
  State start;
  double mass = 1.0;  ///< kg
  Vector inertia;     ///< kg m^2, principal
  double friction = 0.5, restitution = 0.0;
};

/// Hinge, or a ball joint with limits or friction; without those a free, frictionless one.
struct Joint {
  int a = -1;  ///< index of a body, -1: the world
  int b = 0;
  Vector point_w, axis_w;  ///< m; unit, of a hinge or of twist; at the bodies' present poses
  bool limited = false;    ///< rotation about the axis, to [lower, upper]
  double lower = 0.0, upper = 0.0;       ///< rad
  double cone = 3.14159265;              ///< rad, of a ball joint, to pi
  double friction = 0.0;                 ///< N m
  bool driven = false;                   ///< hinge: motor at the speed with at most this torque
  double speed = 0.0, max_torque = 0.0;  ///< rad/s, N m
};

/// Jolt's defaults unless set: one collision step, 10 velocity and 2 position steps.
struct Options {
  Vector gravity;
  std::size_t bodies = 0;  ///< number to be added
  int collision_steps = 1;
  int velocity_steps = 0;  ///< 0: the default
  bool sleeping = false;
};

class World {
 public:
  explicit World(const Options& options);
  ~World();
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  void add(const Body& body);
  /// @param a  index of a body, -1: the world
  void add_ball(int a, const Vector& anchor_a_l, int b, const Vector& anchor_b_l);
  void add_hinge(const Joint& joint);
  void add_swing_twist(const Joint& joint);
  /// Disables contacts between the two bodies.
  void set_apart(int a, int b);
  /// Call once, after adding everything.
  void ready();
  /// @throws std::runtime_error if Jolt's buffers were too small for all contacts
  void step(double dt);
  State state(int body) const;
  bool awake(int body) const;
  void set_pose(int body, const Vector& position, const Rotation& orientation);
  void set_twist(int body, const Vector& linear, const Vector& angular);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tandem::bench::jolt
