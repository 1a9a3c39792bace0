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

/// A contact point before it is put into the frames of the bodies. Anchors lie on the cores.
struct RawPoint {
  Vec3 on_a, on_b;
  double gap;  ///< m, between the surfaces (radii taken off)
  std::uint32_t feature;

  /// By feature, then the deeper one, then by place: no two different ones are equal, as libraries
  /// differ in which of equal ones they sort first.
  bool operator<(const RawPoint& other) const {
    const auto place = [](const RawPoint& p) {
      return std::tie(p.feature, p.gap, p.on_a.x(), p.on_a.y(), p.on_a.z(), p.on_b.x(), p.on_b.y(),
                      p.on_b.z());
    };
    return place(*this) < place(other);
  }
};

/// The body in whose frame a manifold's normal is constant, where one owns a reference face.
enum class FaceOwner : std::uint8_t { None, A, B };

struct RawManifold {
  static constexpr int kMaxPoints = 2 * CoreFace::kMaxCorners;
  Vec3 normal = Vec3::UnitZ();  ///< unit, from a to b
  FaceOwner owner = FaceOwner::None;
  std::uint32_t cluster = 0;  ///< of a mesh: tells its manifolds apart
  int count = 0;
  /// m: how far what was left out has to sink before it bears in place of the points; infinite
  /// where nothing was.
  double left_out = HUGE_VAL;
  std::array<RawPoint, kMaxPoints> points;

  RawManifold() = default;
  RawManifold(const RawManifold& other) { *this = other; }
  /// Only the points in use: most are not.
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
  /// Where there is no room, the highest point makes way for a lower one.
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

/// What of `incident` lies within the prism over the reference face, `axis` being the prism's
/// direction. `reference_is_a` tells whose ids are whose.
ClippedFace clip_face(const CoreFace& reference, const Vec3& axis, const CoreFace& incident,
                      bool reference_is_a);

/// The same for a reference face that is a rectangle about the origin of the frame in which all
/// positions are given: its corners lie at (+-half[u], +-half[v]).
ClippedFace clip_to_rectangle(const CoreFace& reference, int u, int v, const Vec3& half,
                              const CoreFace& incident, bool reference_is_a);

/// The points of two edges between which a contact along `normal` acts: two where the edges run
/// alongside each other, else the nearest two points of them.
/// @param radii  sum of the radii, m     @return number of points
int edge_points(const CoreEdge& a, const CoreEdge& b, const Vec3& normal, double radii,
                std::array<RawPoint, 2>& out);

/// Choose at most four of the points, in place: the deepest, then those that span the largest
/// area. Earlier points win over later ones that are hardly better, and those that `kept` names
/// (the features chosen last time) over all others, so that the choice does not flicker.
/// Where others lie below the plane of these, they are exchanged for those that bear the weight.
/// @param slop  m: depths that differ by less count as equal
/// @param weight  m, centre of mass of the body that lies on the other
int reduce(RawPoint* points, int count, const Vec3& normal, double slop, const Vec3& weight,
           const std::uint32_t* kept, int kept_count);

/// RawManifold::left_out, of the points from `chosen` on that reduce() left.
double least_left_out(const RawPoint* points, int chosen, int count, double slop);

}  // namespace tandem::collision
