// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "mjcf_joints.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "actuators.h"

namespace tandem::mjcf {
namespace {

/// Sine or cosine of the angle between axes that are at right angles or parallel.
constexpr double kAligned = 1e-6;
constexpr const char* kBackwards = "its coordinate runs the other way here, limits and all";

/// A body's joints: slides, and at most one that turns it.
struct Chain {
  std::vector<int> slides;
  int turn = -1;
  /// The slides go with the turn, which stands before them. Along its axis they may stand anywhere.
  bool turn_first = false;
};

class JointReader {
 public:
  JointReader(Model& model, int body, const Pose& frame)
      : model_(model), m_(model.m), body_(body), frame_(frame), chain_(chain()) {}

  BodyJoint read(const pbd::World& world, BodyId parent, BodyId child) {
    const int turn = chain_.turn;
    const Vec3 anchor =
        frame_.to_world(vec(m_.jnt_pos + 3 * (turn >= 0 ? turn : chain_.slides[0])));
    // x is the hinge's axis where there is one: that of twist has no bounds.
    const bool on_slide = turn < 0 || (is_ball(turn) && !chain_.slides.empty());
    const Vec3 x = axis(on_slide ? chain_.slides[0] : turn);
    // Body b slides along the axes of body a: the child along its parent's, or, where it has been
    // turned before, the parent along those of the child, backwards.
    const double sign = chain_.turn_first ? -1.0 : 1.0;
    // Friction of a ball, too, is about the axes of body a: in MuJoCo those of the child.
    const bool dry_ball = turn >= 0 && is_ball(turn) && chain_.slides.empty() &&
                          dry_friction(m_.jnt_dofadr[turn]) > 0.0;
    const bool child_first = chain_.turn_first || dry_ball;
    BodyJoint out{.body = body_};
    pbd::SixDofJointDef& def = out.def;
    def = pbd::six_dof_joint_at(world, child_first ? child : parent, child_first ? parent : child,
                                anchor, x);
    if (dry_ball) {
      const pbd::Mat3 own = frame_.orientation.toRotationMatrix();
      pbd::Mat3 basis;
      basis << own.col(2), own.col(0), own.col(1);  // MuJoCo's axis of balls is z
      set_basis(def, world, Quat(basis));
      model_.warn(mjOBJ_JOINT, turn, kBackwards);
    } else {
      set_axes(def, world, x);
    }
    for (auto* axes : {&def.linear, &def.angular}) {
      for (pbd::JointAxis& one : *axes) one.freedom = pbd::Freedom::Locked;
    }
    if (turn >= 0 && is_ball(turn)) ball(def, turn);
    if (turn >= 0 && !is_ball(turn)) coordinate(out, 3, turn, sign);
    const Quat basis = world.pose(def.b).orientation * def.frame_b.basis;
    for (const int j : chain_.slides) {
      const Vec3 along = basis.conjugate() * axis(j);
      Eigen::Index at = 0;
      if (!(along.cwiseAbs().maxCoeff(&at) > 1.0 - kAligned)) refuse();
      if (def.linear[static_cast<std::size_t>(at)].freedom != pbd::Freedom::Locked) refuse();
      coordinate(out, static_cast<int>(at), j, along[at] > 0.0 ? sign : -sign);
    }
    return out;
  }

 private:
  bool is_ball(int j) const { return m_.jnt_type[j] == mjJNT_BALL; }
  /// World, unit.
  Vec3 axis(int j) const { return (frame_.orientation * vec(m_.jnt_axis + 3 * j)).normalized(); }
  bool is_along_turn(int slide, int turn) const {
    return !is_ball(turn) && axis(slide).cross(axis(turn)).norm() < kAligned;
  }

  Chain chain() const {
    Chain out;
    const int first = m_.body_jntadr[body_];
    for (int j = first; j < first + m_.body_jntnum[body_]; ++j) {
      if (m_.jnt_type[j] == mjJNT_SLIDE) {
        out.slides.push_back(j);
      } else if (out.turn < 0) {
        out.turn = j;
      } else {
        refuse();
      }
    }
    bool before = false;
    for (const int j : out.slides) {
      if (out.turn < 0 || is_along_turn(j, out.turn)) continue;
      (j < out.turn ? before : out.turn_first) = true;
    }
    if (before && out.turn_first) refuse();
    return out;
  }

  [[noreturn]] void refuse() const {
    throw SceneFileError(
        "joints must be one, or slides at right angles and a hinge or ball, before all slides or "
        "behind them, with the hinge's axis along one of them or at right angles to all");
  }

  /// y and z along the slides that are at right angles to x, in their direction.
  void set_axes(pbd::SixDofJointDef& def, const pbd::World& world, const Vec3& x) const {
    std::vector<Vec3> across;
    for (const int j : chain_.slides) {
      if (std::abs(x.dot(axis(j))) < kAligned) across.push_back(axis(j));
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
    if (def.drive.friction > 0.0 && !chain_.slides.empty()) {
      model_.warn(mjOBJ_JOINT, j, "frictionloss of a ball beside slides is about their axes");
    }
    if (m_.jnt_limited[j] && !model_.off(mjDSBL_LIMIT)) {
      def.cone = m_.jnt_range[2 * j + 1];
      model_.warn(mjOBJ_JOINT, j, "its range bounds the swing, not the twist");
    }
  }

  /// N or N m. MuJoCo has it of each degree of freedom: of a ball about each axis of the child.
  double dry_friction(int dof) const {
    return model_.off(mjDSBL_FRICTIONLOSS) ? 0.0 : m_.dof_frictionloss[dof];
  }

  /// @param sign  -1: Tandem's coordinate runs the other way
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
  }

  Model& model_;
  const mjModel& m_;
  int body_;
  const Pose& frame_;
  Chain chain_;
};

}  // namespace

BodyJoint joint_of(Model& model, int body, const pbd::World& world, BodyId parent, BodyId child,
                   const Pose& frame) {
  return JointReader(model, body, frame).read(world, parent, child);
}

}  // namespace tandem::mjcf
