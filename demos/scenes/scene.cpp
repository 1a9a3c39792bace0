// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "scenes/scene.h"

#include "tandem/pbd/bytes.h"
#include "tandem/pbd/validate.h"

namespace tandem::demos {

std::size_t Scene::index_of(std::string_view name) const {
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (bodies[i].name == name) return i;
  }
  pbd::detail::refuse("scene: name", "that of a shared body", name);
}

BodiesBySlot::BodiesBySlot(const pbd::World& world, std::span<const SceneBody> bodies)
    : indices_(world.slot_count(), pbd::BodyId::kNone) {
  for (std::uint32_t i = 0; i < bodies.size(); ++i) indices_[bodies[i].body.index] = i;
}

std::uint64_t scene_hash(const Scene& scene) {
  std::vector<std::byte> bytes;
  pbd::ByteWriter out(bytes);
  for (const SceneBody& body : scene.bodies) {
    out.u64(body.id.high);
    out.u64(body.id.low);
    out.vec3(body.half_extents);
    out.vec3(body.start);
    // An owned body has no mass at its owner's peer.
    out.f64(body.owner ? 0.0 : scene.world->props(body.body).mass);
  }
  return pbd::hash_bytes(bytes);
}

void let_fall(Scene& scene, std::size_t body, double age) {
  pbd::World& world = *scene.world;
  const pbd::BodyId id = scene.bodies[body].body;
  const pbd::Vec3 gravity = world.gravity();
  world.set_locks(id, {});
  world.set_gravity_scale(id, 1.0);
  pbd::Pose pose = world.pose(id);
  pose.position += 0.5 * age * age * gravity;
  world.set_pose(id, pose);
  world.set_twist(id, {age * gravity, pbd::Vec3::Zero()});
}

}  // namespace tandem::demos
