// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>

#include "clipping.h"
#include "convex_manifold.h"

namespace tandem::collision {

/// A box as seen by its pair.
struct BoxPose {
  const Mat3& rotation;  ///< to world
  const Vec3& half;      ///< m
};

/// One of the 15 directions in which two boxes can be apart: 0 to 2 faces of a, 3 to 5 faces of b,
/// 6 + 3 i + j the product of edge i of a and edge j of b.
struct BoxAxis {
  std::uint8_t id = 0;
  double sign = 1.0;        ///< makes the direction point from a to b
  double separation = 0.0;  ///< m
};

/// Gap along one of the 15 directions, m, without the preparation of BoxPair.
double box_separation(const BoxPose& a, const BoxPose& b, const Vec3& between, std::uint8_t id);

/// Two boxes with b seen from a.
class BoxPair {
 public:
  /// @param between  m, world: from the centre of a to that of b
  BoxPair(const BoxPose& a, const BoxPose& b, const Vec3& between);

  /// The direction of the contact. Faces are preferred to edges that are hardly better, and the
  /// face `before` (of the last step) to other faces, to avoid flicker. If they are apart by
  /// `margin` in any direction, one of those is returned.
  BoxAxis best(std::uint8_t before, double margin) const;
  /// Whether separated boxes will touch there within the sweep (m, of b relative to a). False if
  /// they still pass by each other along one of their faces when they meet.
  bool will_meet(const BoxAxis& axis, const Vec3& normal, const Vec3& sweep) const;
  /// The direction in the world, unit, from a to b.
  Vec3 normal(const BoxAxis& axis) const;
  /// Points on a face as the reference, relative to the centre of a in the world's axes.
  /// @pre axis.id < 6     No points: nothing of the other box is over the face.
  void face_points(const BoxAxis& axis, double margin, RawManifold& out) const;

 private:
  template <int kI>
  BoxAxis face_of_a() const;
  template <int kJ>
  BoxAxis face_of_b() const;
  /// Replaces `best` by this direction if it separates more; never if the edges are nearly
  /// parallel.
  template <int kI, int kJ>
  void across_edges(BoxAxis& best) const;

  const BoxPose& a_;
  const BoxPose& b_;
  Vec3 between_;
  Mat3 turn_;      ///< axes of b in a
  Mat3 turn_abs_;  ///< absolute values of turn_
  Vec3 in_a_;      ///< centre of b in a
  Vec3 in_b_;      ///< the same vector in b's axes
};

}  // namespace tandem::collision
