// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Refines contacts of two boxes that the collision library has found before: the same 15 directions
// that it searches, at a tenth of the cost (no contact points, no allocation, and most pairs end at
// the direction that separated them in the last step).
#include "box_box.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "axis_rules.h"

namespace tandem::collision {
namespace {

/// Sine below which two edges count as parallel.
constexpr double kMinSine = 1e-3;

ConvexCore core_of(const Vec3& centre, const Mat3& axes, const Vec3& half) {
  ConvexCore core;
  core.kind = CoreKind::Box;
  core.centre = centre;
  core.axes = axes;
  core.half = half;
  return core;
}

}  // namespace

double box_separation(const BoxPose& a, const BoxPose& b, const Vec3& between, std::uint8_t id) {
  Vec3 n;
  double scale = 1.0;
  if (id < 3) {
    n = a.rotation.col(id);
  } else if (id < 6) {
    n = b.rotation.col(id - 3);
  } else {
    n = a.rotation.col((id - 6) / 3).cross(b.rotation.col((id - 6) % 3));
    const double norm2 = n.squaredNorm();
    if (norm2 < kMinSine * kMinSine) return -HUGE_VAL;
    scale = 1.0 / std::sqrt(norm2);
  }
  double s = std::abs(n.dot(between));
  for (int i = 0; i < 3; ++i) {
    s -= a.half[i] * std::abs(n.dot(a.rotation.col(i))) +
         b.half[i] * std::abs(n.dot(b.rotation.col(i)));
  }
  return scale * s;
}

BoxPair::BoxPair(const BoxPose& a, const BoxPose& b, const Vec3& between)
    : a_(a),
      b_(b),
      between_(between),
      turn_(a.rotation.transpose() * b.rotation),
      turn_abs_(turn_.cwiseAbs()),
      in_a_(a.rotation.transpose() * between),
      in_b_(b.rotation.transpose() * between) {}

template <int kI>
BoxAxis BoxPair::face_of_a() const {
  const double d = in_a_[kI];
  const double extent =
      turn_abs_(kI, 0) * b_.half[0] + turn_abs_(kI, 1) * b_.half[1] + turn_abs_(kI, 2) * b_.half[2];
  return {kI, d < 0.0 ? -1.0 : 1.0, std::abs(d) - a_.half[kI] - extent};
}

template <int kJ>
BoxAxis BoxPair::face_of_b() const {
  const double d = in_b_[kJ];
  const double extent =
      turn_abs_(0, kJ) * a_.half[0] + turn_abs_(1, kJ) * a_.half[1] + turn_abs_(2, kJ) * a_.half[2];
  return {kJ + 3, d < 0.0 ? -1.0 : 1.0, std::abs(d) - b_.half[kJ] - extent};
}

template <int kI, int kJ>
void BoxPair::across_edges(BoxAxis& best) const {
  constexpr std::uint8_t kId = 6 + 3 * kI + kJ;
  constexpr int kI1 = (kI + 1) % 3;
  constexpr int kI2 = (kI + 2) % 3;
  constexpr int kJ1 = (kJ + 1) % 3;
  constexpr int kJ2 = (kJ + 2) % 3;
  // a_i x b_j in a's frame has the coordinates (0, -c_2j, c_1j) along (i, i + 1, i + 2).
  const double d = in_a_[kI2] * turn_(kI1, kJ) - in_a_[kI1] * turn_(kI2, kJ);
  const double extent = a_.half[kI1] * turn_abs_(kI2, kJ) + a_.half[kI2] * turn_abs_(kI1, kJ) +
                        b_.half[kJ1] * turn_abs_(kI, kJ2) + b_.half[kJ2] * turn_abs_(kI, kJ1);
  const double gap = std::abs(d) - extent;
  // The division below only increases an overlap.
  if (gap <= 0.0 && gap <= best.separation) return;
  const double sine2 = 1.0 - turn_(kI, kJ) * turn_(kI, kJ);
  if (sine2 < kMinSine * kMinSine) return;
  const double separation = gap / std::sqrt(sine2);
  if (separation > best.separation) best = {kId, d < 0.0 ? -1.0 : 1.0, separation};
}

BoxAxis BoxPair::best(std::uint8_t before, double margin) const {
  const std::array<BoxAxis, 6> faces{face_of_a<0>(), face_of_a<1>(), face_of_a<2>(),
                                     face_of_b<0>(), face_of_b<1>(), face_of_b<2>()};
  BoxAxis face = faces[0];
  for (const BoxAxis& axis : faces) {
    if (axis.separation > face.separation + 1e-9) face = axis;
  }
  if (face.separation >= margin) return face;
  // Edges matter only if they separate more than faces.
  BoxAxis edge = face;
  across_edges<0, 0>(edge);
  across_edges<0, 1>(edge);
  across_edges<0, 2>(edge);
  across_edges<1, 0>(edge);
  across_edges<1, 1>(edge);
  across_edges<1, 2>(edge);
  across_edges<2, 0>(edge);
  across_edges<2, 1>(edge);
  across_edges<2, 2>(edge);
  if (edge.separation >= margin) return edge;
  const double best = std::max(face.separation, edge.separation);
  const double size = 2.0 * std::min(a_.half.minCoeff(), b_.half.minCoeff());
  const double tolerance = kFaceShare * std::max(0.0, -best) + kFaceSize * size;
  if (before < 6 && faces[before].separation >= face.separation - tolerance) face = faces[before];
  return face.separation >= best - tolerance ? face : edge;
}

Vec3 BoxPair::normal(const BoxAxis& axis) const {
  if (axis.id < 3) return axis.sign * a_.rotation.col(axis.id);
  if (axis.id < 6) return axis.sign * b_.rotation.col(axis.id - 3);
  const Vec3 n = a_.rotation.col((axis.id - 6) / 3).cross(b_.rotation.col((axis.id - 6) % 3));
  return axis.sign * n.normalized();
}

bool BoxPair::will_meet(const BoxAxis& axis, const Vec3& normal, const Vec3& sweep) const {
  const double closing = -normal.dot(sweep);
  const double share = closing > axis.separation ? axis.separation / closing : 1.0;
  const double slop = kPassBy * 2.0 * std::min(a_.half.minCoeff(), b_.half.minCoeff());
  for (const BoxAxis& side : {face_of_a<0>(), face_of_a<1>(), face_of_a<2>(), face_of_b<0>(),
                              face_of_b<1>(), face_of_b<2>()}) {
    if (side.separation <= -slop) continue;
    const Vec3 n = this->normal(side);
    if (n.dot(normal) > kAcross) continue;
    if (side.separation + share * n.dot(sweep) > -slop) return false;
  }
  return true;
}

void BoxPair::face_points(const BoxAxis& axis, double margin, RawManifold& out) const {
  const bool of_a = axis.id < 3;
  const int k = of_a ? axis.id : axis.id - 3;
  const int u = (k + 1) % 3;
  const int v = (k + 2) % 3;
  const BoxPose& reference = of_a ? a_ : b_;
  const BoxPose& incident = of_a ? b_ : a_;
  // All in the frame of the reference box. `up` points to the incident box.
  const double up = of_a ? axis.sign : -axis.sign;
  const Vec3 out_of_face = up * Vec3::Unit(k);
  const CoreFace top =
      face_towards(core_of(Vec3::Zero(), Mat3::Identity(), reference.half), out_of_face);
  const CoreFace other = face_towards(
      core_of(of_a ? in_a_ : Vec3(-in_b_), of_a ? turn_ : Mat3(turn_.transpose()), incident.half),
      -out_of_face);
  const ClippedFace clipped = clip_to_rectangle(top, u, v, reference.half, other, of_a);
  const double height = reference.half[k];
  for (int i = 0; i < clipped.count; ++i) {
    Vec3 p = clipped.corners[i].position;
    const double gap = up * p[k] - height;
    if (gap >= margin) continue;
    Vec3 on_incident = reference.rotation * p;
    p[k] = up * height;
    Vec3 on_reference = reference.rotation * p;
    if (!of_a) {
      on_incident += between_;
      on_reference += between_;
    }
    out.add({of_a ? on_reference : on_incident, of_a ? on_incident : on_reference, gap,
             clipped.corners[i].feature});
  }
}

}  // namespace tandem::collision
