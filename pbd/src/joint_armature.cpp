// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "joint_armature.h"

#include "integrate.h"

namespace tandem::pbd {
namespace {

bool has_armature(const JointRecord& record) {
  bool any = false;
  if (record.passive) return any;
  for_bits(record.used, [&](int i) { any = any || record.axis(i).armature > 0.0; });
  return any;
}

/// A body where it was before the last substep of this length, s. Free rotation changes its spin
/// within a substep, which begins with the old one and ends with the new.
SolverBody substep_before(const SolverBody& body, double h) {
  SolverBody earlier = body;
  earlier.x -= h * body.v;
  Vec3 spin = body.w;
  if (body.inv_inertia_w.determinant() > 0.0) {
    const Vec3 momentum = body.inv_inertia_w.inverse() * body.w;
    spin -= 0.5 * h * (body.inv_inertia_w * momentum.cross(body.w));
  }
  earlier.q = rotated_about(body.q, -h * spin);
  return earlier;
}

}  // namespace

void add_armature(const JointRecord& record, JointRows& rows, const SolverBody& a,
                  const SolverBody& b, double h) {
  if (!has_armature(record)) return;
  double c[kCoordinates];
  coordinates(record, substep_before(a, h), substep_before(b, h), record.twist, c);
  for_bits(record.used, [&](int i) {
    const double armature = record.axis(i).armature;
    const double ahead = 2.0 * rows.start[i] - c[i];
    if (armature > 0.0) add_armature(rows.law[i], armature, ahead);
  });
}

}  // namespace tandem::pbd
