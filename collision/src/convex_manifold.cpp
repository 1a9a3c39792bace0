// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "convex_manifold.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "axis_rules.h"
#include "face_contact.h"
#include "tandem/pbd/portable.h"

namespace tandem::collision {
namespace {

constexpr double kRoundTolerance = 1e-9;  // m
/// Cosine above which the library's direction is a face normal, not merely near to one.
constexpr double kSameDirection = 1.0 - 1e-9;
/// Sine below which two edges have no common normal.
constexpr double kMinCross = 1e-4;

struct Candidates {
  const ConvexCore& a;
  const ConvexCore& b;
  ContactAxis best_face;
  ContactAxis best_other;
  bool has_face = false;
  bool has_other = false;
  /// If the centre of one is outside the other, a thin box: the direction from a to b there. A
  /// direction to the other side of the wall is no way out.
  std::array<Vec3, 2> side;
  int sides = 0;

  void find_sides() {
    if (b.kind == CoreKind::Box && b.size < 0.5 * a.size) find_side(b, a.centre, -1.0);
    if (a.kind == CoreKind::Box && a.size < 0.5 * b.size) find_side(a, b.centre, 1.0);
  }
  void find_side(const ConvexCore& box, const Vec3& middle, double sign) {
    const Vec3 p = box.axes.transpose() * (middle - box.centre);
    const Vec3 out = p - p.cwiseMax(-box.half).cwiseMin(box.half);
    if (!out.isZero(0.0)) side[sides++] = sign * (box.axes * out);
  }
  bool leads_through(const Vec3& n) const {
    for (int i = 0; i < sides; ++i) {
      if (n.dot(side[i]) < 0.0) return true;
    }
    return false;
  }
  void face(const Vec3& n, FaceOwner owner, double bias) {
    if (leads_through(n)) return;
    const double s = separation(a, b, n);
    if (has_face && s <= best_face.separation + bias) return;
    best_face = {n, s, owner};
    has_face = true;
  }
  void other(const Vec3& n, double bias) {
    if (leads_through(n)) return;
    const double s = separation(a, b, n);
    if (has_other && s <= best_other.separation + bias) return;
    best_other = {n, s, FaceOwner::None};
    has_other = true;
  }
  /// Tries all face normals of a, or of b with opposite sign.
  void faces_of(const ConvexCore& core, FaceOwner owner, double bias) {
    const double sign = owner == FaceOwner::A ? 1.0 : -1.0;
    if (core.kind != CoreKind::Box) {
      for (int i = 0; i < face_count(core); ++i) face(sign * face_normal(core, i), owner, bias);
      return;
    }
    // Both signs: with deep overlap the centres are no guide.
    for (int i = 0; i < 3; ++i) {
      // Towards b first, which wins a tie.
      const Vec3 n = core.axes.col(i);
      const double towards = n.dot(b.centre - a.centre) < 0.0 ? -1.0 : 1.0;
      face(towards * n, owner, bias);
      face(-towards * n, owner, bias);
    }
  }
  /// Takes the best face of `owner` instead of the other's if it is about as good.
  void prefer_faces_of(FaceOwner owner) {
    if (!has_face || best_face.owner == owner) return;
    const ContactAxis other = std::exchange(best_face, {});
    has_face = false;
    faces_of(owner == FaceOwner::A ? a : b, owner, kRoundTolerance);
    const double tolerance =
        kFaceShare * std::max(0.0, -other.separation) + kFaceSize * std::min(a.size, b.size);
    if (!has_face || best_face.separation < other.separation - tolerance) best_face = other;
    has_face = true;
  }
  void cross(const Vec3& u, const Vec3& v, double bias) {
    const Vec3 n = u.cross(v);
    const double length = n.norm();
    if (!(length > kMinCross * u.norm() * v.norm())) return;
    other(n / length, bias);
    other(-n / length, bias);
  }
};

/// More edge products than this are not searched if there is a hint.
constexpr int kManyEdges = 64;

/// Climbs from a direction to a local optimum. Steps are halved down to 1e-6 rad. They are tried
/// first down the slope of the two foremost points, then around, with an offset each time, because
/// the separation has ridges.
Vec3 hill_climb(const ConvexCore& a, const ConvexCore& b, Vec3 n, double step) {
  constexpr double kTurn = 0.61;  // rad
  double best = separation(a, b, n);
  double angle = 0.0;
  while (step > 1e-6) {
    const Vec3 u = n.unitOrthogonal();
    const Vec3 v = n.cross(u);
    const Vec3 w = b.support(-n) - a.support(n);
    const Vec3 slope = w - n.dot(w) * n;
    const double length = slope.norm();
    bool better = false;
    for (int i = length > 1e-12 ? -1 : 0; i < 6 && !better; ++i) {
      const auto across = [&] {
        const auto turn = pbd::portable::sin_cos(angle + i * (std::numbers::pi / 3.0));
        return Vec3(turn.cos * u + turn.sin * v);
      };
      const Vec3 t = i < 0 ? Vec3(slope / length) : across();
      const Vec3 m = (n + step * t).normalized();
      const double value = separation(a, b, m);
      if (value <= best) continue;
      best = value;
      n = m;
      better = true;
    }
    angle += kTurn;
    if (!better) step *= 0.6;
  }
  return n;
}

/// Climbs from the best of directions all around.
void sample_sphere(Candidates& c) {
  constexpr int kCount = 64;
  constexpr int kClimbs = 4;
  constexpr double kGolden = 2.399963229728653;  // rad
  std::array<std::pair<double, Vec3>, kCount> tried;
  for (int i = 0; i < kCount; ++i) {  // a spiral around the sphere
    const double z = 1.0 - (2.0 * i + 1.0) / kCount;
    const double r = std::sqrt(1.0 - z * z);
    const auto turn = pbd::portable::sin_cos(kGolden * i);
    const Vec3 n(r * turn.cos, r * turn.sin, z);
    tried[i] = {separation(c.a, c.b, n), n};
  }
  // The upper one of equals: standard libraries differ in their order.
  std::partial_sort(tried.begin(), tried.begin() + kClimbs, tried.end(),
                    [](const auto& l, const auto& r) {
                      return std::pair(l.first, l.second.z()) > std::pair(r.first, r.second.z());
                    });
  for (int i = 0; i < kClimbs; ++i) c.other(hill_climb(c.a, c.b, tried[i].second, 0.2), 0.0);
}

/// For overlapping cores: searches edge products, and the neighbourhood of known directions.
void search(Candidates& c, const Vec3* hint, double tie) {
  const ConvexCore& a = c.a;
  const ConvexCore& b = c.b;
  const int count_a = edge_count(a);
  const int count_b = edge_count(b);
  const bool curved = a.curved() || b.curved();
  if (hint != nullptr) {
    c.other(*hint, 0.0);
    const CoreEdge edge_a = edge_towards(a, *hint);
    const CoreEdge edge_b = edge_towards(b, -*hint);
    c.cross(edge_a.to - edge_a.from, edge_b.to - edge_b.from, tie);
  }
  if (hint == nullptr || count_a * count_b <= kManyEdges) {
    for (int i = 0; i < count_a; ++i) {
      const Vec3 u = edge_direction(a, i);
      for (int j = 0; j < count_b; ++j) c.cross(u, edge_direction(b, j), tie);
    }
  }
  if (curved) {
    // Perpendicular to each curved side towards the other shape, and between the centres.
    for (const ConvexCore* core : {&a, &b}) {
      if (!core->curved()) continue;
      const Vec3 axis = core->axes.col(2);
      const Vec3 between = b.centre - a.centre;
      const Vec3 across = between - between.dot(axis) * axis;
      if (across.norm() > 1e-9) c.other(across.normalized(), tie);
      const Vec3 x = core->axes.col(0);
      const Vec3 y = core->axes.col(1);
      for (const Vec3& n : {x, y, Vec3(-x), Vec3(-y)}) c.other(n, tie);
    }
    if (c.has_other) c.other(hill_climb(a, b, c.best_other.normal, 0.05), 0.0);
    if (hint == nullptr) sample_sphere(c);
  } else if (hint != nullptr && count_a * count_b > kManyEdges) {
    const Vec3 near = hill_climb(a, b, c.best_other.normal, 0.05);
    const CoreEdge edge_a = edge_towards(a, near);
    const CoreEdge edge_b = edge_towards(b, -near);
    c.other(near, 0.0);
    c.cross(edge_a.to - edge_a.from, edge_b.to - edge_b.from, -kRoundTolerance);
  }
}

/// Whether boxes that are apart along n will touch there. False if they still pass by each other
/// along one of their faces when they meet, like a box sliding from one tile of a floor to the next
/// of equal height.
bool will_meet(const ConvexCore& a, const ConvexCore& b, const ContactAxis& axis,
               const Reach& reach) {
  const double closing = -axis.normal.dot(reach.sweep);
  const double share = closing > axis.separation ? axis.separation / closing : 1.0;
  const double slop = kPassBy * std::min(a.size, b.size);
  for (const ConvexCore* core : {&a, &b}) {
    for (int i = 0; i < 3; ++i) {
      Vec3 n = core->axes.col(i);  // from a to b: with the opposite sign they are not apart
      if (n.dot(b.centre - a.centre) < 0.0) n = -n;
      if (n.dot(axis.normal) > kAcross) continue;
      const double now = separation(a, b, n);
      const double then = now + share * n.dot(reach.sweep);
      if (now > -slop && then > -slop) return false;
    }
  }
  return true;
}

/// Contact at the features furthest along the normal, none of them a face.
void edge_contact(const ConvexCore& a, const ConvexCore& b, const ContactAxis& axis,
                  const Reach& reach, RawManifold& out) {
  const double radii = a.radius + b.radius;
  const Vec3& n = axis.normal;
  std::array<RawPoint, 2> points;
  const int count = edge_points(edge_towards(a, n), edge_towards(b, -n), n, radii, points);
  const double size = std::min(a.size, b.size);
  const double true_gap = axis.separation - radii;
  // The chosen edges may not be those that touch (a corner has several): use the furthest points.
  if (count == 1 && points[0].gap > true_gap + 0.01 * size) {
    points[0].on_b = b.support(-n);
    points[0].on_a = points[0].on_b - axis.separation * n;
    points[0].gap = true_gap;
  }
  for (int i = 0; i < count; ++i) {
    if (points[i].gap < reach.margin) out.add(points[i]);
  }
}

}  // namespace

ContactAxis front_axis(const ConvexCore& a, const ConvexCore& b) {
  const Vec3 n = -b.front;
  return {n, separation(a, b, n), FaceOwner::B};
}

ContactAxis choose_axis(const ConvexCore& a, const ConvexCore& b, const Direction& direction,
                        const Vec3* hint, FaceOwner ground) {
  const bool known = direction.status == Direction::Status::Found;
  const Vec3& n = direction.normal;
  const bool round = a.radius + b.radius > 0.0;
  const double tie = kRoundTolerance;
  Candidates c{.a = a, .b = b};
  if (!known) c.find_sides();
  c.faces_of(a, FaceOwner::A, tie);
  c.faces_of(b, FaceOwner::B, tie);
  if (b.kind == CoreKind::Triangle) c.face(-b.front, FaceOwner::B, tie);
  if (ground != FaceOwner::None) c.prefer_faces_of(ground);
  // For overlapping cores no direction is better than 0, and a face this near to it is taken.
  const bool shallow = !known && !round && c.has_face &&
                       c.best_face.separation >= -kFaceSize * std::min(a.size, b.size);
  if (shallow) return c.best_face;
  if (known) {
    c.other(n, 0.0);
    if (a.kind != CoreKind::Point && (a.kind != CoreKind::Box || b.kind != CoreKind::Box)) {
      const CoreEdge edge_a = edge_towards(a, n);
      const CoreEdge edge_b = edge_towards(b, -n);
      c.cross(edge_a.to - edge_a.from, edge_b.to - edge_b.from, -kRoundTolerance);
    }
  } else if (a.kind != CoreKind::Point) {
    search(c, hint, tie);
  }
  if (!c.has_face) {
    if (c.has_other) return c.best_other;
    // Two points or segments in one place: any perpendicular direction.
    const Vec3 across = a.kind == CoreKind::Segment   ? Vec3(a.axes.col(0))
                        : b.kind == CoreKind::Segment ? Vec3(b.axes.col(0))
                                                      : Vec3::UnitZ();
    return {across, separation(a, b, across), FaceOwner::None};
  }
  if (!c.has_other) return c.best_face;
  const double best = std::max(c.best_face.separation, c.best_other.separation);
  const double tolerance =
      round ? kRoundTolerance
            : kFaceShare * std::max(0.0, -best) + kFaceSize * std::min(a.size, b.size);
  // If the library names a face itself, its choice among near-equal faces stands.
  if (known && !round) {
    ContactAxis named = c.best_face;
    double alignment = kSameDirection;
    const auto compare = [&](const ConvexCore& core, FaceOwner owner) {
      if (core.kind != CoreKind::Box) return;
      for (int i = 0; i < 3; ++i) {
        const double cosine = n.dot(core.axes.col(i));
        if (std::abs(cosine) <= alignment) continue;
        alignment = std::abs(cosine);
        const Vec3 face = (cosine < 0.0 ? -1.0 : 1.0) * core.axes.col(i);
        named = {face, separation(a, b, face), owner};
      }
    };
    compare(a, FaceOwner::A);
    compare(b, FaceOwner::B);
    if (named.separation >= c.best_face.separation - tolerance) c.best_face = named;
  }
  return c.best_face.separation >= best - tolerance ? c.best_face : c.best_other;
}

RawManifold build_manifold(const ConvexCore& a, const ConvexCore& b, const ContactAxis& axis,
                           const Reach& reach) {
  RawManifold out;
  out.normal = axis.normal;
  out.owner = axis.owner;
  const Vec3& n = axis.normal;
  const double radii = a.radius + b.radius;
  if (axis.separation - radii >= reach.margin) return out;
  const bool boxes = a.kind == CoreKind::Box && b.kind == CoreKind::Box;
  if (boxes && axis.separation > 0.0 && !will_meet(a, b, axis, reach)) return out;
  if (a.kind == CoreKind::Point) {
    const Vec3 on_b = b.kind == CoreKind::Point ? b.centre : a.centre + axis.separation * n;
    out.add({a.centre, on_b, axis.separation - radii, 0});
    return out;
  }
  if (axis.owner != FaceOwner::None) {
    face_contact(a, b, axis, reach, out);
    if (out.count > 0) return out;
  } else if (serve_by_face(a, b, axis, reach, out)) {
    return out;
  }
  edge_contact(a, b, axis, reach, out);
  return out;
}

RawManifold half_space_manifold(const ConvexCore& a, const Vec3& normal, double offset,
                                double margin) {
  RawManifold out;
  out.normal = -normal;
  out.owner = FaceOwner::B;
  const auto add = [&](const Vec3& p, std::uint32_t feature) {
    const double height = normal.dot(p) - offset;
    if (height - a.radius >= margin || out.has(feature)) return;
    out.add({p, p - height * normal, height - a.radius, feature});
  };
  const auto add_face = [&](const CoreFace& face) {
    for (int i = 0; i < face.count; ++i) {
      add(face.corners[i], corner_feature(false, face.corner_ids[i]));
    }
  };
  if (a.kind == CoreKind::Box) {
    // The four lowest corners: of a face all of them; of an edge two are far away.
    std::array<RawPoint, 8> corners;
    for (std::uint32_t bits = 0; bits < 8; ++bits) {
      Vec3 p = a.centre;
      for (int i = 0; i < 3; ++i) {
        p += ((bits >> i & 1u) != 0 ? a.half[i] : -a.half[i]) * a.axes.col(i);
      }
      corners[bits] = {p, p, normal.dot(p), corner_feature(false, bits)};
    }
    std::sort(corners.begin(), corners.end(), [](const RawPoint& l, const RawPoint& r) {
      return l.gap != r.gap ? l.gap < r.gap : l.feature < r.feature;
    });
    std::sort(corners.begin(), corners.begin() + 4,
              [](const RawPoint& l, const RawPoint& r) { return l.feature < r.feature; });
    for (int i = 0; i < 4; ++i) add(corners[i].on_a, corners[i].feature);
  } else if (a.kind == CoreKind::Point) {
    add(a.centre, 0);
  } else {
    BearingFaces faces(a, -normal);
    CoreFace face;
    while (faces.next(face)) add_face(face);
  }
  return out;
}

}  // namespace tandem::collision
