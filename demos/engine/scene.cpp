// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "demos/engine/scene.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tandem::bench {
namespace {

struct Inertia {
  double mass;

  Vec3 operator()(const NoShape&) const { return Vec3::Constant(0.4 * mass); }
  Vec3 operator()(const BoxShape& box) const {
    const Vec3 s = box.half_extents.cwiseAbs2();
    return mass / 3.0 * Vec3(s.y() + s.z(), s.x() + s.z(), s.x() + s.y());
  }
  Vec3 operator()(const SphereShape& sphere) const {
    return Vec3::Constant(0.4 * mass * sphere.radius * sphere.radius);
  }
  Vec3 operator()(const CapsuleShape& c) const {
    const double r = c.radius;
    const double l = 2.0 * c.half_height;
    const double cylinder = std::numbers::pi * r * r * l;
    const double ball = 4.0 / 3.0 * std::numbers::pi * r * r * r;
    const double mc = mass * cylinder / (cylinder + ball);
    const double mb = mass - mc;
    // The caps: two half balls, each with its centre of mass 3/8 r + l/2 from the middle.
    const double across =
        mc * (r * r / 4.0 + l * l / 12.0) + mb * (0.4 * r * r + l * l / 4.0 + 3.0 / 8.0 * l * r);
    return {across, across, mc * r * r / 2.0 + mb * 0.4 * r * r};
  }
  Vec3 operator()(const CylinderShape& c) const {
    const double r2 = c.radius * c.radius;
    const double across = mass * (r2 / 4.0 + c.half_height * c.half_height / 3.0);
    return {across, across, mass * r2 / 2.0};
  }
  Vec3 operator()(const PlaneShape&) const { return Vec3::Zero(); }
  Vec3 operator()(const HullShape&) const { return Vec3::Zero(); }
  Vec3 operator()(const MeshShape&) const { return Vec3::Zero(); }
};

}  // namespace

Vec3 principal_inertia(const SceneShape& shape, double mass) {
  return std::visit(Inertia{mass}, shape);
}

int Scene::add(const SceneShape& shape, double mass, const Pose& pose) {
  bodies.push_back(
      {.shape = shape, .pose = pose, .mass = mass, .inertia = principal_inertia(shape, mass)});
  return static_cast<int>(bodies.size()) - 1;
}

int Scene::add_static(const SceneShape& shape, const Pose& pose) {
  bodies.push_back({.shape = shape, .type = BodyType::Static, .pose = pose, .mass = 0.0});
  return static_cast<int>(bodies.size()) - 1;
}

SceneJoint& Scene::add_joint(JointKind kind, int a, int b, const Vec3& anchor_w) {
  const auto local = [&](int i) {
    return i < 0 ? anchor_w : bodies[static_cast<std::size_t>(i)].pose.to_local(anchor_w);
  };
  joints.push_back({.kind = kind, .a = a, .b = b, .anchor_a_l = local(a), .anchor_b_l = local(b)});
  return joints.back();
}

bool Scene::has_simple_joints() const {
  return apart.empty() && std::all_of(joints.begin(), joints.end(), [](const SceneJoint& joint) {
           const bool limited = joint.limited && joint.kind == JointKind::Ball;
           return !std::isfinite(joint.cone) && !std::isfinite(joint.max_torque) &&
                  joint.friction == 0.0 && joint.touch && !limited;
         });
}

int Scene::frames() const { return static_cast<int>(std::lround(seconds / dt)); }

}  // namespace tandem::bench
