// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>

#include "clipping.h"
#include "convex_manifold.h"

namespace tandem::collision {

/// A box as its pair sees it.
struct BoxPose {
  const Mat3& rotation;  ///< to world
  const Vec3& half;      ///< m
};

/// One of the 15 directions in which two boxes can be apart: 0 to 2 faces of a, 3 to 5 faces of b,
/// 6 + 3 i + j the product of edge i of a and edge j of b.
struct BoxAxis {
  std::uint8_t id = 0;
  double sign = 1.0;        ///< makes it point from a to b
  double separation = 0.0;  ///< m
};

/// Gap along one of the 15 directions without what BoxPair prepares for all of them, m.
double box_separation(const BoxPose& a, const BoxPose& b, const Vec3& between, std::uint8_t id);

/// Two boxes with b seen from a.
class BoxPair {
 public:
  /// @param between  m, world: from the centre of a to that of b
  BoxPair(const BoxPose& a, const BoxPose& b, const Vec3& between);

  /// The direction of the contact. Faces are preferred to edges that are hardly better, and the
  /// face `before` (the last step's) to other faces, so that the choice does not flicker.
  /// Where they are apart by `margin` in any direction, one of those.
  BoxAxis best(std::uint8_t before, double margin) const;
  /// Whether boxes that are apart will touch there within the sweep (m, of b against a): not where,
  /// by the time they meet, they still pass by each other along one of their faces.
  bool will_meet(const BoxAxis& axis, const Vec3& normal, const Vec3& sweep) const;
  /// The direction in the world, unit, from a to b.
  Vec3 normal(const BoxAxis& axis) const;
  /// Points on a face as the reference, positions relative to the centre of a in the world's axes.
  /// @pre axis.id < 6     None: nothing of the other box lies over the face.
  void face_points(const BoxAxis& axis, double margin, RawManifold& out) const;

 private:
  template <int kI>
  BoxAxis face_of_a() const;
  template <int kJ>
  BoxAxis face_of_b() const;
  /// Puts the direction in the place of `best` where it separates more; never where the edges run
  /// alongside each other.
  template <int kI, int kJ>
  void across_edges(BoxAxis& best) const;

  const BoxPose& a_;
  const BoxPose& b_;
  Vec3 between_;
  Mat3 turn_;      ///< axes of b in a
  Mat3 turn_abs_;  ///< its absolute values
  Vec3 in_a_;      ///< centre of b in a
  Vec3 in_b_;      ///< the same vector in b's axes
};

}  // namespace tandem::collision
