// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "peer/room_scene.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>

namespace tandem::room {

namespace {

using nlohmann::json;

Vec3 vec3(const json& value) {
  return {value.at(0).get<double>(), value.at(1).get<double>(), value.at(2).get<double>()};
}

Pose pose_of(const json& body) {
  Pose pose;
  if (body.contains("position")) pose.position = vec3(body["position"]);
  if (body.contains("orientation")) {
    const json& q = body["orientation"];
    pose.orientation = Quat(q.at(3).get<double>(), q.at(0).get<double>(), q.at(1).get<double>(),
                            q.at(2).get<double>());
  }
  return pose;
}

collision::Shape shape_of(const json& shape) {
  const std::string type = shape.at("type").get<std::string>();
  if (type == "box") return Box(vec3(shape.at("halfExtents")));
  if (type == "sphere") return Sphere{shape.at("radius").get<double>()};
  const auto round = [&](auto value) {
    value.radius = shape.at("radius").get<double>();
    value.half_height = shape.at("halfHeight").get<double>();
    return value;
  };
  if (type == "cylinder") return round(Cylinder{});
  if (type == "capsule") return round(Capsule{});
  if (type == "halfSpace") return HalfSpace{vec3(shape.at("normal")), shape.value("offset", 0.0)};
  throw std::invalid_argument(
      "shape.type must be box, sphere, cylinder, capsule or halfSpace, is '" + type + "'");
}

collision::Material material_of(const json& body) {
  collision::Material material;
  material.friction = body.value("friction", material.friction);
  material.restitution = body.value("restitution", material.restitution);
  return material;
}

/// As tandem.js adds it: a shape, which says the mass, and further colliders without any.
pbd::BodyId add(Scene& scene, const json& body) {
  SolidDef def;
  def.type = body.value("type", "dynamic") == "static" ? BodyType::Static : BodyType::Dynamic;
  def.density = body.value("density", def.density);
  if (body.contains("mass")) def.mass = body["mass"].get<double>();
  def.pose = pose_of(body);
  def.material = material_of(body);
  def.gravity_scale = body.value("gravityScale", def.gravity_scale);
  def.linear_damping = body.value("linearDamping", def.linear_damping);
  def.angular_damping = body.value("angularDamping", def.angular_damping);
  def.bullet = body.value("bullet", false);
  const pbd::BodyId id = scene.add(shape_of(body.at("shape")), def);
  for (const json& part : body.value("parts", json::array())) {
    scene.shapes().add(scene.world(), {.body = id,
                                       .shape = shape_of(part.at("shape")),
                                       .local = pose_of(part),
                                       .material = material_of(body)});
  }
  return id;
}

double mass_of(const Scene& scene, pbd::BodyId body) {
  return scene.world().props(body).type == BodyType::Dynamic ? scene.world().props(body).mass : 0.0;
}

/// What members may make: one shape of 3 cm to 1 m, near the room's middle. The page has the same
/// rule (world.js).
bool may_be_made(const json& body) {
  const auto within = [](double value, double low, double high) {
    return value >= low && value <= high;
  };
  if (!body.is_object() || body.size() != 3) return false;
  const std::string name = body.at("name").get<std::string>();
  const json& shape = body.at("shape");
  const Vec3 at = vec3(body.at("position"));
  if (name.size() > 64 || name.rfind("made/", 0) != 0) return false;
  if (!within(at.x(), -10, 10) || !within(at.y(), -10, 10) || !within(at.z(), 0, 10)) return false;
  const std::string type = shape.at("type").get<std::string>();
  if (type == "sphere") return within(shape.at("radius").get<double>(), 0.03, 0.5);
  if (type != "box") return false;
  const Vec3 half = vec3(shape.at("halfExtents"));
  return within(half.minCoeff(), 0.015, 0.5) && within(half.maxCoeff(), 0.015, 0.5);
}

}  // namespace

RoomScene::RoomScene(std::string_view text) {
  try {
    const json room = json::parse(text);
    for (const json& body : room.at("bodies")) {
      const pbd::BodyId id = add(scene_, body);
      bodies_.push_back({body.value("name", ""), id, mass_of(scene_, id)});
    }
  } catch (const json::exception& problem) {
    throw std::invalid_argument(std::string("room's file: ") + problem.what());
  }
}

const RoomScene::Body* RoomScene::find(std::string_view name) const {
  const auto found = std::find_if(bodies_.begin(), bodies_.end(),
                                  [name](const Body& body) { return body.name == name; });
  return found == bodies_.end() ? nullptr : &*found;
}

const RoomScene::Body* RoomScene::make(std::string_view text) {
  try {
    json body = json::parse(text);
    if (bodies_.size() >= kMaxBodies || !may_be_made(body)) return nullptr;
    const std::string name = body["name"].get<std::string>();
    if (find(name) != nullptr) return nullptr;
    body.update({{"density", 300.0}, {"linearDamping", 0.3}, {"angularDamping", 2.0}});
    const pbd::BodyId id = add(scene_, body);
    bodies_.push_back({name, id, mass_of(scene_, id)});
    return &bodies_.back();
  } catch (const json::exception&) {
    return nullptr;
  }
}

}  // namespace tandem::room
