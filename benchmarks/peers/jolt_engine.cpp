// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Jolt with its defaults (one collision step, 10 velocity and 2 position steps, Baumgarte 0.2,
// penetration slop 20 mm, boxes rounded by 50 mm, body pair cache), one thread. Like all engines
// here undamped, and never asleep unless asked.
#include <cmath>
#include <stdexcept>

#include "demos/engine/engine.h"
#include "peers/jolt_world.h"

namespace tandem::bench {
namespace {

jolt::Vector plain(const Vec3& v) { return {v.x(), v.y(), v.z()}; }
jolt::Rotation plain(const Quat& q) { return {q.x(), q.y(), q.z(), q.w()}; }
Vec3 from(const jolt::Vector& v) { return {v.x, v.y, v.z}; }

struct SetShape {
  jolt::Body& body;

  void operator()(const NoShape&) const {}
  void operator()(const BoxShape& s) const {
    body.form = jolt::Form::Box;
    body.size = plain(s.half_extents);
  }
  void operator()(const SphereShape& s) const {
    body.form = jolt::Form::Sphere;
    body.radius = s.radius;
  }
  void operator()(const CapsuleShape& s) const {
    body.form = jolt::Form::Capsule;
    body.radius = s.radius;
    body.half = s.half_height;
  }
  void operator()(const CylinderShape& s) const {
    body.form = jolt::Form::Cylinder;
    body.radius = s.radius;
    body.half = s.half_height;
  }
  void operator()(const HullShape& s) const {
    body.form = jolt::Form::Hull;
    for (const Vec3& v : *s) body.vertices.push_back(plain(v));
  }
  void operator()(const PlaneShape& s) const {
    body.form = jolt::Form::Plane;
    body.size = plain(s.normal);
    body.radius = s.offset;
  }
  void operator()(const MeshShape& s) const {
    body.form = jolt::Form::Mesh;
    for (const Vec3& v : s->vertices) body.vertices.push_back(plain(v));
    body.triangles = s->triangles;
  }
};

jolt::Body plain(const SceneBody& body) {
  jolt::Body made;
  std::visit(SetShape{made}, body.shape);
  made.dynamic = body.type == BodyType::Dynamic;
  made.collides = body.collides;
  made.start = {plain(body.pose.position), plain(body.pose.orientation), plain(body.twist.linear),
                plain(body.twist.angular)};
  made.mass = body.mass;
  made.inertia = plain(body.inertia);
  made.friction = body.friction;
  made.restitution = body.restitution;
  return made;
}

class JoltEngine final : public Engine {
 public:
  JoltEngine(const Scene& scene, const Settings& settings)
      : substeps_(settings.substeps.value_or(1)),
        world_({.gravity = plain(scene.gravity),
                .bodies = scene.bodies.size(),
                .collision_steps = substeps_,
                .velocity_steps = settings.iterations.value_or(0),
                .sleeping = settings.sleeping}) {
    for (const SceneBody& body : scene.bodies) world_.add(plain(body));
    for (const SceneJoint& joint : scene.joints) add_joint(scene, joint);
    for (const auto& [a, b] : scene.apart) world_.set_apart(a, b);
    world_.ready();
  }

  std::string name() const override { return "jolt"; }
  void step(double dt) override { world_.step(dt); }
  pbd::BodyState state(int body) const override {
    const jolt::State s = world_.state(body);
    const jolt::Rotation& q = s.orientation;
    pbd::BodyState state;
    state.pose = {.position = from(s.position), .orientation = Quat(q.w, q.x, q.y, q.z)};
    state.pose.orientation.normalize();
    state.twist = {from(s.linear), from(s.angular)};
    return state;
  }
  EngineStats stats() const override { return {.stage_s = {}, .substeps = substeps_}; }
  bool awake(int body) const override { return world_.awake(body); }
  void set_twist(int body, const Twist& twist) override {
    world_.set_twist(body, plain(twist.linear), plain(twist.angular));
  }
  void set_pose(int body, const Pose& pose) override {
    world_.set_pose(body, plain(pose.position), plain(pose.orientation));
  }

 private:
  void add_joint(const Scene& scene, const SceneJoint& joint) {
    // An unbounded drive has no value in its floats.
    const bool unlimited = joint.driven && !std::isfinite(joint.max_torque);
    const bool hinge = joint.kind == JointKind::Hinge;
    if (unlimited || (!hinge && joint.kind != JointKind::Ball) || joint.compliance > 0.0) {
      throw std::invalid_argument("jolt: this adapter has rigid ball joints and hinges only");
    }
    // Jolt's own joints do not disable contacts between their bodies.
    if (!joint.touch && joint.a >= 0) world_.set_apart(joint.a, joint.b);
    if (!hinge && !joint.limited && !std::isfinite(joint.cone) && joint.friction == 0.0) {
      world_.add_ball(joint.a, plain(joint.anchor_a_l), joint.b, plain(joint.anchor_b_l));
      return;
    }
    const Pose& b = scene.bodies[static_cast<std::size_t>(joint.b)].pose;
    jolt::Joint made{.a = joint.a,
                     .b = joint.b,
                     .point_w = plain(b.to_world(joint.anchor_b_l)),
                     .axis_w = plain(joint.axis_w),
                     .limited = joint.limited,
                     .lower = joint.lower,
                     .upper = joint.upper,
                     .friction = joint.friction,
                     .driven = joint.driven,
                     .speed = joint.speed,
                     .max_torque = joint.max_torque};
    if (std::isfinite(joint.cone)) made.cone = joint.cone;
    if (hinge) {
      world_.add_hinge(made);
    } else {
      world_.add_swing_twist(made);
    }
  }

  int substeps_;
  jolt::World world_;
};

}  // namespace

std::unique_ptr<Engine> make_jolt(const Scene& scene, const Settings& settings) {
  return std::make_unique<JoltEngine>(scene, settings);
}

}  // namespace tandem::bench
