// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/urdf.h"

#include <tinyxml.h>
#include <urdf_parser/urdf_parser.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_set>

#include "couple_joints.h"
#include "grouped_warnings.h"
#include "limit_count.h"
#include "listener.h"
#include "mesh_files.h"
#include "read_bytes.h"
#include "rigid_parts.h"
#include "start_in_range.h"
#include "xml_check.h"

namespace tandem {
namespace {

Vec3 vec(const urdf::Vector3& v) { return {v.x, v.y, v.z}; }
Pose pose_of(const urdf::Pose& pose) {
  return {vec(pose.position),
          Quat(pose.rotation.w, pose.rotation.x, pose.rotation.y, pose.rotation.z).normalized()};
}
Pose inverse(const Pose& pose) {
  const Quat back = pose.orientation.conjugate();
  return {-(back * pose.position), back};
}
Pose operator*(const Pose& a, const Pose& b) {
  return {a.to_world(b.position), (a.orientation * b.orientation).normalized()};
}

/// Builds a scene from a model.
class UrdfReader {
 public:
  UrdfReader(SceneFile& out, const UrdfOptions& options)
      : out_(out), options_(options), group_(out.scene.new_group()) {}

  /// Adds the root and its descendants, each link after its parent.
  void tree(const urdf::Link& root) {
    collect(root);
    for (Solid& solid : solids_) add_body(solid);
    for (const Link& link : links_) {
      const Solid& solid = solids_[link.solid];
      const Pose& own = solid.frame;
      const Pose in_body = link.link == solid.lead ? Pose{} : inverse(own) * link.frame;
      out_.bodies.push_back({link.link->name, solid.body, in_body});
      for (const auto& shape : link.link->collision_array) {
        add(link.link->name, *shape, solid.body, in_body, solid.origin);
      }
      if (link.link == solid.lead && link.link->parent_joint) {
        joint(*link.link->parent_joint, link.frame, solid);
      }
    }
    if (starts_found_ < options_.start.size()) {
      throw SceneFileError("UrdfOptions::start: names must be those of joints of the robot");
    }
    for (const Link& link : links_) mimic(*link.link);
    scene_files::require_within("robot", limits_.pairs(out_.scene));
    warnings_.append_to(out_.warnings);
  }

 private:
  /// Links that are fixed to each other: one body.
  struct Solid {
    const urdf::Link* lead = nullptr;  ///< the first link, whose frame is the body's
    Pose frame;                        ///< world
    std::size_t parent = 0;            ///< index in solids_
    bool fixed = false;                ///< fixed to the world
    scene_files::RigidParts parts;     ///< in the lead's frame
    std::size_t shapes = 0;
    double start = 0.0;          ///< m or rad, of the joint to its parent
    Vec3 origin = Vec3::Zero();  ///< m, from the centre of mass to the lead's frame
    BodyId body;
  };
  struct Link {
    const urdf::Link* link;
    Pose frame;         ///< world
    std::size_t solid;  ///< index in solids_
  };

  auto guard(const std::string& where, auto&& call) {
    try {
      return call();
    } catch (const std::invalid_argument& error) {
      throw SceneFileError(where + ": " + error.what());
    }
  }

  /// Fills links_ and solids_.
  void collect(const urdf::Link& root) {
    struct Open {
      const urdf::Link* link;
      Pose frame;          // at zero of its joint
      std::size_t parent;  // index in solids_
    };
    std::vector<Open> open{{&root, options_.base, 0}};
    std::unordered_set<const urdf::Link*> seen;
    while (!open.empty()) {
      Open at = open.back();
      open.pop_back();
      if (!seen.insert(at.link).second) {
        throw SceneFileError(pbd::detail::must_be("link " + at.link->name + ": joints to parents",
                                                  "one", "several"));
      }
      const urdf::JointSharedPtr& joint = at.link->parent_joint;
      const bool held = joint && joint->type == urdf::Joint::FIXED;
      const bool fixed = joint ? held && solids_[at.parent].fixed : options_.fixed_base;
      const bool part = held && !fixed;
      const double start = joint ? start_of(*joint) : 0.0;
      if (start != 0.0) at.frame = at.frame * motion(*joint, start);
      const std::size_t solid = part ? at.parent : solids_.size();
      if (!part) {
        solids_.push_back({.lead = at.link,
                           .frame = at.frame,
                           .parent = at.parent,
                           .fixed = fixed,
                           .start = start});
      }
      links_.push_back({at.link, at.frame, solid});
      solids_[solid].shapes += at.link->collision_array.size();
      if (!fixed) weigh(*at.link, at.frame, solids_[solid]);
      for (auto child = at.link->child_links.rbegin(); child != at.link->child_links.rend();
           ++child) {
        const urdf::Pose& origin = (*child)->parent_joint->parent_to_joint_origin_transform;
        open.push_back({child->get(), at.frame * pose_of(origin), solid});
      }
    }
  }

  /// Start of the joint: the caller's value or 0, or as near as its limits allow.
  double start_of(const urdf::Joint& joint) {
    const auto named = options_.start.find(joint.name);
    const double wanted = named == options_.start.end() ? 0.0 : named->second;
    starts_found_ += named == options_.start.end() ? 0 : 1;
    const bool slides = joint.type == urdf::Joint::PRISMATIC;
    const bool turns = joint.type == urdf::Joint::REVOLUTE || joint.type == urdf::Joint::CONTINUOUS;
    if (!slides && !turns) {
      if (named == options_.start.end()) return 0.0;
      guard("joint " + joint.name,
            [] { pbd::detail::refuse("UrdfOptions::start", "of joints that turn or slide"); });
    }
    const bool limited = joint.limits && joint.type != urdf::Joint::CONTINUOUS;
    if (!limited || !(joint.limits->lower <= joint.limits->upper)) return wanted;
    const scene_files::JointStart start =
        scene_files::start_in_range(wanted, joint.limits->lower, joint.limits->upper, turns);
    if (start.moved == 0.0) return wanted;
    warnings_.add(
        "joint",
        joint.name + " (by " + scene_files::short_number(start.moved) + (turns ? " rad)" : " m)"),
        "where it was to start is outside its limits: it starts at the nearest place");
    return start.at;
  }

  static Pose motion(const urdf::Joint& joint, double at) {
    const Vec3 axis = vec(joint.axis).normalized();
    if (joint.type == urdf::Joint::PRISMATIC) return {at * axis, Quat::Identity()};
    return {Vec3::Zero(), Quat(Eigen::AngleAxisd(at, axis))};
  }

  void weigh(const urdf::Link& link, const Pose& frame, Solid& solid) {
    if (!link.inertial) return;
    const std::string where = "link " + link.name;
    const urdf::Inertial& in = *link.inertial;
    const Pose at = &link == solid.lead ? pose_of(in.origin)
                                        : inverse(solid.frame) * frame * pose_of(in.origin);
    const pbd::Mat3 turn = at.orientation.toRotationMatrix();
    pbd::Mat3 inertia;
    inertia << in.ixx, in.ixy, in.ixz, in.ixy, in.iyy, in.iyz, in.ixz, in.iyz, in.izz;
    inertia = turn * inertia * turn.transpose();
    if (options_.strict) {
      guard(where, [&] { scratch_.add_body({.mass = in.mass, .inertia = inertia}); });
    }
    if (!(in.mass >= 0.0) || !std::isfinite(in.mass)) {
      guard(where, [&] { pbd::detail::refuse("mass", "finite and >= 0", in.mass); });
    }
    if (!inertia.allFinite() || !at.position.allFinite()) {
      guard(where, [&] { pbd::detail::refuse("inertia and its origin", "finite"); });
    }
    if (in.mass > 0.0) {
      solid.parts.add(in.mass, at.position, inertia);
    } else if (&link != solid.lead) {
      warnings_.add("link", link.name, "mass 0: a frame of what it is fixed to");
    }
  }

  void add_body(Solid& solid) {
    const std::string& name = solid.lead->name;
    const std::string where = "link " + name;
    scene_files::require_within(where, limits_.add(&SceneLimits::bodies));
    scene_files::require_within(where, limits_.parts(solid.shapes));
    pbd::BodyDef def{.pose = solid.frame};
    if (solid.fixed) {
      def.type = BodyType::Static;
    } else if (solid.parts.mass() > 0.0) {
      const Vec3 com = solid.parts.com();
      def.mass = solid.parts.mass();
      def.inertia = solid.parts.inertia();
      def.origin = solid.origin = -com;
      def.pose.position = solid.frame.to_world(com);
      mend(name, def);
    } else {
      warnings_.add("link", name,
                    solid.lead->inertial
                        ? "mass 0 of what moves by itself: it has UrdfOptions::tip_mass"
                        : "no <inertial>: its mass is UrdfOptions::tip_mass");
      def.mass = options_.tip_mass;
      def.inertia = pbd::Mat3::Identity() * ball(options_.tip_mass);
    }
    solid.body = guard(where, [&] { return out_.scene.world().add_body(def); });
  }

  double ball(double mass) const { return 0.4 * mass * options_.tip_radius * options_.tip_radius; }

  void mend(const std::string& name, pbd::BodyDef& def) {
    try {
      scratch_.add_body({.mass = def.mass, .inertia = def.inertia});
    } catch (const std::invalid_argument&) {
      const auto mended = scene_files::mend_inertia(def.inertia, ball(def.mass));
      if (!mended) return;  // World refuses it with a reason
      def.inertia = mended->inertia;
      warnings_.add("link",
                    name + " (by " + scene_files::short_number(100.0 * mended->change) + " %)",
                    "no body has its inertia, with what is fixed to it: it has the nearest one "
                    "(off by a share of the largest moment)");
    }
  }

  /// @param frame  of the link, in the body's. @param origin  of that from the centre of mass, m
  void add(const std::string& name, const urdf::Collision& collision, BodyId body,
           const Pose& frame, const Vec3& origin) {
    collision::ColliderDef def{
        .body = body, .local = frame * pose_of(collision.origin), .filter = {.group = group_}};
    def.local.position += origin;
    const std::string where = "link " + name;
    if (!collision.geometry) {
      return warnings_.add("link", name, "a <collision> without geometry is passed over");
    }
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
      case urdf::Geometry::MESH: {
        const auto& mesh = static_cast<const urdf::Mesh&>(*collision.geometry);
        auto hull =
            guard(where, [&] { return meshes_.hull(name, mesh.filename, vec(mesh.scale)); });
        if (hull == nullptr) return;
        def.shape = std::move(hull);
        break;
      }
    }
    scene_files::require_within(where, limits_.add(&SceneLimits::colliders));
    guard(where, [&] { return out_.scene.shapes().add(out_.scene.world(), def); });
  }

  void joint(const urdf::Joint& joint, const Pose& frame, const Solid& solid) {
    const std::string where = "joint " + joint.name;
    const auto warn = [&](const char* text) { warnings_.add("joint", joint.name, text); };
    if (joint.safety || joint.calibration) warn("safety and calibration are not read");
    if (joint.type == urdf::Joint::FLOATING) return;
    pbd::JointAxis axis;
    if (joint.dynamics) {
      axis.spring.damping = joint.dynamics->damping;
      axis.friction = joint.dynamics->friction;
      if (joint.type == urdf::Joint::PLANAR &&
          (axis.spring.damping != 0.0 || axis.friction != 0.0)) {
        warn("damping and friction of planar joints are not read");
      }
    }
    if (joint.limits && joint.type != urdf::Joint::CONTINUOUS) {
      axis.freedom = pbd::Freedom::Limited;
      axis.lower = joint.limits->lower;
      axis.upper = joint.limits->upper;
    }
    // Bounds for a motor that is turned on later; until then none holds the joint.
    if (joint.limits && joint.limits->effort > 0.0) axis.motor.max_force = joint.limits->effort;
    if (joint.limits && joint.limits->velocity > 0.0) axis.motor.max_speed = joint.limits->velocity;
    if (joint.type == urdf::Joint::FIXED) return;  // both belong to the world
    scene_files::require_within(where, limits_.add(&SceneLimits::joints));
    const Vec3 direction = frame.orientation * vec(joint.axis);
    const pbd::JointId id = guard(where, [&] {
      const auto& world = out_.scene.world();
      const BodyId parent = solids_[solid.parent].body;
      pbd::SixDofJointDef def =
          shaped(joint.type, axis,
                 pbd::six_dof_joint_at(world, parent, solid.body, frame.position, direction));
      if (solid.start != 0.0) {
        // Zero is where the file has it, not at the start.
        pbd::JointFrame& zero = def.frame_a;
        if (joint.type == urdf::Joint::PRISMATIC) {
          zero.anchor -= zero.basis * (solid.start * Vec3::UnitX());
        } else {
          zero.basis =
              (zero.basis * Quat(Eigen::AngleAxisd(-solid.start, Vec3::UnitX()))).normalized();
        }
        def.start = solid.start;
      }
      return out_.scene.add_joint(def);
    });
    out_.joints.push_back({joint.name, id});
  }

  void mimic(const urdf::Link& link) {
    if (!link.parent_joint || !link.parent_joint->mimic) return;
    const urdf::JointMimic& mimic = *link.parent_joint->mimic;
    const std::string& name = link.parent_joint->name;
    const bool kept = options_.mimic && scene_files::couple_joints(
                                            out_.scene, out_.find_joint(mimic.joint_name),
                                            out_.find_joint(name), mimic.multiplier, mimic.offset);
    if (!kept) warnings_.add("joint", name, "mimic is not kept: it moves freely");
  }

  /// @param def  frame with x along the joint's axis, or the plane's normal
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
  std::vector<Link> links_;
  std::vector<Solid> solids_;
  std::size_t starts_found_ = 0;
  pbd::World scratch_;  ///< checks whether a mass is valid
  scene_files::GroupedWarnings warnings_;
  scene_files::LimitCount limits_{options_.limits};
  urdf_files::MeshFiles meshes_{options_, limits_, warnings_};
};

/// Warns of elements that urdfdom ignores.
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
  urdf_files::Listener listener;
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
