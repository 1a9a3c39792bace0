// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <tuple>

#include "convex_core.h"

namespace tandem::collision {

/// A contact point in the world, before it is put into body frames. Anchors are on the cores.
struct RawPoint {
  Vec3 on_a, on_b;
  double gap;  ///< m, between the surfaces (minus the radii)
  std::uint32_t feature;

  /// By feature, then depth, then position. A total order: standard libraries differ in how they
  /// sort equal elements.
  bool operator<(const RawPoint& other) const {
    const auto place = [](const RawPoint& p) {
      return std::tie(p.feature, p.gap, p.on_a.x(), p.on_a.y(), p.on_a.z(), p.on_b.x(), p.on_b.y(),
                      p.on_b.z());
    };
    return place(*this) < place(other);
  }
};

/// The body in whose frame a manifold's normal is constant, if one owns a reference face.
enum class FaceOwner : std::uint8_t { None, A, B };

struct RawManifold {
  static constexpr int kMaxPoints = 2 * CoreFace::kMaxCorners;
  Vec3 normal = Vec3::UnitZ();  ///< unit, from a to b
  FaceOwner owner = FaceOwner::None;
  std::uint32_t cluster = 0;  ///< of a mesh: distinguishes its manifolds
  int count = 0;
  /// m: how far the nearest omitted point must sink before it carries load; infinite if none was
  /// omitted.
  double left_out = HUGE_VAL;
  std::array<RawPoint, kMaxPoints> points;

  RawManifold() = default;
  RawManifold(const RawManifold& other) { *this = other; }
  /// Copies only the points in use: most are unused.
  RawManifold& operator=(const RawManifold& other) {
    normal = other.normal;
    owner = other.owner;
    cluster = other.cluster;
    count = other.count;
    left_out = other.left_out;
    std::copy_n(other.points.begin(), count, points.begin());
    return *this;
  }

  bool has(std::uint32_t feature) const {
    return std::any_of(points.begin(), points.begin() + count,
                       [&](const RawPoint& p) { return p.feature == feature; });
  }
  /// If there is no room, a lower point replaces the highest one.
  void add(const RawPoint& point) {
    if (count < kMaxPoints) {
      points[count++] = point;
      return;
    }
    const auto highest =
        std::max_element(points.begin(), points.end(),
                         [](const RawPoint& l, const RawPoint& r) { return l.gap < r.gap; });
    if (point.gap < highest->gap) *highest = point;
  }
};

/// A corner of a clipped face.
struct ClippedCorner {
  Vec3 position;
  std::uint32_t feature;
};

struct ClippedFace {
  int count = 0;
  std::array<ClippedCorner, 2 * CoreFace::kMaxCorners> corners;
};

/// Clips `incident` to the prism over the reference face along `axis`. `reference_is_a` tells which
/// body each face belongs to.
ClippedFace clip_face(const CoreFace& reference, const Vec3& axis, const CoreFace& incident,
                      bool reference_is_a);

/// Like clip_face(), for a reference face that is a rectangle about the origin of the frame in
/// which all positions are given: its corners are (+-half[u], +-half[v]).
ClippedFace clip_to_rectangle(const CoreFace& reference, int u, int v, const Vec3& half,
                              const CoreFace& incident, bool reference_is_a);

/// Contact points of two edges along `normal`: two if the edges are nearly parallel, else their
/// nearest points.
/// @param radii  sum of the radii, m     @return number of points
int edge_points(const CoreEdge& a, const CoreEdge& b, const Vec3& normal, double radii,
                std::array<RawPoint, 2>& out);

/// Chooses at most four of the points, in place: the deepest, then those that span the largest
/// area. Earlier points win over later ones that are hardly better, and those with features in
/// `kept` (chosen last time) over all others, to avoid flicker. If other points are below the plane
/// of these, those that carry the weight are taken instead.
/// @param slop  m: smaller differences of depth count as equal
/// @param weight  m, centre of mass of the upper body
int reduce(RawPoint* points, int count, const Vec3& normal, double slop, const Vec3& weight,
           const std::uint32_t* kept, int kept_count);

/// RawManifold::left_out of the points from `chosen` on, after reduce().
double least_left_out(const RawPoint* points, int chosen, int count, double slop);

}  // namespace tandem::collision
