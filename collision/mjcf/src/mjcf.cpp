// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/mjcf.h"

#include <mujoco/mujoco.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <memory>

#include "limit_count.h"
#include "read_bytes.h"
#include "xml_check.h"

namespace tandem {
namespace {

using Model = std::unique_ptr<mjModel, void (*)(mjModel*)>;

Vec3 vec(const mjtNum* v) { return {v[0], v[1], v[2]}; }
Pose pose_of(const mjtNum* position, const mjtNum* q) {
  return {vec(position), Quat(q[0], q[1], q[2], q[3]).normalized()};
}

/// Turns a compiled model into a scene.
class MjcfReader {
 public:
  MjcfReader(const mjModel& model, SceneFile& out, const SceneLimits& limits)
      : m_(model), out_(out), limits_(limits) {}

  void run() {
    frames_.resize(static_cast<std::size_t>(m_.nbody));
    ids_.resize(frames_.size());
    groups_.resize(frames_.size());
    // Parents come first.
    for (int b = 0; b < m_.nbody; ++b) body(b);
    for (int g = 0; g < m_.ngeom; ++g) geom(g);
    for (int b = 1; b < m_.nbody; ++b) joint(b);
    rest();
    scene_files::require_within("model", limits_.pairs(out_.scene));
  }

 private:
  std::string name(mjtObj kind, int id) const {
    const char* text = mj_id2name(&m_, kind, id);
    return text == nullptr ? std::string() : text;
  }
  std::string where(mjtObj kind, int id) const {
    const std::string text = name(kind, id);
    return std::string(mju_type2Str(kind)) + ' ' + (text.empty() ? std::to_string(id) : text);
  }
  void warn(mjtObj kind, int id, const char* what) {
    out_.warnings.push_back(where(kind, id) + ": " + what);
  }
  auto guard(mjtObj kind, int id, auto&& call) {
    try {
      return call();
    } catch (const std::invalid_argument& error) {
      throw SceneFileError(where(kind, id) + ": " + error.what());
    }
  }

  void body(int b) {
    const auto i = static_cast<std::size_t>(b);
    const auto parent = static_cast<std::size_t>(m_.body_parentid[b]);
    const Pose local = pose_of(m_.body_pos + 3 * b, m_.body_quat + 4 * b);
    const Pose& base = frames_[parent];
    frames_[i] = b == 0 ? local
                        : Pose{base.to_world(local.position),
                               (base.orientation * local.orientation).normalized()};
    pbd::BodyDef def{.pose = frames_[i]};
    if (m_.body_weldid[b] == 0) {
      def.type = BodyType::Static;
    } else {
      const Pose mass = pose_of(m_.body_ipos + 3 * b, m_.body_iquat + 4 * b);
      const pbd::Mat3 turn = mass.orientation.toRotationMatrix();
      def.origin = -mass.position;
      def.mass = m_.body_mass[b];
      def.inertia = turn * vec(m_.body_inertia + 3 * b).asDiagonal() * turn.transpose();
      def.pose.position = frames_[i].to_world(mass.position);
      const bool root = m_.body_weldid[m_.body_parentid[b]] == 0;
      groups_[i] = root ? out_.scene.new_group() : groups_[parent];
    }
    const std::string at = where(mjOBJ_BODY, b);
    scene_files::require_within(at, limits_.add(&SceneLimits::bodies));
    if (def.type != BodyType::Static) {
      scene_files::require_within(at, limits_.parts(static_cast<std::size_t>(m_.body_geomnum[b])));
    }
    ids_[i] = guard(mjOBJ_BODY, b, [&] { return out_.scene.world().add_body(def); });
    out_.bodies.push_back({name(mjOBJ_BODY, b), ids_[i]});
  }

  void geom(int g) {
    const auto b = static_cast<std::size_t>(m_.geom_bodyid[g]);
    const auto category = static_cast<std::uint32_t>(m_.geom_contype[g]);
    const auto mask = static_cast<std::uint32_t>(m_.geom_conaffinity[g]);
    if (category == 0 && mask == 0) return;  // for the eye alone
    if (category != mask) warn(mjOBJ_GEOM, g, "contype is not conaffinity: both must agree here");
    collision::ColliderDef def{.body = ids_[b],
                               .local = pose_of(m_.geom_pos + 3 * g, m_.geom_quat + 4 * g),
                               .material = {.friction = m_.geom_friction[3 * g],
                                            .friction_rule = collision::Combine::Maximum},
                               .filter = {category, mask, groups_[b]}};
    def.local.position += out_.scene.world().props(ids_[b]).origin;
    const mjtNum* size = m_.geom_size + 3 * g;
    switch (m_.geom_type[g]) {
      case mjGEOM_PLANE:
        def.shape = HalfSpace{};
        break;
      case mjGEOM_SPHERE:
        def.shape = Sphere{size[0]};
        break;
      case mjGEOM_CAPSULE:
        def.shape = Capsule{.radius = size[0], .half_height = size[1]};
        break;
      case mjGEOM_CYLINDER:
        def.shape = Cylinder{.radius = size[0], .half_height = size[1]};
        break;
      case mjGEOM_BOX:
        def.shape = Box(vec(size));
        break;
      case mjGEOM_MESH:
        def.shape = guard(mjOBJ_GEOM, g, [&] { return hull(m_.geom_dataid[g]); });
        break;
      default:
        return warn(mjOBJ_GEOM, g, "ellipsoids and height fields are not read");
    }
    scene_files::require_within(where(mjOBJ_GEOM, g), limits_.add(&SceneLimits::colliders));
    guard(mjOBJ_GEOM, g, [&] { return out_.scene.shapes().add(out_.scene.world(), def); });
  }

  /// MuJoCo's contacts are those of hulls, too.
  collision::Hull hull(int mesh) {
    collision::Hull& known = hulls_[mesh];
    if (known != nullptr) return known;
    scene_files::require_within(
        where(mjOBJ_MESH, mesh),
        limits_.add(&SceneLimits::hull_points, static_cast<std::size_t>(m_.mesh_vertnum[mesh])));
    std::vector<Vec3> points;
    for (int v = 0; v < m_.mesh_vertnum[mesh]; ++v) {
      const float* p = m_.mesh_vert + 3 * (m_.mesh_vertadr[mesh] + v);
      points.emplace_back(p[0], p[1], p[2]);
    }
    return known = collision::ConvexHull::make(points);
  }

  void joint(int b) {
    const auto i = static_cast<std::size_t>(b);
    if (m_.body_weldid[b] == 0) return;
    scene_files::require_within(where(mjOBJ_BODY, b), limits_.add(&SceneLimits::joints));
    const BodyId parent = ids_[static_cast<std::size_t>(m_.body_parentid[b])];
    const int first = m_.body_jntadr[b];
    const int count = m_.body_jntnum[b];
    const pbd::World& world = out_.scene.world();
    if (count == 0) {
      out_.scene.add_joint(pbd::fixed_joint_at(world, parent, ids_[i], frames_[i].position));
      return;
    }
    if (m_.jnt_type[first] == mjJNT_FREE) return;
    int lead = first;  // the one whose axis is x: the hinge, where there is one
    for (int j = first; j < first + count; ++j) {
      if (m_.jnt_type[j] != mjJNT_SLIDE) lead = j;
    }
    const Quat& turn = frames_[i].orientation;
    const Vec3 anchor = frames_[i].to_world(vec(m_.jnt_pos + 3 * lead));
    pbd::SixDofJointDef def =
        pbd::six_dof_joint_at(world, parent, ids_[i], anchor, turn * vec(m_.jnt_axis + 3 * lead));
    if (count > 1) set_axes(def, first, count, lead, i);
    for (auto* axes : {&def.linear, &def.angular}) {
      for (pbd::JointAxis& axis : *axes) axis.freedom = pbd::Freedom::Locked;
    }
    if (m_.jnt_type[lead] == mjJNT_BALL) {
      ball(def, lead);
    } else {
      def.angular[0].freedom = pbd::Freedom::Locked;
    }
    for (int j = first; j < first + count; ++j) {
      if (m_.jnt_type[j] == mjJNT_BALL && count == 1) continue;
      const bool hinge = m_.jnt_type[j] == mjJNT_HINGE;
      if ((hinge && j != lead) || m_.jnt_type[j] == mjJNT_BALL || j - first > 3) refuse(b);
      coordinate(hinge ? def.angular[0] : def.linear[along(def, j, i)], j);
    }
    const pbd::JointId id = guard(mjOBJ_JOINT, lead, [&] { return out_.scene.add_joint(def); });
    for (int j = first; j < first + count; ++j) out_.joints.push_back({name(mjOBJ_JOINT, j), id});
  }

  [[noreturn]] void refuse(int b) const {
    throw SceneFileError(where(mjOBJ_BODY, b) +
                         ": joints must be one, or slides at right angles and a hinge");
  }

  /// y along another of the axes, in both frames.
  void set_axes(pbd::SixDofJointDef& def, int first, int count, int lead, std::size_t i) const {
    const Quat& turn = frames_[i].orientation;
    const Vec3 x = (turn * vec(m_.jnt_axis + 3 * lead)).normalized();
    for (int j = first; j < first + count; ++j) {
      const Vec3 y = turn * vec(m_.jnt_axis + 3 * j);
      if (std::abs(x.dot(y)) > 1e-6) continue;
      pbd::Mat3 basis;
      basis << x, y, x.cross(y);
      const Quat world(basis);
      def.frame_a.basis =
          (out_.scene.world().pose(def.a).orientation.conjugate() * world).normalized();
      def.frame_b.basis =
          (out_.scene.world().pose(def.b).orientation.conjugate() * world).normalized();
      return;
    }
  }

  /// The linear coordinate that a slide is; free only once.
  std::size_t along(const pbd::SixDofJointDef& def, int j, std::size_t i) const {
    const Quat basis = out_.scene.world().pose(def.b).orientation * def.frame_b.basis;
    const Vec3 axis = basis.conjugate() * (frames_[i].orientation * vec(m_.jnt_axis + 3 * j));
    Eigen::Index at = 0;
    const bool straight = axis.cwiseAbs().maxCoeff(&at) > 1.0 - 1e-6 && axis[at] > 0.0;
    const auto k = static_cast<std::size_t>(at);
    if (!straight || def.linear[k].freedom != pbd::Freedom::Locked) refuse(static_cast<int>(i));
    return k;
  }

  void ball(pbd::SixDofJointDef& def, int j) {
    for (pbd::JointAxis& axis : def.angular) {
      axis = {};
      axis.spring.damping = m_.dof_damping[m_.jnt_dofadr[j]];
    }
    if (m_.jnt_limited[j]) {
      def.cone = m_.jnt_range[2 * j + 1];
      warn(mjOBJ_JOINT, j, "its range bounds the swing, not the twist");
    }
    if (m_.jnt_stiffness[j] != 0.0) warn(mjOBJ_JOINT, j, "springs of balls are not read");
  }

  void coordinate(pbd::JointAxis& axis, int j) {
    const int dof = m_.jnt_dofadr[j];
    const mjtNum zero = m_.qpos0[m_.jnt_qposadr[j]];
    axis.freedom = m_.jnt_limited[j] ? pbd::Freedom::Limited : pbd::Freedom::Free;
    if (m_.jnt_limited[j]) {
      axis.lower = m_.jnt_range[2 * j] - zero;
      axis.upper = m_.jnt_range[2 * j + 1] - zero;
    }
    axis.spring = {.stiffness = m_.jnt_stiffness[j],
                   .rest = m_.qpos_spring[m_.jnt_qposadr[j]] - zero,
                   .damping = m_.dof_damping[dof]};
    if (m_.dof_frictionloss[dof] != 0.0) warn(mjOBJ_JOINT, j, "frictionloss is not read");
    if (m_.dof_armature[dof] != 0.0) warn(mjOBJ_JOINT, j, "armature is not read");
  }

  /// What is counted alone.
  void rest() {
    const auto all = [&](mjtObj kind, int count) {
      for (int i = 0; i < count; ++i) warn(kind, i, "not read");
    };
    all(mjOBJ_ACTUATOR, m_.nu);
    all(mjOBJ_TENDON, m_.ntendon);
    all(mjOBJ_EQUALITY, m_.neq);
    all(mjOBJ_SENSOR, m_.nsensor);
    all(mjOBJ_EXCLUDE, m_.nexclude);
    all(mjOBJ_KEY, m_.nkey);
    if (m_.npair > 0) out_.warnings.push_back("contact pairs are not read");
    if (m_.opt.viscosity != 0.0 || m_.opt.density != 0.0) {
      out_.warnings.push_back("option: the medium's density and viscosity are not read");
    }
  }

  const mjModel& m_;
  SceneFile& out_;
  std::vector<Pose> frames_;  ///< world, by body
  std::vector<BodyId> ids_;
  std::vector<std::int32_t> groups_;  ///< of trees; 0: of the world
  std::map<int, collision::Hull> hulls_;
  scene_files::LimitCount limits_;
};

/// MuJoCo's own answer to an error is to write a file, wait for a key and end the process.
class ErrorsThrow {
 public:
  ErrorsThrow() {
    mju_user_error = [](const char* text) { throw SceneFileError(std::string("MuJoCo: ") + text); };
    mju_user_warning = [](const char*) {};
  }
  ErrorsThrow(const ErrorsThrow&) = delete;
  ErrorsThrow& operator=(const ErrorsThrow&) = delete;
  ~ErrorsThrow() {
    mju_user_error = error_;
    mju_user_warning = warning_;
  }

 private:
  void (*error_)(const char*) = mju_user_error;
  void (*warning_)(const char*) = mju_user_warning;
};

SceneFile build(const std::string& path, const mjVFS* files, const SceneOptions& options,
                std::string_view name, const SceneLimits& limits) {
  char error[1000] = "";
  const ErrorsThrow errors_throw;
  const Model model(mj_loadXML(path.c_str(), files, error, sizeof error), mj_deleteModel);
  const std::string file(name);
  if (!model) throw SceneFileError(pbd::detail::must_be(file + ": text", "MJCF", error));
  SceneOptions with = options;
  with.gravity = vec(model->opt.gravity);
  try {
    SceneFile out{.scene = Scene(with)};
    if (error[0] != '\0') out.warnings.push_back(std::string("MuJoCo: ") + error);
    MjcfReader(*model, out, limits).run();
    return out;
  } catch (const std::invalid_argument& refused) {
    throw SceneFileError(file + ": " + refused.what());
  }
}

}  // namespace

SceneFile load_mjcf(const std::filesystem::path& path, const SceneOptions& options,
                    const SceneLimits& limits) {
  scene_files::check_xml(scene_files::read_bytes(path), path.string());
  return build(path.string(), nullptr, options, path.string(), limits);
}

SceneFile parse_mjcf(std::string_view text, const SceneOptions& options, std::string_view name,
                     const SceneLimits& limits) {
  scene_files::check_xml(text, name);
  scene_files::refuse_files(text, name);
  if (text.empty()) {
    throw SceneFileError(pbd::detail::must_be(std::string(name) + ": text", "not empty"));
  }
  const auto files = std::make_unique<mjVFS>();  // too large for a stack
  mj_defaultVFS(files.get());
  mj_makeEmptyFileVFS(files.get(), "model.xml", static_cast<int>(text.size()));
  const std::unique_ptr<mjVFS, void (*)(mjVFS*)> closing(files.get(), mj_deleteVFS);
  std::memcpy(files->filedata[0], text.data(), text.size());
  return build("model.xml", files.get(), options, name, limits);
}

}  // namespace tandem
