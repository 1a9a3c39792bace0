// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cmath>

#include "pair_query.h"
#include "tandem/pbd/contact.h"
#include "tandem/pbd/world.h"

namespace tandem::collision {

/// One contact of the last step, as events see it.
struct ContactReading {
  const pbd::Manifold* manifold = nullptr;
  bool loaded = false;          ///< carried a load in the step
  double approach_speed = 0.0;  ///< m/s, fastest approach that was stopped
  double impulse = 0.0;         ///< N s, sum over normals and substeps

  std::uint32_t low() const {
    return static_cast<std::uint32_t>(manifold->key >> (kIndexBits + kClusterBits));
  }
  std::uint32_t high() const {
    constexpr std::uint64_t kIndexMask = (std::uint64_t{1} << kIndexBits) - 1;
    return static_cast<std::uint32_t>((manifold->key >> kClusterBits) & kIndexMask);
  }
};

/// Calls visit(ContactReading) by ascending key. The only code that knows how pbd stores contacts.
void read_contacts(const pbd::ContactBlock& block, auto&& visit) {
  for (const pbd::Contact& contact : block.contacts()) {
    visit(ContactReading{&contact.manifold, contact.loaded() || contact.impulse > 0.0,
                         contact.approach_speed, contact.impulse});
  }
}

/// Gap of a manifold's nearest point at the current poses, m, and its position.
struct ManifoldGap {
  double gap = HUGE_VAL;
  pbd::Vec3 point = pbd::Vec3::Zero();  ///< m, world, half-way between the surfaces
};

inline ManifoldGap gap_of(const pbd::Manifold& m, const pbd::World& world) {
  const pbd::Pose& a = world.states()[m.body_a].pose;
  const pbd::Pose& b = world.states()[m.body_b].pose;
  ManifoldGap out;
  for (int i = 0; i < m.count; ++i) {
    const pbd::Vec3 arm_a =
        pbd::rotate(a.orientation, m.points[i].anchor_a_l) + m.radius_a * m.normal;
    const pbd::Vec3 arm_b =
        pbd::rotate(b.orientation, m.points[i].anchor_b_l) - m.radius_b * m.normal;
    const pbd::Vec3 between = (b.position - a.position) + (arm_b - arm_a);
    const double gap = m.normal.dot(between);
    if (gap < out.gap) out = {gap, a.position + arm_a + 0.5 * between};
  }
  return out;
}

}  // namespace tandem::collision
