// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "mjcf_armature.h"

#include <algorithm>

namespace tandem::mjcf {

Carrier carried(const Model& model, int body, Carrier parent) {
  const mjModel& m = model.m;
  const int* types = m.jnt_type + m.body_jntadr[body];
  const int count = m.body_jntnum[body];
  if (count == 0) return parent;
  const bool turns = std::any_of(types, types + count, [](int t) { return t != mjJNT_SLIDE; });
  return turns ? Carrier::Turns : std::max(parent, Carrier::Slides);
}

void add_armature(Model& model, int body, Carrier parent, pbd::BodyDef& def) {
  const mjModel& m = model.m;
  const int first = m.body_jntadr[body];
  const int end = first + m.body_jntnum[body];
  const auto armature = [&](int j) { return m.dof_armature[m.jnt_dofadr[j]]; };
  // Along what it cannot move a body may have any mass, so that of all slides has to be one.
  bool slides = parent == Carrier::Fixed && carried(model, body, parent) == Carrier::Slides;
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
      // A hinge turns it about one axis alone: what it has about others does not matter.
      def.inertia += armature(j) * pbd::Mat3::Identity();
    } else {
      model.warn(mjOBJ_JOINT, j,
                 "armature is left out where it is not the same as more inertia of the body");
    }
  }
}

}  // namespace tandem::mjcf
