// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "bullet/bullet_scene.h"

#include <stdexcept>
#include <string>
#include <variant>

#include "tandem/pbd/validate.h"

namespace tandem::demos {

namespace {

[[noreturn]] void refuse(const std::string& name, const char* rule) {
  pbd::detail::refuse("plain scene: " + name, rule);
}

/// m, half extents of the box that replaces a half-space.
const pbd::Vec3 kGround(50.0, 50.0, 5.0);

bench::SceneShape plain_shape(const collision::Shape& shape, const std::string& name) {
  if (const auto* s = std::get_if<collision::Box>(&shape)) return bench::BoxShape{s->half_extents};
  if (const auto* s = std::get_if<collision::Sphere>(&shape)) return bench::SphereShape{s->radius};
  if (const auto* s = std::get_if<collision::Capsule>(&shape)) {
    return bench::CapsuleShape{s->radius, s->half_height};
  }
  if (std::holds_alternative<collision::HalfSpace>(shape)) return bench::BoxShape{kGround};
  if (const auto* s = std::get_if<collision::Mesh>(&shape)) {
    bench::MeshData mesh;
    mesh.vertices.assign((*s)->vertices().begin(), (*s)->vertices().end());
    for (const auto& triangle : (*s)->triangles()) {
      mesh.triangles.push_back({triangle[0], triangle[1], triangle[2]});
    }
    return std::make_shared<const bench::MeshData>(std::move(mesh));
  }
  refuse(name, "of boxes, spheres, capsules, half-spaces and meshes only");
}

bench::SceneBody plain_body(const pbd::World& world, const collision::ColliderDef& collider,
                            const std::string& name) {
  const pbd::BodyProps& props = world.props(collider.body);
  bench::SceneBody body;
  body.shape = plain_shape(collider.shape, name);
  body.type = props.type;
  body.friction = collider.material.friction;
  body.restitution = collider.material.restitution;
  const pbd::Pose& pose = world.pose(collider.body);
  if (props.type == pbd::BodyType::Static) {
    body.pose = {pose.to_world(collider.local.position),
                 pose.orientation * collider.local.orientation};
    if (const auto* plane = std::get_if<collision::HalfSpace>(&collider.shape)) {
      // Bullet finds one contact point of a box on a plane per step, and small boxes tip over
      // before there are three; on a box it finds all.
      const pbd::Pose down{(plane->offset - kGround.z()) * plane->normal,
                           pbd::Quat::FromTwoVectors(pbd::Vec3::UnitZ(), plane->normal)};
      body.pose = {body.pose.to_world(down.position), body.pose.orientation * down.orientation};
    }
    return body;
  }
  if (props.type != pbd::BodyType::Dynamic) refuse(name, "not moved by hand");
  if (!props.locks.any() && props.gravity_scale != 1.0) refuse(name, "under gravity");
  if (props.linear_damping != 0.0 || props.angular_damping != 0.0) refuse(name, "not damped");
  if (!collider.local.position.isZero(1e-12) || collider.local.orientation.vec().norm() > 1e-12) {
    refuse(name, "one shape in its centre of mass");
  }
  body.pose = pose;
  body.twist = world.twist(collider.body);
  body.mass = props.mass;
  body.inertia = props.inertia.diagonal();
  return body;
}

}  // namespace

PlainScene plain_scene(const Scene& scene) {
  PlainScene plain;
  plain.scene.gravity = scene.world->gravity();
  plain.index.assign(scene.bodies.size(), -1);
  for (std::uint32_t slot = 0; slot < scene.contacts->slot_count(); ++slot) {
    const collision::ColliderId id = scene.contacts->collider_at(slot);
    if (!id.valid()) continue;
    const collision::ColliderDef& collider = scene.contacts->collider(id);
    int shared = -1;
    std::string name = "a fixed body";
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
      if (scene.bodies[i].body != collider.body) continue;
      shared = static_cast<int>(i);
      name = scene.bodies[i].name;
    }
    plain.scene.bodies.push_back(plain_body(*scene.world, collider, name));
    plain.shared.push_back(shared);
    if (shared < 0) continue;
    int& index = plain.index[static_cast<std::size_t>(shared)];
    if (index >= 0) refuse(name, "one shape in its centre of mass");
    index = static_cast<int>(plain.scene.bodies.size()) - 1;
  }
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    if (plain.index[i] < 0) refuse(scene.bodies[i].name, "one shape in its centre of mass");
  }
  return plain;
}

}  // namespace tandem::demos
