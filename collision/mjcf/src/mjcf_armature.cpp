// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "mjcf_armature.h"

#include <algorithm>

namespace tandem::mjcf {

Carrier carried(const mjModel& m, JointRange joints, Carrier parent) {
  if (joints.first == joints.end) return parent;
  const bool turns = std::any_of(m.jnt_type + joints.first, m.jnt_type + joints.end,
                                 [](int type) { return type != mjJNT_SLIDE; });
  return turns ? Carrier::Turns : std::max(parent, Carrier::Slides);
}

void add_armature(Model& model, JointRange joints, Carrier parent, pbd::BodyDef& def) {
  const mjModel& m = model.m;
  const auto [first, end] = joints;
  const auto armature = [&](int j) { return m.dof_armature[m.jnt_dofadr[j]]; };
  // A body may have any mass along directions in which it cannot move, so all slides need the same.
  bool slides = parent == Carrier::Fixed && carried(m, joints, parent) == Carrier::Slides;
  for (int j = first; j < end; ++j) slides = slides && armature(j) == armature(first);
  if (slides && armature(first) != 0.0) {
    const double mass = def.mass + armature(first);
    def.gravity_scale *= def.mass / mass;
    def.mass = mass;
    return;
  }
  for (int j = first; j < end; ++j) {
    if (armature(j) == 0.0) continue;
    const int type = m.jnt_type[j];
    if (parent != Carrier::Turns && (type == mjJNT_HINGE || type == mjJNT_BALL)) {
      // A hinge turns it about one axis only: its inertia about others does not matter.
      def.inertia += armature(j) * pbd::Mat3::Identity();
    } else {
      model.warn(mjOBJ_JOINT, j,
                 "armature is left out where it is not the same as more inertia of the body");
    }
  }
}

}  // namespace tandem::mjcf
