// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "mjcf_reader.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "couple_joints.h"
#include "mjcf_actuators.h"
#include "mjcf_between.h"
#include "start_in_range.h"

namespace tandem::mjcf {

void Reader::run() {
  bodies_.resize(static_cast<std::size_t>(m_.nbody));
  // Parents come first.
  for (int b = 0; b < m_.nbody; ++b) place(b);
  for (int b = 0; b < m_.nbody; ++b) add_body(b);
  const Filters filters(model_);
  for (int g = 0; g < m_.ngeom; ++g) add_geom(g, filters);
  for (int b = 1; b < m_.nbody; ++b) add_joints(b);
  start();
  tell_rest();
  scene_files::require_within("model", limits_.pairs(out_.scene));
  model_.warnings.append_to(out_.warnings);
}

void Reader::place(int b) {
  Body& body = at(b);
  const Pose local = pose_of(m_.body_pos + 3 * b, m_.body_quat + 4 * b);
  const int parent = m_.body_parentid[b];
  body.frame = b == 0 ? local : at(parent).frame * local;
  body.lead = b;
  // A body fixed to the world stays a body of its own: it costs nothing, and keeps a pose.
  const bool part = b > 0 && m_.body_jntnum[b] == 0 && !is_mocap(b) &&
                    (m_.body_weldid[b] != 0 || is_mocap(at(parent).lead));
  if (part) body.lead = at(parent).lead;
  Body& lead = at(body.lead);
  if (part) body.in_lead = inverse(lead.frame) * body.frame;
  lead.geoms += static_cast<std::size_t>(m_.body_geomnum[b]);
  if (m_.body_weldid[b] == 0) return;
  if (!part) {
    const bool root = m_.body_weldid[parent] == 0;
    body.group = root ? out_.scene.new_group() : at(parent).group;
  } else {
    body.group = lead.group;
  }
  if (!(m_.body_mass[b] > 0.0)) return;  // only a frame
  const Pose mass = body.in_lead * pose_of(m_.body_ipos + 3 * b, m_.body_iquat + 4 * b);
  const pbd::Mat3 turn = mass.orientation.toRotationMatrix();
  lead.parts.add(m_.body_mass[b], mass.position,
                 turn * vec(m_.body_inertia + 3 * b).asDiagonal() * turn.transpose());
}

void Reader::add_body(int b) {
  Body& body = at(b);
  const Body& lead = at(body.lead);
  if (body.lead == b) {
    const std::string where = model_.where(mjOBJ_BODY, b);
    pbd::BodyDef def{.pose = body.frame};
    if (is_mocap(b)) {
      def.type = BodyType::Kinematic;
    } else if (m_.body_weldid[b] == 0) {
      def.type = BodyType::Static;
    } else {
      scene_files::require_within(where, limits_.parts(body.geoms));
      def.mass = body.parts.mass();
      if (def.mass > 0.0) {
        def.origin = -body.parts.com();
        def.inertia = body.parts.inertia();
      }
      def.pose.position = body.frame.to_world(-def.origin);
      damp(b, def);
      add_between(b, def);
    }
    scene_files::require_within(where, limits_.add(&SceneLimits::bodies));
    body.id = model_.guard(mjOBJ_BODY, b, [&] { return out_.scene.world().add_body(def); });
  }
  out_.bodies.push_back({model_.name(mjOBJ_BODY, b), lead.id, body.in_lead});
}

void Reader::add_between(int b, pbd::BodyDef& def) {
  Body& body = at(b);
  body.joints = joint_ranges(m_, b);
  if (body.joints.empty()) return;
  if (body.joints.size() > 1) {
    model_.warn(mjOBJ_BODY, b, "light bodies stand between joints that no single one stands for");
  }
  for (pbd::BodyDef& between : bodies_between(m_, body.joints, def)) {
    between.pose = {body.frame.to_world(-between.origin), body.frame.orientation};
    scene_files::require_within(model_.where(mjOBJ_BODY, b), limits_.add(&SceneLimits::bodies));
    body.between.push_back(
        model_.guard(mjOBJ_BODY, b, [&] { return out_.scene.world().add_body(between); }));
  }
  def.pose.position = body.frame.to_world(-def.origin);
}

/// Damping of a free joint: force and torque proportional to the speeds.
void Reader::damp(int b, pbd::BodyDef& def) {
  const int j = m_.body_jntadr[b];
  if (m_.body_jntnum[b] == 0 || m_.jnt_type[j] != mjJNT_FREE || model_.off(mjDSBL_PASSIVE)) return;
  const mjtNum damping = m_.dof_damping[m_.jnt_dofadr[j]];
  if (damping == 0.0) return;
  def.linear_damping = damping / def.mass;
  const double moment = def.inertia.trace() / 3.0;
  def.angular_damping = damping / moment;
  if ((def.inertia - moment * pbd::Mat3::Identity()).cwiseAbs().maxCoeff() > 1e-3 * moment) {
    model_.warn(mjOBJ_JOINT, j, "its damping slows turns about all axes alike, by the mean moment");
  }
}

void Reader::add_geom(int g, const Filters& filters) {
  if (m_.geom_contype[g] == 0 && m_.geom_conaffinity[g] == 0) return;  // visual only
  const Body& body = at(m_.geom_bodyid[g]);
  const BodyId id = at(body.lead).id;
  collision::ColliderDef def{
      .body = id,
      .local = body.in_lead * pose_of(m_.geom_pos + 3 * g, m_.geom_quat + 4 * g),
      .material = {.friction = friction(g), .friction_rule = collision::Combine::Maximum},
      .filter = filters[g]};
  def.filter.group = body.group;
  const std::optional<collision::Shape> shape = shapes_.of(g);
  if (!shape) return;
  def.shape = *shape;
  def.local.position = def.local.to_world(origin_of(m_, g)) + out_.scene.world().props(id).origin;
  scene_files::require_within(model_.where(mjOBJ_GEOM, g), limits_.add(&SceneLimits::colliders));
  model_.guard(mjOBJ_GEOM, g, [&] { return out_.scene.shapes().add(out_.scene.world(), def); });
}

double Reader::friction(int g) {
  const double sliding = m_.geom_friction[3 * g];
  if (m_.geom_priority[g] != 0) {
    model_.warn(mjOBJ_GEOM, g, "priority is not read: the larger friction of the two counts");
  }
  // In MuJoCo a contact has the larger condim and the larger friction of the two.
  if (m_.geom_condim[g] == 1) {
    const bool met = std::any_of(m_.geom_condim, m_.geom_condim + m_.ngeom,
                                 [](int other) { return other != 1; });
    if (met && sliding != 0.0) {
      model_.warn(mjOBJ_GEOM, g, "condim 1: it has no friction of its own, with any geom");
    }
    return 0.0;
  }
  if (m_.geom_condim[g] > 3) {
    model_.warn(mjOBJ_GEOM, g, "condim 4 and 6: contacts do not resist turning and rolling");
  }
  return sliding;
}

void Reader::add_joints(int b) {
  Body& body = at(b);
  const int first = m_.body_jntadr[b];
  const int count = m_.body_jntnum[b];
  if (count == 0) return;
  if (m_.jnt_type[first] == mjJNT_FREE) return tell_free_joint(first);
  BodyId parent = at(at(m_.body_parentid[b]).lead).id;
  for (std::size_t k = 0; k < body.joints.size(); ++k) {
    scene_files::require_within(model_.where(mjOBJ_BODY, b), limits_.add(&SceneLimits::joints));
    const BodyId child = k < body.between.size() ? body.between[k] : body.id;
    joints_.push_back(model_.guard(mjOBJ_BODY, b, [&] {
      return joint_of(model_, body.joints[k], out_.scene.world(), parent, child, body.frame);
    }));
    parent = child;
  }
}

void Reader::tell_free_joint(int j) {
  const int dof = m_.jnt_dofadr[j];
  if (m_.dof_frictionloss[dof] != 0.0 && !model_.off(mjDSBL_FRICTIONLOSS)) {
    model_.warn(mjOBJ_JOINT, j, "frictionloss of free joints is not read");
  }
  if (m_.dof_armature[dof] != 0.0) {
    model_.warn(mjOBJ_JOINT, j, "armature of free joints is not read");
  }
}

/// Moves all bodies to their start and holds them there. Before, they are at qpos0, the zero of
/// Tandem's coordinates.
void Reader::start() {
  std::vector<mjtNum> wanted(m_.qpos0, m_.qpos0 + m_.nq);
  const mjtNum* controls = nullptr;
  if (!options_.keyframe.empty()) {
    const int key = mj_name2id(&m_, mjOBJ_KEY, options_.keyframe.c_str());
    if (key < 0) {
      pbd::detail::refuse("MjcfOptions::keyframe", "the name of one of the model's",
                          '"' + options_.keyframe + '"');
    }
    wanted.assign(m_.key_qpos + key * m_.nq, m_.key_qpos + (key + 1) * m_.nq);
    controls = m_.key_ctrl + key * m_.nu;
  }
  bool moved = !options_.keyframe.empty();
  for (int j = 0; j < m_.njnt; ++j) {
    const bool turns = m_.jnt_type[j] == mjJNT_HINGE;
    if (!m_.jnt_limited[j] || model_.off(mjDSBL_LIMIT)) continue;
    if (!turns && m_.jnt_type[j] != mjJNT_SLIDE) continue;
    mjtNum& place = wanted[static_cast<std::size_t>(m_.jnt_qposadr[j])];
    const auto within =
        scene_files::start_in_range(place, m_.jnt_range[2 * j], m_.jnt_range[2 * j + 1], turns);
    if (within.moved == 0.0) continue;
    moved = true;
    place = within.at;
    model_.warnings.add("joint",
                        model_.title(mjOBJ_JOINT, j) + " (by " +
                            scene_files::short_number(within.moved) + (turns ? " rad)" : " m)"),
                        "where it was to start is outside its range: it starts at the nearest "
                        "place");
  }
  if (moved) set_poses(wanted);
  Actuators actuators(model_, controls);
  actuators.put(joints_);
  std::vector<pbd::JointId> ids;
  for (BodyJoint& joint : joints_) {
    const auto [first, end] = joint.range;
    for (int j = first; moved && j < end; ++j) {
      if (m_.jnt_type[j] != mjJNT_HINGE) continue;
      const int q = m_.jnt_qposadr[j];
      const bool turned = joint.def.b != joint.child;  // then the parent in the child's frame
      joint.def.start = (turned ? -1.0 : 1.0) * (wanted[static_cast<std::size_t>(q)] - m_.qpos0[q]);
    }
    const pbd::JointId id =
        model_.guard(mjOBJ_JOINT, first, [&] { return out_.scene.add_joint(joint.def); });
    for (int j = first; j < end; ++j) {
      out_.joints.push_back({model_.name(mjOBJ_JOINT, j), id});
    }
    ids.push_back(id);
  }
  actuators.append_to(out_.actuators, ids);
  couple(ids);
}

/// Sets poses by MuJoCo's own kinematics.
void Reader::set_poses(const std::vector<mjtNum>& coordinates) {
  const std::unique_ptr<mjData, void (*)(mjData*)> data(mj_makeData(&m_), mj_deleteData);
  if (data == nullptr) throw SceneFileError("MuJoCo: no memory for the model's state");
  std::copy(coordinates.begin(), coordinates.end(), data->qpos);
  mj_kinematics(&m_, data.get());
  for (int b = 0; b < m_.nbody; ++b) {
    if (at(b).lead != b || m_.body_weldid[b] == 0) continue;
    const Body& body = at(b);
    out_.scene.set_pose(body.id, pose_of(data->xpos + 3 * b, data->xquat + 4 * b));
    for (std::size_t k = 0; k < body.between.size(); ++k) {
      out_.scene.set_pose(body.between[k], frame_behind(b, body.joints[k].end, *data));
    }
  }
}

/// World frame of a body as moved by the joints before one of its own: MuJoCo only gives it for the
/// last.
Pose Reader::frame_behind(int b, int joint, const mjData& data) const {
  const int parent = m_.body_parentid[b];
  Pose out = pose_of(data.xpos + 3 * parent, data.xquat + 4 * parent) *
             pose_of(m_.body_pos + 3 * b, m_.body_quat + 4 * b);
  for (int j = m_.body_jntadr[b]; j < joint; ++j) {
    const int q = m_.jnt_qposadr[j];
    const double way = data.qpos[q] - m_.qpos0[q];
    const Vec3 axis = vec(m_.jnt_axis + 3 * j);
    if (m_.jnt_type[j] == mjJNT_SLIDE) {
      out.position += way * (out.orientation * axis);
      continue;
    }
    const Vec3 anchor = vec(m_.jnt_pos + 3 * j);
    const Quat turn = m_.jnt_type[j] == mjJNT_BALL ? pose_of(m_.jnt_pos, data.qpos + q).orientation
                                                   : Quat(Eigen::AngleAxisd(way, axis));
    out = out * Pose{anchor - turn * anchor, turn};
  }
  return out;
}

void Reader::couple(const std::vector<pbd::JointId>& ids) {
  for (int e = 0; e < m_.neq; ++e) {
    if (!m_.eq_active[e] || model_.off(mjDSBL_EQUALITY) || m_.eq_type[e] != mjEQ_JOINT) continue;
    if (options_.couple && couple(e, ids)) continue;
    model_.warn(mjOBJ_EQUALITY, e, "couplings of joints are left out: they move freely");
  }
}

/// y - y0 = a0 + a1 (x - x0) + ...: coordinates are 0 at qpos0 here.
/// @return whether it can be coupled
bool Reader::couple(int e, const std::vector<pbd::JointId>& ids) {
  const mjtNum* a = m_.eq_data + mjNEQDATA * e;
  if (m_.eq_obj2id[e] < 0 || a[2] != 0.0 || a[3] != 0.0 || a[4] != 0.0) return false;
  pbd::JointId id[2];
  double sign[2] = {0.0, 0.0};
  const int wanted[2] = {m_.eq_obj2id[e], m_.eq_obj1id[e]};
  for (std::size_t k = 0; k < joints_.size(); ++k) {
    for (const Coordinate& one : joints_[k].coordinates) {
      for (int i = 0; i < 2; ++i) {
        if (one.joint != wanted[i]) continue;
        id[i] = ids[k];
        sign[i] = one.sign;
      }
    }
  }
  return sign[0] * sign[1] != 0.0 &&
         scene_files::couple_joints(out_.scene, id[0], id[1], sign[0] * sign[1] * a[1],
                                    sign[1] * a[0]);
}

/// Warns of elements that are only counted.
void Reader::tell_rest() {
  const auto all = [&](mjtObj kind, int count) {
    for (int i = 0; i < count; ++i) model_.warn(kind, i, "not read");
  };
  all(mjOBJ_TENDON, m_.ntendon);
  for (int e = 0; e < m_.neq; ++e) {
    if (!m_.eq_active[e] || model_.off(mjDSBL_EQUALITY) || m_.eq_type[e] == mjEQ_JOINT) continue;
    model_.warn(mjOBJ_EQUALITY, e, "left out: what it ties moves freely");
  }
  all(mjOBJ_SENSOR, m_.nsensor);
  all(mjOBJ_EXCLUDE, m_.nexclude);
  if (m_.npair > 0) out_.warnings.push_back("contact pairs are not read");
  if (m_.opt.viscosity != 0.0 || m_.opt.density != 0.0) {
    out_.warnings.push_back("option: the medium's density and viscosity are not read");
  }
  const auto soft = [](const mjtNum* ref, const mjtNum* imp) {
    // MuJoCo's defaults.
    return ref[0] != 0.02 || ref[1] != 1.0 || imp[0] != 0.9 || imp[1] != 0.95 || imp[2] != 0.001;
  };
  for (int g = 0; g < m_.ngeom; ++g) {
    if (soft(m_.geom_solref + mjNREF * g, m_.geom_solimp + mjNIMP * g)) {
      model_.warn(mjOBJ_GEOM, g, "solref and solimp are not read: contacts are rigid");
    }
    if (m_.geom_margin[g] != 0.0) model_.warn(mjOBJ_GEOM, g, "margin is not read");
  }
  for (int j = 0; j < m_.njnt; ++j) {
    if (m_.jnt_limited[j] && soft(m_.jnt_solref + mjNREF * j, m_.jnt_solimp + mjNIMP * j)) {
      model_.warn(mjOBJ_JOINT, j, "solreflimit and solimplimit are not read: limits are rigid");
    }
  }
}

}  // namespace tandem::mjcf
