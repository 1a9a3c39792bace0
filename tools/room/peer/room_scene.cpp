// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "peer/room_scene.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "tandem/scene_files.h"

namespace tandem::room {

namespace {

using nlohmann::json;

Vec3 vec3(const json& value) {
  return {value.at(0).get<double>(), value.at(1).get<double>(), value.at(2).get<double>()};
}

double mass_of(const Scene& scene, pbd::BodyId body) {
  return scene.world().props(body).type == BodyType::Dynamic ? scene.world().props(body).mass : 0.0;
}

/// Bodies that members may make: one shape of 3 cm to 1 m, near the centre. The page has the same
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
  SceneFile file = parse_scene(text, {}, "room's file");
  scene_ = std::move(file.scene);
  for (const SceneFile::Body& body : file.bodies) {
    bodies_.push_back({body.name, body.body, mass_of(scene_, body.body)});
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
    const pbd::BodyId id = add_body(scene_, body.dump()).body;
    bodies_.push_back({name, id, mass_of(scene_, id)});
    return &bodies_.back();
  } catch (const json::exception&) {
    return nullptr;
  } catch (const SceneFileError&) {
    return nullptr;
  }
}

}  // namespace tandem::room
