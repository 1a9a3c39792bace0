// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/urdf.h"

#include <console_bridge/console.h>
#include <tinyxml.h>
#include <urdf_parser/urdf_parser.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_set>

#include "limit_count.h"
#include "read_bytes.h"
#include "xml_check.h"

namespace tandem {
namespace {

Vec3 vec(const urdf::Vector3& v) { return {v.x, v.y, v.z}; }
Pose pose_of(const urdf::Pose& pose) {
  return {vec(pose.position),
          Quat(pose.rotation.w, pose.rotation.x, pose.rotation.y, pose.rotation.z).normalized()};
}
Pose operator*(const Pose& a, const Pose& b) {
  return {a.to_world(b.position), (a.orientation * b.orientation).normalized()};
}

/// Collects a model into a scene.
class UrdfReader {
 public:
  UrdfReader(SceneFile& out, const UrdfOptions& options)
      : out_(out), options_(options), group_(out.scene.new_group()) {}

  /// The root and all that hangs on it, each link behind the one that it hangs on.
  void tree(const urdf::Link& root) {
    struct Place {
      const urdf::Link* link;
      Pose frame;
      BodyId parent;
    };
    std::vector<Place> open{{&root, options_.base, {}}};
    std::unordered_set<const urdf::Link*> seen;
    while (!open.empty()) {
      const Place at = open.back();
      open.pop_back();
      if (!seen.insert(at.link).second) {
        throw SceneFileError(pbd::detail::must_be("link " + at.link->name + ": joints to parents",
                                                  "one", "several"));
      }
      const BodyId id = body(*at.link, at.frame);
      out_.bodies.push_back({at.link->name, id});
      if (at.link->parent_joint) joint(*at.link->parent_joint, at.frame, at.parent, id);
      for (auto child = at.link->child_links.rbegin(); child != at.link->child_links.rend();
           ++child) {
        const urdf::Pose& origin = (*child)->parent_joint->parent_to_joint_origin_transform;
        open.push_back({child->get(), at.frame * pose_of(origin), id});
      }
    }
    scene_files::require_within("robot", limits_.pairs(out_.scene));
  }

 private:
  auto guard(const std::string& where, auto&& call) {
    try {
      return call();
    } catch (const std::invalid_argument& error) {
      throw SceneFileError(where + ": " + error.what());
    }
  }

  void warn(const std::string& where, std::string_view what) {
    out_.warnings.push_back(where + ": " + std::string(what));
  }

  BodyId body(const urdf::Link& link, const Pose& frame) {
    const std::string where = "link " + link.name;
    scene_files::require_within(where, limits_.add(&SceneLimits::bodies));
    scene_files::require_within(where, limits_.parts(link.collision_array.size()));
    const bool root = link.parent_joint == nullptr;
    pbd::BodyDef def{.pose = frame};
    if (root && options_.fixed_base) {
      def.type = BodyType::Static;
    } else if (link.inertial) {
      const urdf::Inertial& in = *link.inertial;
      const Pose at = pose_of(in.origin);
      const pbd::Mat3 turn = at.orientation.toRotationMatrix();
      pbd::Mat3 inertia;
      inertia << in.ixx, in.ixy, in.ixz, in.ixy, in.iyy, in.iyz, in.ixz, in.iyz, in.izz;
      def.mass = in.mass;
      def.inertia = turn * inertia * turn.transpose();
      def.origin = -at.position;
      def.pose.position = frame.to_world(at.position);
    } else {
      warn(where, "no <inertial>: its mass is UrdfOptions::tip_mass");
      def.mass = options_.tip_mass;
      def.inertia = pbd::Mat3::Identity() * 0.4 * options_.tip_mass * options_.tip_radius *
                    options_.tip_radius;
    }
    const BodyId id = guard(where, [&] { return out_.scene.world().add_body(def); });
    for (const auto& collision : link.collision_array) add(where, *collision, id, def.origin);
    return id;
  }

  void add(const std::string& where, const urdf::Collision& collision, BodyId body,
           const Vec3& origin) {
    collision::ColliderDef def{
        .body = body, .local = pose_of(collision.origin), .filter = {.group = group_}};
    def.local.position += origin;
    if (!collision.geometry) return warn(where, "a <collision> without geometry is passed over");
    switch (collision.geometry->type) {
      case urdf::Geometry::SPHERE:
        def.shape = Sphere{static_cast<const urdf::Sphere&>(*collision.geometry).radius};
        break;
      case urdf::Geometry::BOX:
        def.shape = Box(0.5 * vec(static_cast<const urdf::Box&>(*collision.geometry).dim));
        break;
      case urdf::Geometry::CYLINDER: {
        const auto& round = static_cast<const urdf::Cylinder&>(*collision.geometry);
        def.shape = Cylinder{.radius = round.radius, .half_height = 0.5 * round.length};
        break;
      }
      case urdf::Geometry::MESH:
        return warn(where, "the mesh " +
                               static_cast<const urdf::Mesh&>(*collision.geometry).filename +
                               " is not read");
    }
    scene_files::require_within(where, limits_.add(&SceneLimits::colliders));
    guard(where, [&] { return out_.scene.shapes().add(out_.scene.world(), def); });
  }

  void joint(const urdf::Joint& joint, const Pose& frame, BodyId parent, BodyId child) {
    const std::string where = "joint " + joint.name;
    if (joint.mimic) warn(where, "mimic is not kept: it moves freely");
    if (joint.safety || joint.calibration) warn(where, "safety and calibration are not read");
    if (joint.type == urdf::Joint::FLOATING) return;
    pbd::JointAxis axis;
    if (joint.dynamics) {
      axis.spring.damping = joint.dynamics->damping;
      if (joint.dynamics->friction != 0.0) warn(where, "friction is not read");
    }
    if (joint.limits && joint.type != urdf::Joint::CONTINUOUS) {
      axis.freedom = pbd::Freedom::Limited;
      axis.lower = joint.limits->lower;
      axis.upper = joint.limits->upper;
    }
    // What a motor may do, once it is turned on; none holds it until then.
    if (joint.limits && joint.limits->effort > 0.0) axis.motor.max_force = joint.limits->effort;
    if (joint.limits && joint.limits->velocity > 0.0) axis.motor.max_speed = joint.limits->velocity;
    scene_files::require_within(where, limits_.add(&SceneLimits::joints));
    // Fixed ones say none.
    const Vec3 direction = joint.type == urdf::Joint::FIXED
                               ? Vec3::UnitX()
                               : Vec3(frame.orientation * vec(joint.axis));
    const pbd::JointId id = guard(where, [&] {
      const auto& world = out_.scene.world();
      return out_.scene.add_joint(
          shaped(joint.type, axis,
                 pbd::six_dof_joint_at(world, parent, child, frame.position, direction)));
    });
    out_.joints.push_back({joint.name, id});
  }

  /// @param def  with x along the joint's axis, or the plane's normal
  static pbd::SixDofJointDef shaped(int type, const pbd::JointAxis& axis, pbd::SixDofJointDef def) {
    for (auto* axes : {&def.linear, &def.angular}) {
      for (pbd::JointAxis& one : *axes) one.freedom = pbd::Freedom::Locked;
    }
    if (type == urdf::Joint::PRISMATIC) def.linear[0] = axis;
    if (type == urdf::Joint::REVOLUTE || type == urdf::Joint::CONTINUOUS) def.angular[0] = axis;
    if (type == urdf::Joint::PLANAR) {
      def.linear[1].freedom = def.linear[2].freedom = pbd::Freedom::Free;
      def.angular[0].freedom = pbd::Freedom::Free;
    }
    return def;
  }

  SceneFile& out_;
  const UrdfOptions& options_;
  std::int32_t group_;
  scene_files::LimitCount limits_{options_.limits};
};

/// What urdfdom says goes to the error message, not to the terminal.
class Listener final : public console_bridge::OutputHandler {
 public:
  Listener() { console_bridge::useOutputHandler(this); }
  ~Listener() override { console_bridge::restorePreviousOutputHandler(); }
  void log(const std::string& text, console_bridge::LogLevel level, const char*, int) override {
    if (level >= console_bridge::CONSOLE_BRIDGE_LOG_WARN && said.size() < 2000) said += text + "; ";
  }
  std::string said;
};

/// Elements that urdfdom passes over: whoever reads the result should know.
void warn_of_unknown(const std::string& text, std::vector<std::string>& warnings) {
  TiXmlDocument document;
  document.Parse(text.c_str());
  const TiXmlElement* robot = document.RootElement();
  if (robot == nullptr) return;
  constexpr std::array kKnown{"link", "joint", "material"};
  for (const auto* child = robot->FirstChildElement(); child; child = child->NextSiblingElement()) {
    if (std::find(kKnown.begin(), kKnown.end(), child->ValueStr()) == kKnown.end()) {
      warnings.push_back("<" + child->ValueStr() + ">, line " + std::to_string(child->Row()) +
                         ": not read");
    }
  }
}

}  // namespace

SceneFile parse_urdf(std::string_view text, const UrdfOptions& options, std::string_view name) {
  const std::string file(name);
  scene_files::check_xml(text, name);
  const std::string copy(text);
  urdf::ModelInterfaceSharedPtr model;
  Listener listener;
  try {
    model = urdf::parseURDF(copy);
  } catch (const std::exception& error) {
    listener.said += error.what();
  }
  if (!model || !model->getRoot()) {
    throw SceneFileError(pbd::detail::must_be(file + ": text", "URDF", listener.said));
  }
  try {
    SceneFile out{.scene = Scene(options.scene)};
    UrdfReader(out, options).tree(*model->getRoot());
    if (!listener.said.empty()) out.warnings.push_back("urdfdom: " + listener.said);
    warn_of_unknown(copy, out.warnings);
    return out;
  } catch (const std::invalid_argument& error) {
    throw SceneFileError(file + ": " + error.what());
  }
}

SceneFile load_urdf(const std::filesystem::path& path, const UrdfOptions& options) {
  return parse_urdf(scene_files::read_bytes(path), options, path.string());
}

}  // namespace tandem
