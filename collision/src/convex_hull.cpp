// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Quickhull in its plainest form: the farthest point outside goes in next. With at most 128 corners
// no list of who sees whom is worth its upkeep; faces are searched one by one.
// Neither FCL nor libccd nor Eigen builds hulls.
#include "tandem/collision/convex_hull.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <string>

#include "tandem/pbd/validate.h"

namespace tandem::collision {
namespace {

using pbd::Mat3;
using pbd::Vec3;
using Triangle = std::array<std::uint32_t, 3>;

/// Shares of the extent: a point nearer than this to a face is no corner; a hull thinner than this
/// is flat; faces whose corners lie this near to one plane are one face.
constexpr double kOutside = 1e-7;
constexpr double kFlat = 1e-4;
constexpr double kCoplanar = 1e-6;

struct HullPlane {
  Vec3 normal;
  double offset;
  double above(const Vec3& p) const { return normal.dot(p) - offset; }
};

HullPlane hull_plane(std::span<const Vec3> points, const Triangle& t) {
  const Vec3& a = points[t[0]];
  const Vec3 n = (points[t[1]] - a).cross(points[t[2]] - a).normalized();
  return {n, n.dot(a)};
}

std::uint32_t furthest(std::size_t count, auto&& score) {
  std::uint32_t best = 0;
  double most = -HUGE_VAL;
  for (std::uint32_t i = 0; i < count; ++i) {
    const double value = score(i);
    if (value <= most) continue;
    most = value;
    best = i;
  }
  return best;
}

/// Four points that span a tetrahedron as large as can be had, fronts outside.
std::vector<Triangle> first_tetrahedron(std::span<const Vec3> points, double extent) {
  const std::uint32_t a = furthest(points.size(), [&](std::uint32_t i) { return -points[i].x(); });
  const auto from_a = [&](std::uint32_t i) { return Vec3(points[i] - points[a]); };
  const std::uint32_t b =
      furthest(points.size(), [&](std::uint32_t i) { return from_a(i).squaredNorm(); });
  const Vec3 u = from_a(b).normalized();
  const std::uint32_t c =
      furthest(points.size(), [&](std::uint32_t i) { return u.cross(from_a(i)).squaredNorm(); });
  const char* rule = "such that they span a volume (1e-4 of their extent in each direction)";
  if (!(u.cross(from_a(c)).norm() > kFlat * extent))
    pbd::detail::refuse("ConvexHull: points", rule, "on a line");
  const Vec3 n = u.cross(from_a(c)).normalized();
  const std::uint32_t d =
      furthest(points.size(), [&](std::uint32_t i) { return std::abs(n.dot(from_a(i))); });
  const double height = n.dot(from_a(d));
  if (!(std::abs(height) > kFlat * extent))
    pbd::detail::refuse("ConvexHull: points", rule, "in a plane");
  if (height > 0.0) return {{a, c, b}, {a, b, d}, {b, c, d}, {c, a, d}};
  return {{a, b, c}, {a, d, b}, {b, d, c}, {c, d, a}};
}

using Edge = std::array<std::uint32_t, 2>;  // directed

struct NumberedPlane : HullPlane {
  std::uint32_t number = 0;
};
struct Highest {
  double above = -std::numeric_limits<double>::infinity();
  std::uint32_t plane = 0;  ///< number
};
bool is_lower(const Highest& l, const Highest& r) { return l.above < r.above; }

/// How far above the hull a point has to lie to become a corner, m.
/// @param tolerance  share of the height of the first tetrahedron: see ConvexHull::make()
double least_above(std::span<const Vec3> points, const std::vector<Triangle>& tetrahedron,
                   double extent, double tolerance) {
  const HullPlane base = hull_plane(points, tetrahedron[0]);
  double height = 0.0;
  for (const std::uint32_t v : tetrahedron[1]) height = std::max(height, -base.above(points[v]));
  return std::max(kOutside * extent, tolerance * height);
}

std::vector<Triangle> quickhull(std::span<const Vec3> points, double extent, double tolerance) {
  std::vector<Triangle> faces = first_tetrahedron(points, extent);
  const double least = least_above(points, faces, extent, tolerance);
  std::vector<NumberedPlane> planes;
  std::uint32_t planes_made = 0;
  const auto plane_of = [&](const Triangle& t) {
    return NumberedPlane{hull_plane(points, t), planes_made++};
  };
  std::transform(faces.begin(), faces.end(), std::back_inserter(planes), plane_of);
  // Of each point the plane that it is farthest above, or least below.
  std::vector<Highest> highest(points.size());
  const auto look = [&](std::uint32_t i, std::span<const NumberedPlane> at) {
    for (const NumberedPlane& plane : at) {
      const double above = plane.above(points[i]);
      if (above > highest[i].above) highest[i] = {above, plane.number};
    }
  };
  for (std::uint32_t i = 0; i < points.size(); ++i) look(i, planes);
  std::vector<Triangle> kept;
  std::vector<NumberedPlane> kept_planes;
  std::vector<bool> gone;  // planes, by number
  std::vector<Edge> seen;  // of the faces that see the point
  for (std::size_t round = 0; round <= points.size(); ++round) {
    // A corner that goes in may be swallowed later, but not so many of them.
    if (round > 2 * ConvexHull::kMaxVertices)
      pbd::detail::refuse("ConvexHull: corners", "at most 128", "more");
    const auto next = static_cast<std::uint32_t>(
        std::max_element(highest.begin(), highest.end(), is_lower) - highest.begin());
    if (!(highest[next].above > least)) break;
    kept.clear();
    kept_planes.clear();
    seen.clear();
    gone.assign(planes_made, false);
    for (std::size_t f = 0; f < faces.size(); ++f) {
      // Faces in whose plane the point lies go as well, so that no sliver is left beside them.
      if (planes[f].above(points[next]) > -0.1 * kOutside * extent) {
        for (int k = 0; k < 3; ++k) seen.push_back({faces[f][k], faces[f][(k + 1) % 3]});
        gone[planes[f].number] = true;
      } else {
        kept.push_back(faces[f]);
        kept_planes.push_back(planes[f]);
      }
    }
    const std::size_t stay = kept.size();
    for (const Edge& edge : seen) {
      if (std::find(seen.begin(), seen.end(), Edge{edge[1], edge[0]}) != seen.end())
        continue;  // within them
      kept.push_back({edge[0], edge[1], next});
      kept_planes.push_back(plane_of(kept.back()));
    }
    faces.swap(kept);
    planes.swap(kept_planes);
    for (std::uint32_t i = 0; i < points.size(); ++i) {
      const bool lost = gone[highest[i].plane];
      if (lost) highest[i] = {};
      look(i, std::span(planes).subspan(lost ? 0 : stay));
    }
  }
  return faces;
}

/// In no face yet.
constexpr std::uint32_t kFree = 0xffffffffu;

/// The triangle across a directed edge.
std::uint32_t across(const std::vector<Triangle>& triangles, std::uint32_t from, std::uint32_t to) {
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      if (triangles[t][k] == to && triangles[t][(k + 1) % 3] == from) return t;
    }
  }
  pbd::detail::refuse("ConvexHull: corners", "further apart than round-off");
}

/// Triangles by area: the planes of large ones are the best.
std::vector<std::uint32_t> largest_first(std::span<const Vec3> points,
                                         const std::vector<Triangle>& triangles) {
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

/// Appends the corners of face `number`, which has the triangles `members`, in their order around
/// it.
void append_border(const std::vector<Triangle>& triangles,
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

std::shared_ptr<const ConvexHull> ConvexHull::make(std::span<const Vec3> points, double tolerance) {
  if (!(tolerance >= 0.0 && tolerance <= 0.1)) {
    pbd::detail::refuse("ConvexHull: tolerance", "0 to 0.1", tolerance);
  }
  if (points.size() < 4) {
    pbd::detail::refuse("ConvexHull: number of points", "at least 4",
                        static_cast<double>(points.size()));
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].allFinite() || !(points[i].norm() < 1e6)) {
      pbd::detail::refuse("ConvexHull: points[" + std::to_string(i) + "]",
                          "finite and within 1e6 m");
    }
  }
  // Of its own corners a hull is the same whatever was left out: in that the second one differs.
  std::vector<Vec3> corners(points.begin(), points.end());
  for (;;) {
    const std::shared_ptr<ConvexHull> hull(new ConvexHull);
    hull->tolerance_ = tolerance;
    hull->build(corners);
    if (hull->points_.size() == corners.size()) return hull;
    corners = hull->points_;
  }
}

void ConvexHull::build(std::span<const Vec3> points) {
  Vec3 low = points[0];
  Vec3 high = points[0];
  for (const Vec3& p : points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  bounds_ = {low, high};
  const double extent = (high - low).maxCoeff();
  if (!(extent > 0.0))
    pbd::detail::refuse("ConvexHull: points", "such that they span a volume", "in one place");
  // About the middle, so that no digits are lost where the points are far from the origin.
  centre_ = 0.5 * (low + high);
  std::vector<Vec3> local;
  for (const Vec3& p : points) local.push_back(p - centre_);
  std::vector<Triangle> triangles = quickhull(local, extent, tolerance_);

  std::vector<std::uint32_t> index(local.size(), kMaxVertices);
  for (Triangle& t : triangles) {
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
}

void ConvexHull::merge_faces(const std::vector<Triangle>& triangles, double tolerance) {
  std::vector<std::uint32_t> owner(triangles.size(), kFree);
  std::vector<std::uint32_t> members;
  for (const std::uint32_t seed : largest_first(arms_, triangles)) {
    if (owner[seed] != kFree) continue;
    const auto number = static_cast<std::uint32_t>(faces_.size());
    const HullPlane plane = hull_plane(arms_, triangles[seed]);
    owner[seed] = number;
    members.assign(1, seed);
    for (std::size_t m = 0; m < members.size(); ++m) {
      const Triangle t = triangles[members[m]];
      for (int k = 0; k < 3; ++k) {
        const std::uint32_t other = across(triangles, t[k], t[(k + 1) % 3]);
        const Triangle& o = triangles[other];
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
