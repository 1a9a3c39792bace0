// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/collision/convex_hull.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "quickhull.h"
#include "tandem/pbd/validate.h"

namespace tandem::collision {
namespace {

using pbd::Mat3;
using pbd::Vec3;

/// Share of the extent: faces whose corners are this near to one plane are merged. It is a few
/// steps of quickhull()'s grid.
constexpr double kCoplanar = 3e-6;
/// Share of the extent: thickness of plates made of flat hulls.
constexpr double kPlate = 1e-3;

/// No face yet.
constexpr std::uint32_t kFree = 0xffffffffu;

/// The triangle across a directed edge.
std::uint32_t across(const std::vector<HullTriangle>& triangles, std::uint32_t from,
                     std::uint32_t to) {
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      if (triangles[t][k] == to && triangles[t][(k + 1) % 3] == from) return t;
    }
  }
  pbd::detail::refuse("ConvexHull: corners", "further apart than round-off");
}

/// Triangles by descending area: the planes of large ones are the most precise.
std::vector<std::uint32_t> largest_first(std::span<const Vec3> points,
                                         const std::vector<HullTriangle>& triangles) {
  std::vector<std::uint32_t> order(triangles.size());
  std::vector<double> area(triangles.size());
  for (std::uint32_t t = 0; t < order.size(); ++t) {
    order[t] = t;
    const Vec3& a = points[triangles[t][0]];
    area[t] = (points[triangles[t][1]] - a).cross(points[triangles[t][2]] - a).norm();
  }
  std::stable_sort(order.begin(), order.end(),
                   [&](std::uint32_t l, std::uint32_t r) { return area[l] > area[r]; });
  return order;
}

/// Appends the corners of face `number`, made of the triangles `members`, in order around it.
void append_border(const std::vector<HullTriangle>& triangles,
                   const std::vector<std::uint32_t>& members,
                   const std::vector<std::uint32_t>& owner, std::uint32_t number,
                   std::vector<std::uint32_t>& corners) {
  std::vector<std::array<std::uint32_t, 2>> border;
  for (const std::uint32_t m : members) {
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t from = triangles[m][k];
      const std::uint32_t to = triangles[m][(k + 1) % 3];
      if (owner[across(triangles, from, to)] != number) border.push_back({from, to});
    }
  }
  const std::size_t begin = corners.size();
  std::uint32_t at = border[0][0];
  bool closed = false;
  while (!closed && corners.size() - begin < border.size()) {
    corners.push_back(at);
    const auto step =
        std::find_if(border.begin(), border.end(), [&](const auto& e) { return e[0] == at; });
    if (step == border.end()) break;
    at = (*step)[1];
    closed = at == border[0][0];
  }
  if (!closed || corners.size() - begin != border.size()) {
    pbd::detail::refuse("ConvexHull: points", "far enough apart for a hull of simple faces");
  }
}

}  // namespace

namespace {

void check_points(std::span<const Vec3> points, double tolerance, std::size_t least) {
  if (!(tolerance >= 0.0 && tolerance <= 0.1)) {
    pbd::detail::refuse("ConvexHull: tolerance", "0 to 0.1", tolerance);
  }
  if (points.size() < least) {
    pbd::detail::refuse("ConvexHull: number of points", "at least " + std::to_string(least),
                        static_cast<double>(points.size()));
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].allFinite() || !(points[i].norm() < 1e6)) {
      pbd::detail::refuse("ConvexHull: points[" + std::to_string(i) + "]",
                          "finite and within 1e6 m");
    }
  }
}

Aabb bounds_of(std::span<const Vec3> points) {
  Aabb box{points[0], points[0]};
  for (const Vec3& p : points) box = {box.min.cwiseMin(p), box.max.cwiseMax(p)};
  return box;
}

double extent_of(const Aabb& box) {
  const double extent = (box.max - box.min).maxCoeff();
  if (!(extent > 0.0)) {
    pbd::detail::refuse("ConvexHull: points", "such that they span a volume", "in one place");
  }
  return extent;
}

}  // namespace

std::shared_ptr<const ConvexHull> ConvexHull::make(std::span<const Vec3> points, double tolerance) {
  check_points(points, tolerance, 4);
  return settled(std::vector<Vec3>(points.begin(), points.end()), tolerance, false).hull;
}

ConvexHull::Simplified ConvexHull::simplify(std::span<const Vec3> points, double tolerance) {
  check_points(points, tolerance, 3);
  const double extent = extent_of(bounds_of(points));
  std::vector<Vec3> solid(points.begin(), points.end());
  const Tetrahedron large = large_tetrahedron(points, extent);
  double thickened = 0.0;
  if (!(std::abs(large.height) > kFlatHull * extent)) {
    thickened = 0.5 * kPlate * extent;
    for (Vec3& p : solid) p += thickened * large.normal;
    for (const Vec3& p : points) solid.push_back(p - thickened * large.normal);
  }
  Simplified out = settled(std::move(solid), tolerance, true);
  out.error = std::max(out.error, thickened);
  return out;
}

ConvexHull::Simplified ConvexHull::settled(std::vector<Vec3> corners, double tolerance, bool cut) {
  // A hull of its own corners no longer depends on omitted points; the first hull did.
  double error = 0.0;
  for (;;) {
    const std::shared_ptr<ConvexHull> hull(new ConvexHull);
    hull->tolerance_ = tolerance;
    error = std::max(error, hull->build(corners, cut));
    if (hull->points_.size() == corners.size()) return {hull, error};
    corners = hull->points_;
  }
}

double ConvexHull::build(std::span<const Vec3> points, bool cut) {
  bounds_ = bounds_of(points);
  const double extent = extent_of(bounds_);
  // Relative to the middle, to keep precision for points far from the origin.
  centre_ = 0.5 * (bounds_.min + bounds_.max);
  std::vector<Vec3> local;
  for (const Vec3& p : points) local.push_back(p - centre_);
  auto [triangles, left_out] = quickhull(local, extent, tolerance_, cut);

  std::vector<std::uint32_t> index(local.size(), kMaxVertices);
  for (HullTriangle& t : triangles) {
    for (std::uint32_t& v : t) {
      if (index[v] == kMaxVertices) {
        index[v] = static_cast<std::uint32_t>(arms_.size());
        arms_.push_back(local[v]);
        if (arms_.size() > kMaxVertices) {
          pbd::detail::refuse("ConvexHull: corners", "at most 128", "more");
        }
      }
      v = index[v];
    }
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (index[i] != kMaxVertices) points_.push_back(points[i]);
  }
  merge_faces(triangles, kCoplanar * extent);
  weigh();
  return left_out;
}

void ConvexHull::merge_faces(const std::vector<HullTriangle>& triangles, double tolerance) {
  std::vector<std::uint32_t> owner(triangles.size(), kFree);
  std::vector<std::uint32_t> members;
  for (const std::uint32_t seed : largest_first(arms_, triangles)) {
    if (owner[seed] != kFree) continue;
    const auto number = static_cast<std::uint32_t>(faces_.size());
    const HullPlane plane = hull_plane(arms_, triangles[seed]);
    owner[seed] = number;
    members.assign(1, seed);
    for (std::size_t m = 0; m < members.size(); ++m) {
      const HullTriangle t = triangles[members[m]];
      for (int k = 0; k < 3; ++k) {
        const std::uint32_t other = across(triangles, t[k], t[(k + 1) % 3]);
        const HullTriangle& o = triangles[other];
        const bool flat = std::all_of(o.begin(), o.end(), [&](std::uint32_t v) {
          return std::abs(plane.above(arms_[v])) <= tolerance;
        });
        if (owner[other] != kFree || !flat) continue;
        owner[other] = number;
        members.push_back(other);
      }
    }
    Face face;
    face.begin = static_cast<std::uint32_t>(corners_.size());
    face.normal = plane.normal;
    append_border(triangles, members, owner, number, corners_);
    face.count = static_cast<std::uint32_t>(corners_.size()) - face.begin;
    faces_.push_back(face);
  }
  find_edges();
}

void ConvexHull::find_edges() {
  edge_ids_.assign(corners_.size(), 0);
  for (std::uint32_t f = 0; f < faces_.size(); ++f) {
    const Face& face = faces_[f];
    for (std::uint32_t i = 0; i < face.count; ++i) {
      const std::uint32_t from = corners_[face.begin + i];
      const std::uint32_t to = corners_[face.begin + (i + 1) % face.count];
      const auto twin = std::find_if(edges_.begin(), edges_.end(),
                                     [&](const Edge& e) { return e.from == to && e.to == from; });
      edge_ids_[face.begin + i] = static_cast<std::uint32_t>(twin - edges_.begin());
      if (twin != edges_.end()) {
        twin->faces[1] = f;
      } else {
        edges_.push_back({from, to, {f, f}});
      }
    }
  }
  star_start_.assign(arms_.size() + 1, 0);
  for (std::uint32_t v = 0; v < arms_.size(); ++v) {
    star_start_[v] = static_cast<std::uint32_t>(star_.size());
    for (std::uint32_t e = 0; e < edges_.size(); ++e) {
      if (edges_[e].from == v || edges_[e].to == v) star_.push_back(e);
    }
  }
  star_start_.back() = static_cast<std::uint32_t>(star_.size());
}

void ConvexHull::weigh() {
  Vec3 first = Vec3::Zero();
  for (const Face& face : faces_) {
    const auto loop = face_corners(face);
    for (std::size_t i = 2; i < loop.size(); ++i) {
      const Vec3& a = arms_[loop[0]];
      const Vec3& b = arms_[loop[i - 1]];
      const Vec3& c = arms_[loop[i]];
      const double v = a.dot(b.cross(c)) / 6.0;
      const Vec3 sum = a + b + c;
      volume_ += v;
      first += 0.25 * v * sum;
      // Integral of x x^T over a tetrahedron with one corner at the origin.
      second_ +=
          v / 20.0 *
          (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose());
    }
  }
  const Vec3 com = first / volume_;
  second_ -= volume_ * com * com.transpose();
  centre_ += com;
  for (Vec3& arm : arms_) {
    arm -= com;
    reach_ = std::max(reach_, arm.norm());
  }
  extent_ = HUGE_VAL;
  for (Face& face : faces_) {
    face.offset = -HUGE_VAL;
    double back = HUGE_VAL;
    for (const Vec3& arm : arms_) {
      face.offset = std::max(face.offset, face.normal.dot(arm));
      back = std::min(back, face.normal.dot(arm));
    }
    extent_ = std::min(extent_, face.offset - back);
  }
}

}  // namespace tandem::collision
