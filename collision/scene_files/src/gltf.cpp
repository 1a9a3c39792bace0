// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <cmath>
#include <map>
#include <numbers>
#include <optional>

#include "gltf_buffers.h"
#include "gltf_joints.h"
#include "read_bytes.h"
#include "reader.h"

namespace tandem {
namespace scene_files {
namespace {

constexpr const char* kPhysics = "KHR_physics_rigid_bodies";
constexpr const char* kShapes = "KHR_implicit_shapes";

Quat about_x(double angle) { return Quat(Eigen::AngleAxisd(angle, Vec3::UnitX())); }

/// Where a node is, as far as it is no shear.
struct Frame {
  Pose pose;
  Vec3 scale = Vec3::Ones();
};

/// A body to be: nodes that move together.
struct Solid {
  std::string name;
  Pose pose;
  std::size_t node = 0;
  bool moves = false;  ///< has a motion
  std::vector<collision::ColliderDef> colliders;
};

class GltfReader {
 public:
  GltfReader(const Place& document, SceneFile& out, const std::filesystem::path& folder)
      : document_(document), out_(out), buffers_(document, folder) {}

  void run() {
    if (document_.has("nodes")) {
      const Place nodes = document_.at("nodes");
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
  /// All nodes from their roots, each once.
  void walk(const Place& nodes) {
    struct Step {
      std::size_t node;
      Frame parent;
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
    // Its y is up.
    const Frame root{.pose = {.orientation = about_x(0.5 * std::numbers::pi)}};
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

  static Frame frame(const Place& node, const Frame& parent) {
    if (node.has("matrix")) node.at("matrix").refuse("translation, rotation and scale instead");
    Frame local;
    if (node.has("translation")) read(node.at("translation"), local.pose.position);
    if (node.has("rotation")) read(node.at("rotation"), local.pose.orientation);
    if (node.has("scale")) read(node.at("scale"), local.scale);
    const Quat& turn = local.pose.orientation;
    if (!(std::abs(turn.norm() - 1.0) < 1e-3)) node.at("rotation").refuse("a unit quaternion");
    const bool even = (parent.scale - Vec3::Constant(parent.scale.x())).isZero(1e-9);
    if (!even && !turn.vec().isZero(1e-9)) node.refuse("not turned below a scale that is uneven");
    return {{parent.pose.to_world(parent.scale.cwiseProduct(local.pose.position)),
             (parent.pose.orientation * turn).normalized()},
            parent.scale.cwiseProduct(local.scale)};
  }

  /// @return the solid that the node and what hangs on it belongs to
  std::optional<std::size_t> visit(const Place& node, std::size_t index,
                                   std::optional<std::size_t> owner) {
    if (!node.has("extensions")) return owner;
    const Place extensions = node.at("extensions");
    if (!extensions.has(kPhysics)) return owner;
    const Place physics = extensions.at(kPhysics);
    const Frame& at = frames_[index];
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
      if (!collider.has("geometry")) continue;  // a trigger of other nodes, which have theirs
      std::size_t to = owner.value_or(solids_.size());
      if (to == solids_.size()) solids_.push_back({name, at.pose, index, false, {}});
      add_collider(collider, at, solids_[to], sensor);
    }
    return owner;
  }

  void add_collider(const Place& at, const Frame& frame, Solid& solid, bool sensor) {
    if (frame.scale.isZero(0.0)) return;
    collision::ColliderDef def{.sensor = sensor};
    const Quat back = solid.pose.orientation.conjugate();
    def.local = {solid.pose.to_local(frame.pose.position), back * frame.pose.orientation};
    const Place geometry = at.at("geometry");
    bool known = true;
    geometry.guard([&] { known = shape(geometry, frame.scale, def); });
    if (!known) return;
    if (at.has("physicsMaterial")) material(at.at("physicsMaterial"), def.material);
    if (at.has("collisionFilter")) filter(at.at("collisionFilter"), def.filter);
    solid.colliders.push_back(std::move(def));
  }

  /// @return false where it has none like it, and has said so
  bool shape(const Place& geometry, const Vec3& scale, collision::ColliderDef& def) {
    if (geometry.has("shape")) return implicit(geometry.at("shape"), scale, def);
    GltfBuffers::Mesh mesh;
    if (geometry.has("mesh")) {
      mesh = buffers_.mesh(geometry.at("mesh"));
    } else {
      const Place nodes = document_.at("nodes");
      const Place node_index = geometry.at("node");
      const Place node = nodes.pick(node_index);
      if (node.has("children")) node_index.warn("what hangs on the node is not part of the shape");
      mesh = buffers_.mesh(node.at("mesh"));
    }
    for (Vec3& point : mesh.points) point = point.cwiseProduct(scale);
    if (scale.prod() < 0.0) {
      for (auto& triangle : mesh.triangles) std::swap(triangle[1], triangle[2]);
    }
    bool hull = false;
    if (geometry.has("convexHull")) read(geometry.at("convexHull"), hull);
    if (hull) {
      def.shape = collision::ConvexHull::make(mesh.points);
    } else {
      def.shape = collision::TriangleMesh::make(mesh.points, mesh.triangles);
    }
    return true;
  }

  bool implicit(const Place& index, const Vec3& signed_scale, collision::ColliderDef& def) {
    const Place extensions = document_.at("extensions");
    const Place family = extensions.at(kShapes);
    const Place shapes = family.at("shapes");
    const Place shape = shapes.pick(index);
    const std::string type = shape.at("type").text();
    const Vec3 scale = signed_scale.cwiseAbs();
    const Place values = shape.has(type.c_str()) ? shape.at(type.c_str()) : shape;
    const auto number = [&](const char* key, double other) {
      return values.has(key) ? values.at(key).number() : other;
    };
    const bool round = std::abs(scale.x() - scale.z()) <= 1e-9 * scale.x();
    const bool even = round && std::abs(scale.x() - scale.y()) <= 1e-9 * scale.x();
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
    // Along y there, along z here.
    def.local.orientation = def.local.orientation * about_x(-0.5 * std::numbers::pi);
    if (top == bottom && type == "capsule") {
      def.shape = Capsule{.radius = top, .half_height = half};
    } else if (top == bottom) {
      def.shape = Cylinder{.radius = top, .half_height = half};
    } else if (type == "cylinder" && (top == 0.0 || bottom == 0.0)) {
      def.shape = Cone{.radius = top + bottom, .half_height = half};
      if (bottom == 0.0) def.local.orientation = def.local.orientation * about_x(std::numbers::pi);
    } else {
      return shape.warn("shapes with two radii are not read"), false;
    }
    return true;
  }

  void material(const Place& index, collision::Material& out) {
    const Place extensions = document_.at("extensions");
    const Place physics = extensions.at(kPhysics);
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

  void filter(const Place& index, collision::Filter& out) {
    const Place extensions = document_.at("extensions");
    const Place physics = extensions.at(kPhysics);
    const Place filters = physics.at("collisionFilters");
    const Place filter = filters.pick(index);
    const auto bits = [&](const char* key) {
      std::uint32_t sum = 0;
      const Place names = filter.at(key);
      for (std::size_t i = 0; i < names.size(); ++i) {
        const Place name = names.at(i);
        // The first one is that of colliders in no system.
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
  }

  /// What a body weighs, by its colliders unless its motion says so.
  static collision::MassProperties weigh(const Place& motion, const Solid& solid) {
    std::vector<collision::CompoundPart> parts;
    for (const collision::ColliderDef& def : solid.colliders) {
      if (!def.sensor) parts.push_back({def.shape, def.local, 1000.0});
    }
    collision::MassProperties matter{.mass = 1.0, .inertia = 0.4 * pbd::Mat3::Identity()};
    const bool own = motion.has("mass") && motion.has("inertiaDiagonal");
    if (!own && parts.empty()) motion.warn("no collider to weigh: inertia of a ball of 1 m");
    if (!own && !parts.empty()) matter = collision::mass_properties(parts);
    if (motion.has("centerOfMass")) read(motion.at("centerOfMass"), matter.com);
    if (motion.has("mass")) {
      const double mass = motion.at("mass").number();
      matter.inertia *= mass / matter.mass;
      matter.mass = mass;
    }
    if (motion.has("inertiaDiagonal")) {
      Vec3 moments;
      Quat turn = Quat::Identity();
      read(motion.at("inertiaDiagonal"), moments);
      if (motion.has("inertiaOrientation")) read(motion.at("inertiaOrientation"), turn);
      const pbd::Mat3 axes = turn.normalized().toRotationMatrix();
      matter.inertia = axes * moments.asDiagonal() * axes.transpose();
    }
    return matter;
  }

  void add(const Place& nodes, Solid& solid, std::int32_t group) {
    const Place node = nodes.at(solid.node);
    pbd::BodyDef def{.type = BodyType::Static, .pose = solid.pose};
    if (solid.moves) {
      const Place extensions = node.at("extensions");
      const Place physics = extensions.at(kPhysics);
      const Place motion = physics.at("motion");
      motion.guard([&] { set_motion(motion, solid, def); });
    }
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
      if (!extensions.has(kPhysics)) continue;
      const Place physics = extensions.at(kPhysics);
      if (!physics.has("joint")) continue;
      const Place joint = physics.at("joint");
      const Place other = joint.at("connectedNode");
      nodes.pick(other);
      const auto to = other.value().get<std::size_t>();
      Joined one{owners_[i], owners_[to], frames_[i].pose, frames_[to].pose, 0, false, {}};
      const Place root = document_.at("extensions");
      const Place family = root.at(kPhysics);
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
  GltfBuffers buffers_;
  std::vector<Frame> frames_;                       ///< world, by node
  std::vector<std::optional<std::size_t>> owners_;  ///< the solid that it moves with, by node
  std::vector<Solid> solids_;
  std::map<std::string, std::uint32_t> systems_;
  std::map<std::int64_t, collision::Material> materials_;
  std::optional<GltfJoints> joints_;
};

}  // namespace
}  // namespace scene_files

SceneFile load_gltf(const std::filesystem::path& path, const SceneOptions& options) {
  return parse_gltf(scene_files::read_bytes(path), path.parent_path(), options, path.string());
}

SceneFile parse_gltf(std::string_view text, const std::filesystem::path& folder,
                     const SceneOptions& options, std::string_view name) {
  const scene_files::json document = scene_files::parse_document(text, name);
  scene_files::Reading reading{name, {}};
  const scene_files::Place at(document, reading);
  const scene_files::Place asset = at.at("asset");
  if (asset.at("version").text().rfind("2.", 0) != 0) asset.at("version").refuse("2.x");
  std::optional<SceneFile> out;
  at.guard([&] { out.emplace(SceneFile{.scene = Scene(options)}); });
  scene_files::GltfReader(at, *out, folder).run();
  out->warnings = std::move(reading.warnings);
  return std::move(*out);
}

}  // namespace tandem
