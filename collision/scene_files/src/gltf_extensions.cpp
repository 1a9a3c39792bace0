// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "gltf_extensions.h"

#include <algorithm>
#include <array>
#include <utility>

namespace tandem::scene_files {
namespace {

constexpr const char* kOmiBody = "OMI_physics_body";
constexpr const char* kOmiShape = "OMI_physics_shape";
constexpr const char* kKhrBody = "KHR_physics_rigid_bodies";
constexpr const char* kKhrShape = "KHR_implicit_shapes";

/// Extensions for looks only.
bool is_for_looks(const std::string& name) {
  constexpr std::array kPrefixes{"KHR_materials_", "KHR_texture_", "KHR_lights_", "EXT_texture_"};
  return std::any_of(kPrefixes.begin(), kPrefixes.end(),
                     [&](const char* prefix) { return name.rfind(prefix, 0) == 0; });
}
bool is_read(const std::string& name) {
  return name == kOmiBody || name == kOmiShape || name == kKhrBody || name == kKhrShape;
}

/// The member if it is an object, else null.
json* member(json& parent, const char* key) {
  if (!parent.is_object()) return nullptr;
  const auto at = parent.find(key);
  return at == parent.end() || !at->is_object() ? nullptr : &*at;
}

void move_member(json& from, json& to, const char* key) {
  if (from.is_object() && from.contains(key)) to[key] = std::move(from[key]);
}

/// Fills in OMI's own defaults.
json implicit_shape(json shape) {
  const json* type = shape.is_object() && shape.contains("type") ? &shape["type"] : nullptr;
  if (type == nullptr || !type->is_string()) return shape;
  const auto name = type->get<std::string>();
  if (name != "capsule" && name != "cylinder") return shape;
  json& values = shape[name];
  if (values.is_null()) values = json::object();
  if (!values.is_object()) return shape;
  values.emplace("height", name == "capsule" ? 1.0 : 2.0);
  // Earlier drafts.
  const json radius = values.contains("radius") ? values["radius"] : json(0.5);
  values.erase("radius");
  values.emplace("radiusTop", radius);
  values.emplace("radiusBottom", radius);
  return shape;
}

/// Converts a collider or a trigger.
json body_shape(json from, const json& shapes) {
  if (!from.is_object() || !from.contains("shape")) return from;
  json index = std::move(from["shape"]);
  from.erase("shape");
  json& geometry = from["geometry"] = json::object();
  if (index.is_number_unsigned() && index.get<std::size_t>() < shapes.size()) {
    const json& shape = shapes[index.get<std::size_t>()];
    const bool typed = shape.is_object() && shape.contains("type") && shape["type"].is_string();
    const std::string type = typed ? shape["type"].get<std::string>() : std::string();
    if (type == "convex" || type == "trimesh") {
      geometry["convexHull"] = type == "convex";
      if (shape.contains(type) && shape[type].is_object() && shape[type].contains("mesh")) {
        geometry["mesh"] = shape[type]["mesh"];
      }
      return from;
    }
  }
  geometry["shape"] = std::move(index);
  return from;
}

json body(json from, const json& shapes) {
  json to = json::object();
  for (const char* key : {"collider", "trigger"}) {
    if (from.contains(key)) to[key] = body_shape(std::move(from[key]), shapes);
  }
  if (!from.contains("motion")) return to;
  json motion = std::move(from["motion"]);
  if (motion.is_object()) {
    const json type = motion.contains("type") ? motion["type"] : json();
    if (type == "static") return to;
    if (type == "kinematic") motion["isKinematic"] = true;
    if (type == "kinematic" || type == "dynamic") motion.erase("type");
    motion.emplace("mass", 1.0);
  }
  to["motion"] = std::move(motion);
  return to;
}

}  // namespace

void check_gltf_extensions(const Place& document) {
  if (document.has("extensionsRequired")) {
    const Place required = document.at("extensionsRequired");
    for (std::size_t i = 0; i < required.size(); ++i) {
      const Place one = required.at(i);
      const std::string name = one.text();
      if (!is_read(name) && !is_for_looks(name)) {
        one.refuse(
            "one of those that are read: KHR_physics_rigid_bodies, KHR_implicit_shapes, "
            "OMI_physics_body, OMI_physics_shape, or for looks alone");
      }
    }
  }
  if (!document.has("extensionsUsed")) return;
  const Place used = document.at("extensionsUsed");
  for (std::size_t i = 0; i < used.size(); ++i) {
    const Place one = used.at(i);
    const std::string name = one.text();
    const bool physics =
        name.find("physics") != std::string::npos || name.find("collider") != std::string::npos;
    if (physics && !is_read(name)) one.warn(name + " is not read");
  }
}

void rewrite_omi_physics(json& document) {
  if (!document.is_object() || !document.contains("nodes") || !document["nodes"].is_array()) return;
  json* extensions = member(document, "extensions");
  if (extensions != nullptr && (extensions->contains(kKhrBody) || extensions->contains(kKhrShape)))
    return;
  json shapes = json::array();
  if (extensions != nullptr) {
    if (json* family = member(*extensions, kOmiShape); family != nullptr) {
      if (family->contains("shapes") && (*family)["shapes"].is_array())
        shapes = (*family)["shapes"];
      extensions->erase(kOmiShape);
    }
    json resources = json::object();
    if (json* family = member(*extensions, kOmiBody); family != nullptr) {
      for (const char* key : {"physicsMaterials", "collisionFilters"}) {
        move_member(*family, resources, key);
      }
      extensions->erase(kOmiBody);
    }
    json list = json::array();
    for (const json& shape : shapes) list.push_back(implicit_shape(shape));
    (*extensions)[kKhrShape] = {{"shapes", std::move(list)}};
    (*extensions)[kKhrBody] = std::move(resources);
  }
  for (json& node : document["nodes"]) {
    json* own = member(node, "extensions");
    if (own == nullptr || own->contains(kKhrBody)) continue;
    json* from = member(*own, kOmiBody);
    if (from == nullptr) continue;
    json to = body(std::move(*from), shapes);
    own->erase(kOmiBody);
    if (!to.empty()) (*own)[kKhrBody] = std::move(to);
  }
}

}  // namespace tandem::scene_files
