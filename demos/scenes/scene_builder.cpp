// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <algorithm>
#include <array>
#include <limits>
#include <numeric>
#include <type_traits>
#include <utility>

#include "scenes/random.h"
#include "scenes/scene.h"
#include "tandem/pbd/math.h"

namespace tandem::demos {

namespace {

/// 0, 1, .. count - 1, shuffled (Fisher and Yates).
std::vector<std::size_t> shuffled(std::size_t count, std::uint64_t seed) {
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), std::size_t{0});
  if (seed == 0) return order;
  Random random(seed);
  for (std::size_t i = count; i > 1; --i) std::swap(order[i - 1], order[random.below(i)]);
  return order;
}

/// Mass properties of all parts, in their common frame.
collision::MassProperties mass_of(const std::vector<ScenePart>& parts) {
  collision::MassProperties sum;
  std::vector<std::pair<pbd::Vec3, collision::MassProperties>> placed;
  for (const ScenePart& part : parts) {
    const collision::MassProperties m = collision::mass_properties(part.shape, 1.0);
    placed.emplace_back(part.local.to_world(m.com), m);
    sum.mass += m.mass;
    sum.com += m.mass * placed.back().first;
  }
  sum.com /= sum.mass;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const pbd::Mat3 turn = parts[i].local.orientation.toRotationMatrix();
    const pbd::Vec3 arm = placed[i].first - sum.com;
    sum.inertia += turn * placed[i].second.inertia * turn.transpose();
    sum.inertia +=
        placed[i].second.mass * (arm.squaredNorm() * pbd::Mat3::Identity() - arm * arm.transpose());
  }
  return sum;
}

/// m, bounding box in the shape's frame.
collision::Aabb bounds_of(const collision::Shape& shape) {
  const auto about = [](const pbd::Vec3& half) { return collision::Aabb{-half, half}; };
  if (const auto* s = std::get_if<collision::Sphere>(&shape)) {
    return about(pbd::Vec3::Constant(s->radius));
  }
  if (const auto* s = std::get_if<collision::Box>(&shape)) return about(s->half_extents);
  if (const auto* s = std::get_if<collision::Capsule>(&shape)) {
    return about(pbd::Vec3(s->radius, s->radius, s->half_height + s->radius));
  }
  if (const auto* s = std::get_if<collision::Cylinder>(&shape)) {
    return about(pbd::Vec3(s->radius, s->radius, s->half_height));
  }
  if (const auto* s = std::get_if<collision::Cone>(&shape)) {
    return about(pbd::Vec3(s->radius, s->radius, s->half_height));
  }
  if (const auto* s = std::get_if<collision::Hull>(&shape)) return (*s)->bounds();
  if (const auto* s = std::get_if<collision::Mesh>(&shape)) return (*s)->bounds();
  return {};
}

/// m, half extents about the common origin of a box around all parts.
pbd::Vec3 reach_of(const std::vector<ScenePart>& parts) {
  pbd::Vec3 reach = pbd::Vec3::Zero();
  for (const ScenePart& part : parts) {
    const collision::Aabb box = bounds_of(part.shape);
    const pbd::Vec3 centre = part.local.to_world(0.5 * (box.min + box.max));
    const pbd::Mat3 turn = part.local.orientation.toRotationMatrix().cwiseAbs();
    reach = reach.cwiseMax(centre.cwiseAbs() + turn * (0.5 * (box.max - box.min)));
  }
  return reach;
}

/// The shared body of a spec, not yet in a world. The parts are recentred on the centre of mass.
SceneBody body_of(const BodySpec& spec, const collision::MassProperties& mass) {
  SceneBody body;
  body.name = spec.name;
  body.id = consensus::SharedId::from_name(spec.name);
  body.parts = spec.parts;
  for (ScenePart& part : body.parts) part.local.position -= mass.com;
  body.half_extents = reach_of(body.parts);
  body.start = spec.pose.to_world(mass.com);
  body.collides = spec.collides;
  body.owner = spec.owner;
  return body;
}

pbd::BodyDef def_of(const BodySpec& spec, const SceneBody& body,
                    const collision::MassProperties& mass, std::uint64_t users) {
  pbd::BodyDef def;
  def.pose = {body.start, spec.pose.orientation};
  def.mass = spec.mass;
  def.inertia = spec.mass / mass.mass * mass.inertia;
  def.linear_damping = spec.linear_damping;
  def.angular_damping = spec.angular_damping;
  def.bullet = spec.bullet;
  if (spec.owner) {
    const bool here = (users >> *spec.owner & 1) != 0;
    def.type = here ? pbd::BodyType::Kinematic : pbd::BodyType::Dynamic;
    def.gravity_scale = 0.0;
    def.can_sleep = false;
  }
  if (spec.held_up) {
    def.gravity_scale = 0.0;
    def.locks = {{true, true, true}, {true, true, true}};
  }
  return def;
}

}  // namespace

void SceneBuilder::box(std::string name, const pbd::Vec3& size, double mass,
                       const pbd::Vec3& centre) {
  BodySpec spec;
  spec.name = std::move(name);
  spec.parts.push_back({collision::Box{0.5 * size}, {}});
  spec.mass = mass;
  spec.pose.position = centre;
  add(std::move(spec));
}

void SceneBuilder::fix(collision::Shape shape, const pbd::Pose& pose,
                       const collision::Material& material) {
  fixed_.push_back({{std::move(shape), pose}, material});
}

void SceneBuilder::half_space(const pbd::Vec3& normal, double offset,
                              const collision::Material& material) {
  collision::HalfSpace shape;
  shape.normal = normal;
  shape.offset = offset;
  fix(shape, {}, material);
}

Scene SceneBuilder::build(const SceneOptions& options, double friction) const {
  SceneBuilder copy = *this;
  collision::Material material;
  material.friction = friction;
  for (BodySpec& spec : copy.bodies_) spec.material = material;
  copy.ground(material);
  return copy.build(options);
}

Scene SceneBuilder::build(const SceneOptions& options) const {
  Scene scene;
  scene.world = std::make_unique<pbd::World>();
  scene.contacts = std::make_unique<collision::CollisionScene>();
  scene.bodies.resize(bodies_.size());
  for (const Fixed& fixed : fixed_) scene.fixed.push_back(fixed.part);

  // One draw per body in the listed order, so that noise does not depend on the shuffled order.
  std::vector<pbd::Vec3> noise(bodies_.size(), pbd::Vec3::Zero());
  Random random(options.noise_seed);
  if (options.noise_seed != 0) {
    for (pbd::Vec3& offset : noise) {
      for (int axis = 0; axis < 3; ++axis) {
        offset[axis] = random.uniform(-options.noise, options.noise);
      }
    }
  }

  // Static bodies are numbered after the shared ones and shuffled with them. The solver's order
  // does not depend on it.
  for (const std::size_t i : shuffled(bodies_.size() + fixed_.size(), options.order_seed)) {
    collision::ColliderDef collider;
    if (i >= bodies_.size()) {
      const Fixed& fixed = fixed_[i - bodies_.size()];
      pbd::BodyDef def;
      def.stable_id = i;
      def.type = pbd::BodyType::Static;
      def.pose = fixed.part.pose;
      collider.body = scene.world->add_body(def);
      collider.shape = fixed.part.shape;
      collider.material = fixed.material;
      scene.contacts->add(*scene.world, collider);
      continue;
    }
    const BodySpec& spec = bodies_[i];
    const collision::MassProperties mass = mass_of(spec.parts);
    SceneBody& body = scene.bodies[i];
    body = body_of(spec, mass);
    pbd::BodyDef def = def_of(spec, body, mass, options.users);
    def.stable_id = i;
    if (!spec.owner) def.pose.position += noise[i];
    body.body = scene.world->add_body(def);
    if (!spec.collides) continue;
    for (const ScenePart& part : body.parts) {
      collider.body = body.body;
      collider.shape = part.shape;
      collider.local = part.local;
      collider.material = spec.material;
      collider.filter = spec.filter;
      scene.contacts->add(*scene.world, collider);
    }
  }
  scene.world->set_contact_source(scene.contacts.get());
  return scene;
}

}  // namespace tandem::demos
