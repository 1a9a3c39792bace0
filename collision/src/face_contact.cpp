// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "face_contact.h"

#include <algorithm>
#include <cmath>

#include "axis_rules.h"

namespace tandem::collision {
namespace {

/// Faces whose cosines differ by less than this are equally near to a normal.
constexpr double kTie = 1e-9;

/// The face of either box nearly along the normal of an edge contact; a's face if both are equally
/// near; FaceOwner::None if there is none.
ContactAxis face_alongside(const ConvexCore& a, const ConvexCore& b, const Vec3& n) {
  ContactAxis best;
  double cosine = kAlongside;
  const auto look = [&](const ConvexCore& core, FaceOwner owner) {
    for (int i = 0; i < 3; ++i) {
      const double value = core.axes.col(i).dot(n);
      if (std::abs(value) <= cosine + kTie) continue;
      cosine = std::abs(value);
      best = {std::copysign(1.0, value) * core.axes.col(i), 0.0, owner};
    }
  };
  look(a, FaceOwner::A);
  look(b, FaceOwner::B);
  return best;
}

}  // namespace

void face_contact(const ConvexCore& a, const ConvexCore& b, const ContactAxis& axis,
                  const Reach& reach, RawManifold& out) {
  const Vec3& n = axis.normal;
  const bool of_a = axis.owner == FaceOwner::A;
  const CoreFace reference = of_a ? face_towards(a, n) : face_towards(b, -n);
  const double plane = of_a ? a.reach(n) : -b.reach(-n);
  BearingFaces faces = of_a ? BearingFaces(b, -n) : BearingFaces(a, n);
  CoreFace incident;
  for (bool beside = false; faces.next(incident); beside = true) {
    const ClippedFace clipped = clip_face(reference, n, incident, of_a);
    for (int i = 0; i < clipped.count; ++i) {
      const Vec3& p = clipped.corners[i].position;
      const double along = n.dot(p) - plane;  // positive from a to b
      const Vec3 opposite = p - along * n;
      const double gap = (of_a ? along : -along) - a.radius - b.radius;
      if (gap >= reach.margin || (beside && out.has(clipped.corners[i].feature))) continue;
      out.add({of_a ? opposite : p, of_a ? p : opposite, gap, clipped.corners[i].feature});
    }
  }
}

bool serve_by_face(const ConvexCore& a, const ConvexCore& b, const ContactAxis& edges,
                   const Reach& reach, RawManifold& out) {
  if (a.kind != CoreKind::Box || b.kind != CoreKind::Box) return false;
  const ContactAxis face = face_alongside(a, b, edges.normal);
  if (face.owner == FaceOwner::None) return false;
  RawManifold found;
  found.normal = face.normal;
  found.owner = face.owner;
  face_contact(a, b, face, reach, found);
  double deepest = HUGE_VAL;
  for (int i = 0; i < found.count; ++i) deepest = std::min(deepest, found.points[i].gap);
  const double tolerance =
      kFaceShare * std::max(0.0, -edges.separation) + kFaceSize * std::min(a.size, b.size);
  if (found.count < 2 || deepest < edges.separation - tolerance) return false;
  out = found;
  return true;
}

}  // namespace tandem::collision
