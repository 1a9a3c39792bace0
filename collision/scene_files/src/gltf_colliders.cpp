// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "gltf_colliders.h"

#include <cmath>
#include <numbers>
#include <optional>

#include "reader.h"

namespace tandem::scene_files {

Quat gltf_about_x(double angle) { return Quat(Eigen::AngleAxisd(angle, Vec3::UnitX())); }

void GltfColliders::add(const Place& at, const GltfFrame& frame, bool sensor, const Pose& body,
                        std::vector<collision::ColliderDef>& out) {
  if (frame.scale.isZero(0.0)) return;
  collision::ColliderDef def{.sensor = sensor};
  const Quat back = body.orientation.conjugate();
  def.local = {body.to_local(frame.pose.position), back * frame.pose.orientation};
  const Place geometry = at.at("geometry");
  bool known = true;
  geometry.guard([&] { known = shape(geometry, frame.scale, def); });
  if (!known) return;
  if (at.has("physicsMaterial")) material(at.at("physicsMaterial"), def.material);
  if (at.has("collisionFilter")) filter(at.at("collisionFilter"), def.filter);
  out.push_back(std::move(def));
}

bool GltfColliders::shape(const Place& geometry, const Vec3& scale, collision::ColliderDef& def) {
  if (geometry.has("shape")) return implicit(geometry.at("shape"), scale, def);
  bool hull = false;
  if (geometry.has("convexHull")) read(geometry.at("convexHull"), hull);
  if (geometry.has("mesh")) {
    def.shape = meshes_.shape(geometry.at("mesh"), scale, hull);
    return true;
  }
  const Place nodes = document_.at("nodes");
  const Place node_index = geometry.at("node");
  const Place node = nodes.pick(node_index);
  if (node.has("children")) node_index.warn("what hangs on the node is not part of the shape");
  def.shape = meshes_.shape(node.at("mesh"), scale, hull);
  return true;
}

bool GltfColliders::implicit(const Place& index, const Vec3& signed_scale,
                             collision::ColliderDef& def) {
  const Place extensions = document_.at("extensions");
  const Place family = extensions.at("KHR_implicit_shapes");
  const Place shapes = family.at("shapes");
  const Place shape = shapes.pick(index);
  const std::string type = shape.at("type").text();
  const Vec3 scale = signed_scale.cwiseAbs();
  const Place values = shape.has(type.c_str()) ? shape.at(type.c_str()) : shape;
  const auto number = [&](const char* key, double other) {
    return values.has(key) ? values.at(key).number() : other;
  };
  const bool round = std::abs(scale.x() - scale.z()) <= kGltfRoundOff * scale.x();
  const bool even = round && std::abs(scale.x() - scale.y()) <= kGltfRoundOff * scale.x();
  if (type == "box") {
    Vec3 size = Vec3::Ones();
    if (values.has("size")) read(values.at("size"), size);
    def.shape = Box(0.5 * size.cwiseProduct(scale));
    return true;
  }
  if (type == "sphere") {
    if (!even) return shape.warn("spheres of uneven scale are not read"), false;
    def.shape = Sphere{number("radius", 0.5) * scale.x()};
    return true;
  }
  if (type != "capsule" && type != "cylinder") {
    return shape.warn(type + " is not read"), false;
  }
  const double half = 0.5 * number("height", 0.5) * scale.y();
  const double top = number("radiusTop", 0.25) * scale.x();
  const double bottom = number("radiusBottom", 0.25) * scale.x();
  if (!round || (type == "capsule" && !even)) {
    return shape.warn("round shapes of uneven scale are not read"), false;
  }
  // Axis y in glTF, z here.
  def.local.orientation = def.local.orientation * gltf_about_x(-0.5 * std::numbers::pi);
  if (top == bottom && type == "capsule") {
    def.shape = Capsule{.radius = top, .half_height = half};
  } else if (top == bottom) {
    def.shape = Cylinder{.radius = top, .half_height = half};
  } else if (type == "cylinder" && (top == 0.0 || bottom == 0.0)) {
    def.shape = Cone{.radius = top + bottom, .half_height = half};
    if (bottom == 0.0)
      def.local.orientation = def.local.orientation * gltf_about_x(std::numbers::pi);
  } else {
    return shape.warn("shapes with two radii are not read"), false;
  }
  return true;
}

void GltfColliders::material(const Place& index, collision::Material& out) {
  const Place extensions = document_.at("extensions");
  const Place physics = extensions.at(kGltfPhysics);
  const Place materials = physics.at("physicsMaterials");
  const Place material = materials.pick(index);
  const auto [known, fresh] = materials_.try_emplace(index.value().get<std::int64_t>());
  if (!fresh) {
    out = known->second;
    return;
  }
  Reader io(material);
  std::optional<double> still;
  io("staticFriction", still);
  io("dynamicFriction", out.friction);
  io("restitution", out.restitution);
  io("frictionCombine", out.friction_rule);
  io("restitutionCombine", out.restitution_rule);
  if (still && *still != out.friction) material.warn("friction is dynamicFriction alone");
  io.finish();
  known->second = out;
}

void GltfColliders::filter(const Place& index, collision::Filter& out) {
  const Place extensions = document_.at("extensions");
  const Place physics = extensions.at(kGltfPhysics);
  const Place filters = physics.at("collisionFilters");
  const Place filter = filters.pick(index);
  const auto [known, fresh] = filters_.try_emplace(index.value().get<std::int64_t>());
  if (!fresh) {
    out = known->second;
    return;
  }
  const auto bits = [&](const char* key) {
    std::uint32_t sum = 0;
    const Place names = filter.at(key);
    for (std::size_t i = 0; i < names.size(); ++i) {
      const Place name = names.at(i);
      // Bit 0 is for colliders in no system.
      const auto next = static_cast<std::uint32_t>(systems_.size()) + 1;
      const auto bit = systems_.try_emplace(name.text(), next).first->second;
      if (bit > 31) name.refuse("one of at most 31 systems");
      sum |= 1u << bit;
    }
    return sum;
  };
  if (filter.has("collisionSystems")) out.category = bits("collisionSystems");
  if (filter.has("collideWithSystems")) out.mask = bits("collideWithSystems");
  if (filter.has("notCollideWithSystems")) out.mask &= ~bits("notCollideWithSystems");
  known->second = out;
}

}  // namespace tandem::scene_files
