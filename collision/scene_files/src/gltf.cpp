// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <cmath>
#include <numbers>
#include <optional>

#include "gltf_colliders.h"
#include "gltf_extensions.h"
#include "gltf_joints.h"
#include "nearest_hull.h"
#include "read_bytes.h"
#include "reader.h"
#include "rigid_parts.h"

namespace tandem {
namespace scene_files {
namespace {

/// A future body: nodes that move together.
struct Solid {
  std::string name;
  Pose pose;
  std::size_t node = 0;
  bool moves = false;  ///< has a motion
  std::vector<collision::ColliderDef> colliders;
};

class GltfReader {
 public:
  GltfReader(const Place& document, SceneFile& out, const GltfSources& sources)
      : document_(document), out_(out), colliders_(document, sources) {}

  void run() {
    if (document_.has("nodes")) {
      const Place nodes = document_.at("nodes");
      nodes.count(&SceneLimits::nodes, nodes.size());
      frames_.resize(nodes.size());
      owners_.resize(nodes.size());
      walk(nodes);
      joints_.emplace(document_, out_);
      for (Joined& joined : find_joints(nodes)) joints_->add(std::move(joined));
      const std::vector<std::int32_t> groups = joints_->groups(solids_.size());
      for (std::size_t i = 0; i < solids_.size(); ++i) add(nodes, solids_[i], groups[i]);
      joints_->build();
    }
    for (const char* key : {"animations", "skins"}) {
      if (document_.has(key)) document_.at(key).warn("not read");
    }
  }

 private:
  /// Visits all nodes from their roots, each once.
  void walk(const Place& nodes) {
    struct Step {
      std::size_t node;
      GltfFrame parent;
      std::optional<std::size_t> owner;
    };
    std::vector<std::uint8_t> child(nodes.size(), 0);
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const Place node = nodes.at(i);
      if (!node.has("children")) continue;
      const Place children = node.at("children");
      for (std::size_t k = 0; k < children.size(); ++k) {
        const Place index = children.at(k);
        nodes.pick(index);
        std::uint8_t& known = child[index.value().get<std::size_t>()];
        if (known != 0) index.refuse("a node with one parent");
        known = 1;
      }
    }
    // glTF has y up.
    const GltfFrame root{.pose = {.orientation = gltf_about_x(0.5 * std::numbers::pi)}};
    std::vector<Step> open;
    for (std::size_t i = nodes.size(); i-- > 0;) {
      if (child[i] == 0) open.push_back({i, root, {}});
    }
    while (!open.empty()) {
      Step step = open.back();
      open.pop_back();
      const Place node = nodes.at(step.node);
      step.parent = frame(node, step.parent);
      frames_[step.node] = step.parent;
      step.owner = visit(node, step.node, step.owner);
      owners_[step.node] = step.owner;
      if (!node.has("children")) continue;
      const Place children = node.at("children");
      for (std::size_t k = children.size(); k-- > 0;) {
        open.push_back({children.at(k).value().get<std::size_t>(), step.parent, step.owner});
      }
    }
  }

  static GltfFrame frame(const Place& node, const GltfFrame& parent) {
    if (node.has("matrix")) node.at("matrix").refuse("translation, rotation and scale instead");
    GltfFrame local;
    if (node.has("translation")) read(node.at("translation"), local.pose.position);
    if (node.has("rotation")) read(node.at("rotation"), local.pose.orientation);
    if (node.has("scale")) read(node.at("scale"), local.scale);
    const Quat& turn = local.pose.orientation;
    if (!(std::abs(turn.norm() - 1.0) < 1e-3)) node.at("rotation").refuse("a unit quaternion");
    const double size = parent.scale.cwiseAbs().maxCoeff();
    const bool even =
        (parent.scale - Vec3::Constant(parent.scale.x())).isZero(kGltfRoundOff * size);
    if (parent.sheared && !local.pose.position.isZero(0.0)) {
      node.at("translation").refuse("none below a rotation that is below a scale that is uneven");
    }
    return {{parent.pose.to_world(parent.scale.cwiseProduct(local.pose.position)),
             (parent.pose.orientation * turn).normalized()},
            parent.scale.cwiseProduct(local.scale),
            parent.sheared || (!even && !turn.vec().isZero(kGltfRoundOff))};
  }

  /// @return the solid of the node and its descendants
  std::optional<std::size_t> visit(const Place& node, std::size_t index,
                                   std::optional<std::size_t> owner) {
    if (!node.has("extensions")) return owner;
    const Place extensions = node.at("extensions");
    if (!extensions.has(kGltfPhysics)) return owner;
    const Place physics = extensions.at(kGltfPhysics);
    const GltfFrame& at = frames_[index];
    std::string name;
    if (node.has("name")) read(node.at("name"), name);
    const bool moves = physics.has("motion");
    if (moves) {
      owner = solids_.size();
      solids_.push_back({name, at.pose, index, true, {}});
    }
    for (const bool sensor : {false, true}) {
      const char* key = sensor ? "trigger" : "collider";
      if (!physics.has(key)) continue;
      const Place collider = physics.at(key);
      if (!collider.has("geometry")) continue;  // a trigger of other nodes, which have their own
      // Frames of joints may have one: there the scale counts for the place alone.
      if (at.sheared) node.refuse("without a rotation below a scale that is uneven");
      std::size_t to = owner.value_or(solids_.size());
      if (to == solids_.size()) solids_.push_back({name, at.pose, index, false, {}});
      collider.count(&SceneLimits::colliders);
      colliders_.add(collider, at, sensor, solids_[to].pose, solids_[to].colliders);
    }
    return owner;
  }

  /// Of a moment of 0, which stands for infinity, to the largest other one.
  static constexpr double kInfinite = 1e6;
  static constexpr double kSmallBall = 4e-5;  ///< m^2, moment by mass of a ball of 1 cm

  /// The hull of an open mesh, which has no volume; all other shapes as they are.
  static collision::Shape closed(const Place& motion, const collision::Shape& shape) {
    const auto* mesh = std::get_if<collision::Mesh>(&shape);
    if (mesh == nullptr || (*mesh)->closed() || motion.strict()) return shape;
    motion.warn("a mesh with a border has the mass of its hull");
    const auto points = (*mesh)->vertices();
    motion.count(&SceneLimits::hull_points, points.size());
    return nearest_hull(points, false, [](const std::string&) {});
  }

  /// Mass properties of a body, from its colliders unless its motion gives them.
  static collision::MassProperties weigh(const Place& motion, const Solid& solid) {
    collision::MassProperties matter{.mass = 1.0, .inertia = 0.4 * pbd::Mat3::Identity()};
    Vec3 moments = Vec3::Zero();
    if (motion.has("inertiaDiagonal")) read(motion.at("inertiaDiagonal"), moments);
    const bool own = motion.has("mass") && !moments.isZero(0.0);
    std::vector<collision::CompoundPart> parts;
    for (const collision::ColliderDef& def : solid.colliders) {
      if (!own && !def.sensor) parts.push_back({closed(motion, def.shape), def.local, 1000.0});
    }
    if (!own && parts.empty()) motion.warn("no collider to weigh: inertia of a ball of 1 m");
    if (!parts.empty()) matter = collision::mass_properties(parts);
    if (motion.has("centerOfMass")) read(motion.at("centerOfMass"), matter.com);
    if (motion.has("mass")) {
      const double mass = motion.at("mass").number();
      matter.inertia *= mass / matter.mass;
      matter.mass = mass;
    }
    if (!moments.isZero(0.0)) {
      Quat turn = Quat::Identity();
      if (motion.has("inertiaOrientation")) read(motion.at("inertiaOrientation"), turn);
      const pbd::Mat3 axes = turn.normalized().toRotationMatrix();
      const double infinite = kInfinite * moments.maxCoeff();
      for (double& moment : moments) {
        if (moment == 0.0) moment = infinite;
      }
      matter.inertia = axes * moments.asDiagonal() * axes.transpose();
      const auto mended = mend_inertia(matter.inertia, kSmallBall * matter.mass);
      if (mended && mended->change > kGltfRoundOff && !motion.strict()) {
        motion.at("inertiaDiagonal").warn("no body has it: the nearest one is used");
        matter.inertia = mended->inertia;
      }
    }
    return matter;
  }

  void add(const Place& nodes, Solid& solid, std::int32_t group) {
    const Place node = nodes.at(solid.node);
    pbd::BodyDef def{.type = BodyType::Static, .pose = solid.pose};
    if (solid.moves) {
      const Place extensions = node.at("extensions");
      const Place physics = extensions.at(kGltfPhysics);
      const Place motion = physics.at("motion");
      motion.guard([&] { set_motion(motion, solid, def); });
    }
    node.count(&SceneLimits::bodies);
    node.guard([&] {
      const BodyId id = out_.scene.world().add_body(def);
      out_.bodies.push_back({solid.name, id});
      for (collision::ColliderDef& collider : solid.colliders) {
        collider.body = id;
        collider.local.position += def.origin;
        if (group != 0) collider.filter.group = group;
        out_.scene.shapes().add(out_.scene.world(), collider);
      }
    });
  }

  static void set_motion(const Place& motion, const Solid& solid, pbd::BodyDef& def) {
    Reader io(motion);
    bool kinematic = false;
    Vec3 linear = Vec3::Zero();
    Vec3 angular = Vec3::Zero();
    io("isKinematic", kinematic);
    io("linearVelocity", linear);
    io("angularVelocity", angular);
    io("gravityFactor", def.gravity_scale);
    for (const char* key : {"mass", "centerOfMass", "inertiaDiagonal", "inertiaOrientation"}) {
      io.has(key);
    }
    io.finish();
    if (motion.has("mass") && motion.at("mass").number() == 0.0) {
      motion.at("mass").warn("0 stands for an infinite mass: the body is kinematic");
      kinematic = true;
    }
    def.type = kinematic ? BodyType::Kinematic : BodyType::Dynamic;
    def.twist = {solid.pose.orientation * linear, solid.pose.orientation * angular};
    if (kinematic) return;
    const collision::MassProperties matter = weigh(motion, solid);
    if (motion.has("inertiaDiagonal")) {
      Vec3 moments;
      read(motion.at("inertiaDiagonal"), moments);
      // About all axes alike, so that those of the world may be locked.
      if (moments.isZero(0.0)) def.locks.angular.fill(true);
      if (!moments.isZero(0.0) && (moments.array() == 0.0).any()) {
        motion.at("inertiaDiagonal").warn("0 stands for infinity: 1e6 times the largest");
      }
    }
    def.mass = matter.mass;
    def.inertia = matter.inertia;
    def.origin = -matter.com;
    def.pose.position = solid.pose.to_world(matter.com);
  }

  /// Nodes with joints, and the solids of both ends.
  std::vector<Joined> find_joints(const Place& nodes) {
    std::vector<Joined> list;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const Place node = nodes.at(i);
      if (!node.has("extensions")) continue;
      const Place extensions = node.at("extensions");
      if (!extensions.has(kGltfPhysics)) continue;
      const Place physics = extensions.at(kGltfPhysics);
      if (!physics.has("joint")) continue;
      const Place joint = physics.at("joint");
      const Place other = joint.at("connectedNode");
      nodes.pick(other);
      const auto to = other.value().get<std::size_t>();
      joint.count(&SceneLimits::joints);
      Joined one{owners_[i], owners_[to], frames_[i].pose, frames_[to].pose, 0, false, {}};
      const Place root = document_.at("extensions");
      const Place family = root.at(kGltfPhysics);
      const Place all = family.at("physicsJoints");
      const Place which = joint.at("joint");
      all.pick(which);
      one.description = which.value().get<std::size_t>();
      if (joint.has("enableCollision")) read(joint.at("enableCollision"), one.meet);
      if (node.has("name")) read(node.at("name"), one.name);
      if (!one.a && !one.b) joint.refuse("between nodes one of which moves");
      list.push_back(std::move(one));
    }
    return list;
  }

  const Place& document_;
  SceneFile& out_;
  GltfColliders colliders_;
  std::vector<GltfFrame> frames_;                   ///< world, by node
  std::vector<std::optional<std::size_t>> owners_;  ///< by node, the solid that it moves with
  std::vector<Solid> solids_;
  std::optional<GltfJoints> joints_;
};

}  // namespace
}  // namespace scene_files

SceneFile load_gltf(const std::filesystem::path& path, const SceneOptions& options,
                    const SceneLimits& limits, bool strict) {
  return parse_gltf(scene_files::read_bytes(path), path.parent_path(), options, path.string(),
                    limits, strict);
}

SceneFile parse_gltf(std::string_view text, const std::filesystem::path& folder,
                     const SceneOptions& options, std::string_view name, const SceneLimits& limits,
                     bool strict) {
  const auto parts = scene_files::GltfContainer::of(text, name);
  scene_files::json document = scene_files::parse_document(parts.document, name);
  scene_files::rewrite_omi_physics(document);
  scene_files::Reading reading{
      .file = name, .limits = scene_files::LimitCount(limits), .strict = strict};
  const scene_files::Place at(document, reading);
  const scene_files::Place asset = at.at("asset");
  if (asset.at("version").text().rfind("2.", 0) != 0) asset.at("version").refuse("2.x");
  scene_files::check_gltf_extensions(at);
  std::optional<SceneFile> out;
  at.guard([&] { out.emplace(SceneFile{.scene = Scene(options)}); });
  scene_files::GltfReader(at, *out, {folder, parts.binary}).run();
  scene_files::require_within(std::string(name), reading.limits.pairs(out->scene));
  out->warnings = std::move(reading.warnings);
  return std::move(*out);
}

}  // namespace tandem
