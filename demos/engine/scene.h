// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "tandem/pbd/body.h"
#include "tandem/pbd/types.h"

/// Scenes as plain data, the same for each engine.
namespace tandem::bench {

using pbd::BodyType;
using pbd::Pose;
using pbd::Quat;
using pbd::Twist;
using pbd::Vec3;

struct BoxShape {
  Vec3 half_extents = Vec3::Constant(0.5);  ///< m
};
struct SphereShape {
  double radius = 0.5;  ///< m
};
/// All points within `radius` of the segment of half length `half_height` along z.
struct CapsuleShape {
  double radius = 0.25;      ///< m
  double half_height = 0.5;  ///< m
};
/// Its axis is z.
struct CylinderShape {
  double radius = 0.5;       ///< m
  double half_height = 0.5;  ///< m
};
/// Solid behind the plane normal . x = offset.
struct PlaneShape {
  Vec3 normal = Vec3::UnitZ();
  double offset = 0.0;  ///< m
};
/// A surface, counter-clockwise in front.
struct MeshData {
  std::vector<Vec3> vertices;  ///< m
  std::vector<std::array<std::uint32_t, 3>> triangles;
};
using MeshShape = std::shared_ptr<const MeshData>;
/// Corners of a convex solid, m; its centre of mass is at the origin.
using HullShape = std::shared_ptr<const std::vector<Vec3>>;
struct NoShape {};

using SceneShape = std::variant<NoShape, BoxShape, SphereShape, CapsuleShape, CylinderShape,
                                PlaneShape, MeshShape, HullShape>;

struct SceneBody {
  SceneShape shape;
  BodyType type = BodyType::Dynamic;
  Pose pose;
  Twist twist;
  double mass = 1.0;            ///< kg
  Vec3 inertia = Vec3::Zero();  ///< kg m^2, principal, along the axes of the body frame
  double friction = 0.5;        ///< a pair of equal bodies has the same value
  double restitution = 0.0;     ///< a pair has the larger value
  bool collides = true;         ///< false: has a size but no contacts
  bool limb = false;  ///< of a ragdoll, for engines with special sleep thresholds for ragdolls
};

enum class JointKind {
  Ball,
  Distance,  ///< rod or spring between the anchors
  Hinge,     ///< turns about `axis`
  Slider,    ///< moves along `axis`, does not turn
};

/// Anchors and axis coincide at the start, except for the distance joint.
struct SceneJoint {
  JointKind kind = JointKind::Ball;
  int a = -1;                      ///< index into the bodies, -1 = the world
  int b = 0;                       ///< index into the bodies
  Vec3 anchor_a_l = Vec3::Zero();  ///< m, frame of a (of the world for -1)
  Vec3 anchor_b_l = Vec3::Zero();  ///< m, frame of b
  double compliance = 0.0;         ///< m/N; ball and distance
  double damping = 0.0;            ///< N s/m; ball and distance
  double rest_length = 0.0;        ///< m; distance
  /// World, at the start pose; hinge, slider, and twist of a ball.
  Vec3 axis_w = Vec3::UnitX();
  bool limited = false;  ///< hinge and twist: to [lower, upper], 0 at the start
  double lower = 0.0;    ///< rad
  double upper = 0.0;    ///< rad
  bool driven = false;   ///< hinge: at the speed
  double speed = 0.0;    ///< rad/s
  double max_torque = std::numeric_limits<double>::infinity();  ///< N m, of the drive
  double cone = std::numeric_limits<double>::infinity();  ///< rad, ball: largest swing of the axis
  double friction = 0.0;                                  ///< N m, ball and hinge: dry
  bool touch = true;                                      ///< its bodies collide with each other
};

struct Scene {
  std::string name;
  Vec3 gravity = Vec3(0.0, 0.0, -9.81);  ///< m/s^2
  double dt = 1.0 / 60.0;                ///< s, one frame
  double seconds = 10.0;
  std::vector<SceneBody> bodies;
  std::vector<SceneJoint> joints;
  std::vector<std::pair<int, int>> apart;  ///< pairs without contacts, besides those on joints

  /// Adds a body of the shape with its analytic inertia; returns its index.
  int add(const SceneShape& shape, double mass, const Pose& pose);
  int add_static(const SceneShape& shape, const Pose& pose = {});
  /// Adds a joint at the world point `anchor_w` with the bodies as placed now.
  SceneJoint& add_joint(JointKind kind, int a, int b, const Vec3& anchor_w);
  void add_ball(int a, int b, const Vec3& anchor_w) { add_joint(JointKind::Ball, a, b, anchor_w); }
  int frames() const;
  /// True without cones, limits of twist, friction, bounded drives and pairs in `apart`.
  bool has_simple_joints() const;
};

/// Principal moments (kg m^2) of the homogeneous shape; those of a ball of radius 1 m for NoShape;
/// zero for planes, meshes and hulls.
Vec3 principal_inertia(const SceneShape& shape, double mass);

/// The seven scenes of the comparison between engines. cliff: 1000 balls over a step of 8192
/// triangles; stacks: ten of ten cubes; katamari: 900 cubes and a large one; chain: 50 links and a
/// ball of 1000 times their mass; heap: 8000 boxes between walls; ratio: five cubes, each ten times
/// heavier than the one below; pyramid: 120 cubes.
inline constexpr std::array<std::string_view, 7> kPeerScenes{"cliff", "stacks", "katamari", "chain",
                                                             "heap",  "ratio",  "pyramid"};
/// Two of Box3D's benchmark scenes: a pyramid of 100 rows of cubes, and 196 pyramids of ten rows.
inline constexpr std::array<std::string_view, 2> kLargeScenes{"large_pyramid", "many_pyramids"};

/// @throws std::invalid_argument if no scene has that name
Scene peer_scene(std::string_view name);

/// Height (m) of the cliff scene's surface, by formula.
double cliff_height(double x, double y);

}  // namespace tandem::bench
