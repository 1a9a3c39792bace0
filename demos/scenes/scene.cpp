// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "scenes/scene.h"

#include <numeric>
#include <stdexcept>
#include <utility>

#include "scenes/random.h"
#include "tandem/pbd/bytes.h"

namespace tandem::demos {

namespace {

pbd::BodyDef box_def(const pbd::Vec3& half_extents, double mass, const pbd::Vec3& centre) {
  const pbd::Vec3 squares = half_extents.cwiseProduct(half_extents);
  const pbd::Vec3 moments(squares.y() + squares.z(), squares.x() + squares.z(),
                          squares.x() + squares.y());
  pbd::BodyDef def;
  def.mass = mass;
  def.inertia = (mass / 3.0 * moments).asDiagonal();
  def.pose.position = centre;
  return def;
}

/// 0, 1, .. count - 1, shuffled (Fisher and Yates).
std::vector<std::size_t> shuffled(std::size_t count, std::uint64_t seed) {
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), std::size_t{0});
  if (seed == 0) return order;
  Random random(seed);
  for (std::size_t i = count; i > 1; --i) std::swap(order[i - 1], order[random.below(i)]);
  return order;
}

void add_ground(Scene& scene, double friction) {
  pbd::BodyDef def;
  def.type = pbd::BodyType::Static;
  collision::ColliderDef collider;
  collider.body = scene.world->add_body(def);
  collider.shape = collision::HalfSpace{pbd::Vec3::UnitZ(), 0.0};
  collider.material.friction = friction;
  scene.contacts->add(*scene.world, collider);
}

}  // namespace

const SceneBody& Scene::body(std::string_view name) const {
  for (const SceneBody& candidate : bodies) {
    if (candidate.name == name) return candidate;
  }
  throw std::invalid_argument("scene: name = " + std::string(name) +
                              " breaks: must name a shared body");
}

std::uint64_t scene_hash(const Scene& scene) {
  std::vector<std::byte> bytes;
  pbd::ByteWriter out(bytes);
  for (const SceneBody& body : scene.bodies) {
    out.u64(body.id.high);
    out.u64(body.id.low);
    out.vec3(body.half_extents);
    out.vec3(body.start);
    out.f64(scene.world->props(body.body).mass);
  }
  return pbd::hash_bytes(bytes);
}

void SceneBuilder::box(std::string name, const pbd::Vec3& size, double mass,
                       const pbd::Vec3& centre) {
  boxes_.push_back({std::move(name), 0.5 * size, mass, centre});
}

Scene SceneBuilder::build(const SceneOptions& options, double friction) const {
  Scene scene;
  scene.world = std::make_unique<pbd::World>();
  scene.contacts = std::make_unique<collision::CollisionScene>();
  scene.bodies.resize(boxes_.size());

  // One draw for each body in the listed order, so that noise and order do not depend on another.
  std::vector<pbd::Vec3> noise(boxes_.size(), pbd::Vec3::Zero());
  Random random(options.noise_seed);
  if (options.noise_seed != 0) {
    for (pbd::Vec3& offset : noise) {
      for (int axis = 0; axis < 3; ++axis) {
        offset[axis] = random.uniform(-options.noise, options.noise);
      }
    }
  }

  // The ground takes the slot after the last box and is shuffled with them.
  for (const std::size_t i : shuffled(boxes_.size() + 1, options.order_seed)) {
    if (i == boxes_.size()) {
      add_ground(scene, friction);
      continue;
    }
    const Box& box = boxes_[i];
    SceneBody& body = scene.bodies[i];
    body.name = box.name;
    body.id = consensus::SharedId::from_name(box.name);
    body.half_extents = box.half_extents;
    body.start = box.centre;
    body.body = scene.world->add_body(box_def(box.half_extents, box.mass, box.centre + noise[i]));
    collision::ColliderDef collider;
    collider.body = body.body;
    collider.shape = collision::Box{box.half_extents};
    collider.material.friction = friction;
    scene.contacts->add(*scene.world, collider);
  }
  scene.world->set_contact_source(scene.contacts.get());
  return scene;
}

}  // namespace tandem::demos
