// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

/// Jolt behind plain types. Who uses Jolt has to be compiled for the instruction set that Jolt was
/// built for, where Eigen's types have another layout: so no file includes both.
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
  double radius = 0.0;  ///< m: of what is round; offset of a plane
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

/// Hinge, or a ball joint with limits or friction; without them it has no friction and turns
/// freely.
struct Joint {
  int a = -1;  ///< index of a body, -1: the world
  int b = 0;
  Vector point_w, axis_w;           ///< m; unit, of a hinge or of twist; as the bodies stand now
  bool limited = false;             ///< what turns or twists about the axis, to [lower, upper]
  double lower = 0.0, upper = 0.0;  ///< rad
  double cone = 3.14159265;         ///< rad, of a ball joint, to pi
  double friction = 0.0;            ///< N m
  bool driven = false;              ///< a hinge, at the speed with at most this torque
  double speed = 0.0, max_torque = 0.0;  ///< rad/s, N m
};

/// Jolt's defaults where nothing is given: one collision step, 10 velocity and 2 position steps.
struct Options {
  Vector gravity;
  std::size_t bodies = 0;  ///< that will be added
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
  /// The two bodies pass through each other.
  void set_apart(int a, int b);
  /// To be called once, when all has been added.
  void ready();
  /// @throws std::runtime_error where Jolt's buffers were too small for all contacts
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
