// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <map>
#include <numbers>
#include <unordered_map>

#include "exact.h"
#include "fields.h"
#include "place.h"
#include "shapes.h"
#include "tandem/pbd/contact.h"
#include "tandem/pbd/validate.h"

namespace tandem {
namespace scene_files {
namespace {

template <class T>
json write(const T& value);

/// Writes all fields of an object.
class FieldWriter {
 public:
  template <class T>
  void operator()(const char* key, const T& value) {
    out[key] = write(value);
  }
  json out = json::object();
};

json write_value(double value) {
  if (std::isfinite(value)) return value;
  return value > 0.0 ? "Infinity" : "-Infinity";
}
json write_value(bool value) { return value; }
json write_value(std::int32_t value) { return value; }
json write_value(std::uint32_t value) { return value; }
json write_value(std::uint64_t value) { return value; }
json write_value(const Vec3& v) { return {v.x(), v.y(), v.z()}; }
json write_value(const Quat& q) {
  const Eigen::Vector4d v = before_normalized(Eigen::Vector4d(q.coeffs()));
  return {v[0], v[1], v[2], v[3]};
}
json write_value(const pbd::Mat3& m) {
  return {m(0, 0), m(1, 1), m(2, 2), m(0, 1), m(0, 2), m(1, 2)};
}
json write_value(const collision::Shape& shape) { return write_shape(shape); }
template <class T>
json write_value(const std::optional<T>& value) {
  return value ? write(*value) : json();
}
template <class T, std::size_t N>
json write_value(const std::array<T, N>& values) {
  json list = json::array();
  for (const T& value : values) list.push_back(write(value));
  return list;
}
template <class Enum>
std::enable_if_t<std::is_enum_v<Enum>, json> write_value(Enum value) {
  return EnumNames<Enum>::kAll[static_cast<std::size_t>(value)];
}

/// Writes the fields of an object that differ from their defaults.
template <class T>
json write(const T& value) {
  if constexpr (requires(FieldWriter & io, T & copy) { fields(io, copy); }) {
    FieldWriter own;
    FieldWriter other;
    T copy = value;
    T plain{};
    fields(own, copy);
    fields(other, plain);
    for (const auto& item : other.out.items()) {
      // Compared as text: -0 is not 0.
      if (own.out[item.key()].dump() == item.value().dump()) own.out.erase(item.key());
    }
    return std::move(own.out);
  } else {
    return write_value(value);
  }
}

[[noreturn]] void refuse(std::string_view field, std::string_view rule, std::string_view value) {
  throw SceneFileError(pbd::detail::must_be("write_scene: " + std::string(field), rule, value));
}

json write_body(const pbd::World& world, BodyId id) {
  const pbd::BodyProps& props = world.props(id);
  pbd::BodyDef def{.type = props.type,
                   .pose = world.pose(id),
                   .twist = world.twist(id),
                   .gravity_scale = props.gravity_scale,
                   .linear_damping = props.linear_damping,
                   .angular_damping = props.angular_damping,
                   .locks = props.locks,
                   .bullet = props.bullet,
                   .can_sleep = props.can_sleep,
                   .sleep_speed = props.sleep_speed,
                   .sleep_spin = props.sleep_spin,
                   .stable_id = props.stable_id,
                   .user_data = world.user_data(id),
                   .origin = props.origin};
  const bool dynamic = props.type == BodyType::Dynamic;
  if (dynamic) {
    def.mass = props.mass;
    def.inertia = props.inertia;
  }
  json body = write(def);
  if (dynamic) {
    body["mass"] = write(def.mass);
    body["inertia"] = write(def.inertia);
  }
  body["colliders"] = json::array();
  return body;
}

void check_rows(const pbd::World& world) {
  for (const auto& block : world.blocks()) {
    const pbd::ConstraintBlock* rows = block.get();
    const bool known = rows == static_cast<const pbd::ConstraintBlock*>(world.contacts()) ||
                       dynamic_cast<const pbd::JointBlock*>(rows) != nullptr;
    if (!known && !rows->empty()) {
      refuse("rows", "joints: files have no others", rows->name());
    }
  }
}

/// rad: start of a joint that is read again. Poses determine the rest if at most one angle is
/// beyond half a turn, as joints guarantee.
double turns(const pbd::JointState& state) {
  for (std::size_t i = 3; i < 6; ++i) {
    if (std::abs(state.position[i]) > std::numbers::pi) return state.position[i];
  }
  return 0.0;
}

json write_joints(const pbd::World& world, std::span<const SceneFile::Joint> named,
                  const std::unordered_map<std::uint32_t, std::size_t>& places) {
  json list = json::array();
  std::map<pbd::JointId, std::string> names;
  for (const SceneFile::Joint& joint : named) names[joint.joint] = joint.name;
  for (const auto& block : world.blocks()) {
    const auto* joints = dynamic_cast<const pbd::JointBlock*>(block.get());
    if (joints == nullptr) continue;
    for (const pbd::JointId id : pbd::joint_ids(*joints)) {
      pbd::SixDofJointDef def = joints->def(id);
      def.start = turns(joints->at(id));
      json joint = write(def);
      joint["type"] = "sixDof";
      if (def.a.valid()) joint["a"] = places.at(def.a.index);
      joint["b"] = places.at(def.b.index);
      if (const auto& name = names[id]; !name.empty()) joint["name"] = name;
      list.push_back(std::move(joint));
    }
  }
  return list;
}

}  // namespace
}  // namespace scene_files

std::string write_scene(const Scene& scene, std::span<const SceneFile::Body> bodies,
                        std::span<const SceneFile::Joint> joints) {
  using scene_files::json;
  const pbd::World& world = scene.world();
  scene_files::check_rows(world);
  json out{{"version", 1}, {"gravity", scene_files::write(world.gravity())}};
  json& list = out["bodies"] = json::array();
  std::unordered_map<std::uint32_t, std::size_t> places;  // index in the list, by slot
  for (std::uint32_t slot = 0; slot < world.slot_count(); ++slot) {
    const BodyId id = world.body_at(slot);
    if (!id.valid()) continue;
    places[slot] = list.size();
    list.push_back(scene_files::write_body(world, id));
  }
  for (const SceneFile::Body& body : bodies) {
    if (body.name.empty() || !world.contains(body.body)) continue;
    // One name each: links that are parts of a body come after it.
    list[places.at(body.body.index)].emplace("name", body.name);
  }
  const collision::CollisionScene& shapes = scene.shapes();
  for (std::uint32_t slot = 0; slot < shapes.slot_count(); ++slot) {
    const collision::ColliderId id = shapes.collider_at(slot);
    if (!id.valid()) continue;
    const collision::ColliderDef& def = shapes.collider(id);
    json collider = scene_files::write(def);
    collider["shape"] = scene_files::write(def.shape);
    list[places.at(def.body.index)]["colliders"].push_back(std::move(collider));
  }
  out["joints"] = scene_files::write_joints(world, joints, places);
  for (const pbd::BodyPair& pair : shapes.apart()) {
    out["apart"].push_back({places.at(pair.low), places.at(pair.high)});
  }
  try {
    return out.dump(1) + '\n';
  } catch (const json::exception& error) {
    scene_files::refuse("names", "UTF-8", error.what());
  }
}

std::string write_scene(const SceneFile& file) {
  return write_scene(file.scene, file.bodies, file.joints);
}

}  // namespace tandem
