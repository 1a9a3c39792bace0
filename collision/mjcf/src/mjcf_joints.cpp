// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "mjcf_joints.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "actuators.h"

namespace tandem::mjcf {
namespace {

/// Tolerance of the sine or cosine for parallel or perpendicular axes.
constexpr double kAligned = 1e-6;
constexpr const char* kBackwards = "its coordinate runs the other way here, limits and all";

/// Unit axis in the body's frame.
Vec3 axis_of(const mjModel& m, int j) { return vec(m.jnt_axis + 3 * j).normalized(); }
bool is_ball(const mjModel& m, int j) { return m.jnt_type[j] == mjJNT_BALL; }
bool are_along(const Vec3& u, const Vec3& v) { return u.cross(v).norm() < kAligned; }
bool are_across(const Vec3& u, const Vec3& v) { return std::abs(u.dot(v)) < kAligned; }

/// Joints of the model replaced by one: slides, and at most one that turns.
struct Chain {
  std::vector<int> slides;
  int turn = -1;
  /// The turning joint comes first and takes the slides along. Slides along its axis may be on
  /// either side.
  bool turn_first = false;
};

/// Nothing if the range cannot be replaced by one joint.
std::optional<Chain> chain(const mjModel& m, JointRange range) {
  Chain out;
  for (int j = range.first; j < range.end; ++j) {
    if (m.jnt_type[j] == mjJNT_SLIDE) {
      for (const int other : out.slides) {
        if (!are_across(axis_of(m, j), axis_of(m, other))) return {};
      }
      out.slides.push_back(j);
    } else if (out.turn < 0) {
      out.turn = j;
    } else {
      return {};
    }
  }
  bool before = false;
  const int turn = out.turn;
  for (const int j : out.slides) {
    if (turn < 0) continue;
    if (!is_ball(m, turn)) {
      if (are_along(axis_of(m, j), axis_of(m, turn))) continue;
      if (!are_across(axis_of(m, j), axis_of(m, turn))) return {};
    }
    (j < turn ? before : out.turn_first) = true;
  }
  if (before && out.turn_first) return {};
  return out;
}

class JointReader {
 public:
  JointReader(Model& model, JointRange range, const Pose& frame)
      : model_(model),
        m_(model.m),
        range_(range),
        frame_(frame),
        chain_(chain(model.m, range).value()) {}

  BodyJoint read(const pbd::World& world, BodyId parent, BodyId child) {
    const int turn = chain_.turn;
    const Vec3 anchor =
        frame_.to_world(vec(m_.jnt_pos + 3 * (turn >= 0 ? turn : chain_.slides[0])));
    // x is the hinge's axis if there is one: twist is unbounded.
    const bool on_slide = turn < 0 || (is_ball(m_, turn) && !chain_.slides.empty());
    const Vec3 x = axis(on_slide ? chain_.slides[0] : turn);
    // Body b slides along the axes of body a: the child along its parent's, or, after a rotation,
    // the parent along the child's, with opposite sign.
    const double sign = chain_.turn_first ? -1.0 : 1.0;
    // Friction of a ball is about the axes of body a, too; in MuJoCo about the child's.
    const bool dry_ball = turn >= 0 && is_ball(m_, turn) && chain_.slides.empty() &&
                          dry_friction(m_.jnt_dofadr[turn]) > 0.0;
    const bool child_first = chain_.turn_first || dry_ball;
    BodyJoint out{.range = range_, .child = child};
    pbd::SixDofJointDef& def = out.def;
    def = pbd::six_dof_joint_at(world, child_first ? child : parent, child_first ? parent : child,
                                anchor, x);
    if (dry_ball) {
      const pbd::Mat3 own = frame_.orientation.toRotationMatrix();
      pbd::Mat3 basis;
      basis << own.col(2), own.col(0), own.col(1);  // MuJoCo's ball axis is z
      set_basis(def, world, Quat(basis));
      model_.warn(mjOBJ_JOINT, turn, kBackwards);
    } else {
      set_axes(def, world, x);
    }
    for (auto* axes : {&def.linear, &def.angular}) {
      for (pbd::JointAxis& one : *axes) one.freedom = pbd::Freedom::Locked;
    }
    if (turn >= 0 && is_ball(m_, turn)) ball(def, turn);
    if (turn >= 0 && !is_ball(m_, turn)) coordinate(out, 3, turn, sign);
    const Quat basis = world.pose(def.b).orientation * def.frame_b.basis;
    for (const int j : chain_.slides) {
      const Vec3 along = basis.conjugate() * axis(j);
      Eigen::Index at = 0;
      along.cwiseAbs().maxCoeff(&at);
      coordinate(out, static_cast<int>(at), j, along[at] > 0.0 ? sign : -sign);
    }
    return out;
  }

 private:
  /// Unit axis, world.
  Vec3 axis(int j) const { return frame_.orientation * axis_of(m_, j); }
  /// Sets y and z along the slides perpendicular to x, with their sign.
  void set_axes(pbd::SixDofJointDef& def, const pbd::World& world, const Vec3& x) const {
    std::vector<Vec3> across;
    for (const int j : chain_.slides) {
      if (are_across(x, axis(j))) across.push_back(axis(j));
    }
    if (across.empty()) return;
    const bool left = across.size() > 1 && x.cross(across[0]).dot(across[1]) < 0.0;
    const Vec3 y = left ? across[1] : across[0];
    pbd::Mat3 basis;
    basis << x, y, x.cross(y);
    set_basis(def, world, Quat(basis));
  }

  static void set_basis(pbd::SixDofJointDef& def, const pbd::World& world, const Quat& basis) {
    def.frame_a.basis = (world.pose(def.a).orientation.conjugate() * basis).normalized();
    def.frame_b.basis = (world.pose(def.b).orientation.conjugate() * basis).normalized();
  }

  void ball(pbd::SixDofJointDef& def, int j) {
    const int dof = m_.jnt_dofadr[j];
    for (pbd::JointAxis& one : def.angular) one = {};
    if (!model_.off(mjDSBL_PASSIVE)) {
      def.drive.spring = {.stiffness = m_.jnt_stiffness[j], .damping = m_.dof_damping[dof]};
    }
    def.drive.friction = dry_friction(dof);
    def.drive.armature = m_.dof_armature[dof];
    if (def.drive.friction > 0.0 && !chain_.slides.empty()) {
      model_.warn(mjOBJ_JOINT, j, "frictionloss of a ball beside slides is about their axes");
    }
    if (m_.jnt_limited[j] && !model_.off(mjDSBL_LIMIT)) {
      def.cone = m_.jnt_range[2 * j + 1];
      model_.warn(mjOBJ_JOINT, j, "its range bounds the swing, not the twist");
    }
  }

  /// N or N m, per degree of freedom in MuJoCo: for a ball, about each axis of the child.
  double dry_friction(int dof) const {
    return model_.off(mjDSBL_FRICTIONLOSS) ? 0.0 : m_.dof_frictionloss[dof];
  }

  /// @param sign  -1: Tandem's coordinate is reversed
  void coordinate(BodyJoint& out, int at, int j, double sign) {
    out.coordinates.push_back({j, at, sign});
    pbd::JointAxis& axis = scene_files::axis_of(out.def, at);
    const int dof = m_.jnt_dofadr[j];
    const mjtNum zero = m_.qpos0[m_.jnt_qposadr[j]];
    const bool limited = m_.jnt_limited[j] && !model_.off(mjDSBL_LIMIT);
    axis.freedom = limited ? pbd::Freedom::Limited : pbd::Freedom::Free;
    if (limited) {
      const double low = sign * (m_.jnt_range[2 * j] - zero);
      const double high = sign * (m_.jnt_range[2 * j + 1] - zero);
      axis.lower = std::min(low, high);
      axis.upper = std::max(low, high);
    }
    if (!model_.off(mjDSBL_PASSIVE)) {
      axis.spring = {.stiffness = m_.jnt_stiffness[j],
                     .rest = sign * (m_.qpos_spring[m_.jnt_qposadr[j]] - zero),
                     .damping = m_.dof_damping[dof]};
    }
    if (sign < 0.0) model_.warn(mjOBJ_JOINT, j, kBackwards);
    axis.friction = dry_friction(dof);
    axis.armature = m_.dof_armature[dof];
  }

  Model& model_;
  const mjModel& m_;
  JointRange range_;
  const Pose& frame_;
  Chain chain_;
};

}  // namespace

std::vector<JointRange> joint_ranges(const mjModel& m, int body) {
  const int first = m.body_jntadr[body];
  std::vector<JointRange> out;
  for (int j = first; j < first + m.body_jntnum[body]; ++j) {
    if (out.empty() || !chain(m, {out.back().first, j + 1})) out.push_back({j, j});
    out.back().end = j + 1;
  }
  return out;
}

BodyJoint joint_of(Model& model, JointRange range, const pbd::World& world, BodyId parent,
                   BodyId child, const Pose& frame) {
  return JointReader(model, range, frame).read(world, parent, child);
}

}  // namespace tandem::mjcf
