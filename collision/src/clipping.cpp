// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "clipping.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tandem::collision {
namespace {

/// m: a corner this far outside a side plane still counts as inside, so that aligned boxes keep
/// their corners and their features.
constexpr double kClipSlop = 1e-6;
/// Sine below which two edges count as parallel.
constexpr double kParallel = 0.05;
/// A later candidate must beat an earlier one by this factor.
constexpr double kBias = 0.95;
/// Share of the slop by which a point must be below the others to replace one as support.
constexpr double kBearing = 0.1;

/// Corner of the polygon being clipped. `edge` names the edge to the next corner: >= 0 an edge of
/// the incident face, else ~k for side k of the reference face.
struct Corner {
  Vec3 p;
  std::uint32_t feature;
  int edge;
};

struct Ids {
  const CoreFace& reference;
  const CoreFace& incident;
  bool reference_is_a;

  /// Feature at the intersection of side k of the reference with the polygon edge `edge`.
  std::uint32_t at(int edge, int k) const {
    if (edge >= 0) {
      const std::uint32_t r = reference.edge_ids[k];
      const std::uint32_t i = incident.edge_ids[edge];
      return reference_is_a ? crossing_feature(r, i) : crossing_feature(i, r);
    }
    // Two neighbouring sides of the reference meet in one of its corners.
    const int other = ~edge;
    const int corner = (k + 1) % reference.count == other ? other : k;
    return corner_feature(!reference_is_a, reference.corner_ids[corner]);
  }
};

/// Unit normal, out of the prism, of its side over edge k. The axis may have either sign.
Vec3 side_normal(const CoreFace& reference, const Vec3& axis, int k) {
  const Vec3& from = reference.corners[k];
  const Vec3 out = (reference.corners[(k + 1) % reference.count] - from).cross(axis).normalized();
  const Vec3& opposite = reference.corners[(k + 2) % reference.count];
  return out.dot(opposite - from) > 0.0 ? -out : out;
}

ClippedFace clip_segment(const CoreFace& reference, const Vec3& axis, const CoreFace& incident,
                         const Ids& ids) {
  double t0 = 0.0;
  double t1 = 1.0;
  std::uint32_t f0 = corner_feature(ids.reference_is_a, incident.corner_ids[0]);
  std::uint32_t f1 = corner_feature(ids.reference_is_a, incident.corner_ids[1]);
  const Vec3 d = incident.corners[1] - incident.corners[0];
  for (int k = 0; k < reference.count; ++k) {
    const Vec3& from = reference.corners[k];
    const Vec3 out = side_normal(reference, axis, k);
    const double at0 = out.dot(incident.corners[0] - from);
    const double slope = out.dot(d);
    const double at1 = at0 + slope;
    if (at0 > kClipSlop && at1 > kClipSlop) return {};
    // Within the slop the intersection may be beyond an end of the segment.
    const double t = std::clamp(-at0 / slope, 0.0, 1.0);
    if (at0 > kClipSlop) {
      if (t > t0) {
        t0 = t;
        f0 = ids.at(0, k);
      }
    } else if (at1 > kClipSlop) {
      if (t < t1) {
        t1 = t;
        f1 = ids.at(0, k);
      }
    }
  }
  if (t0 > t1) return {};
  ClippedFace out;
  out.corners[out.count++] = {incident.corners[0] + t0 * d, f0};
  if ((t1 - t0) * d.norm() > kClipSlop) {
    out.corners[out.count++] = {incident.corners[0] + t1 * d, f1};
  }
  return out;
}

/// Sutherland-Hodgman; distance(k, p) is how far p is outside side k. A convex n-gon gains at most
/// one corner per side.
ClippedFace clip_polygon(const CoreFace& reference, const CoreFace& incident, const Ids& ids,
                         auto&& distance) {
  constexpr int kMax = 2 * CoreFace::kMaxCorners;
  std::array<Corner, kMax> one;
  std::array<Corner, kMax> two;
  Corner* polygon = one.data();
  Corner* next = two.data();
  int count = incident.count;
  for (int i = 0; i < count; ++i) {
    polygon[i] = {incident.corners[i], corner_feature(ids.reference_is_a, incident.corner_ids[i]),
                  i};
  }
  std::array<double, kMax> outside;
  for (int k = 0; k < reference.count && count > 0; ++k) {
    double furthest = -1.0;
    for (int i = 0; i < count; ++i) {
      outside[i] = distance(k, polygon[i].p);
      furthest = std::max(furthest, outside[i]);
    }
    if (furthest <= kClipSlop) continue;
    int made = 0;
    const auto push = [&](const Corner& corner) {
      if (made < kMax) next[made++] = corner;
    };
    for (int i = 0; i < count; ++i) {
      const int j = i + 1 == count ? 0 : i + 1;
      const bool in_i = outside[i] <= kClipSlop;
      const bool in_j = outside[j] <= kClipSlop;
      if (in_i) push(polygon[i]);
      if (in_i != in_j) {
        // Both ends may be outside the exact plane, one within the slop: stay on the edge.
        const double t = std::clamp(outside[i] / (outside[i] - outside[j]), 0.0, 1.0);
        const Corner cut{polygon[i].p + t * (polygon[j].p - polygon[i].p),
                         ids.at(polygon[i].edge, k), in_i ? ~k : polygon[i].edge};
        // A corner within the slop is not duplicated by the cut next to it.
        const Vec3& kept = in_i ? polygon[i].p : polygon[j].p;
        if ((cut.p - kept).squaredNorm() > kClipSlop * kClipSlop) {
          push(cut);
        } else if (in_i && made > 0) {
          next[made - 1].edge = ~k;
        }
      }
    }
    std::swap(polygon, next);
    count = made;
  }
  ClippedFace result;
  result.count = count;
  for (int i = 0; i < count; ++i) result.corners[i] = {polygon[i].p, polygon[i].feature};
  return result;
}

/// Nearest points of two segments u and v whose origins are w apart, as shares of their lengths,
/// from their scalar products. Source: [ericson2005] Sec. 5.1.9.
std::pair<double, double> nearest_shares(double uu, double vv, double uv, double uw, double vw) {
  if (vv <= 0.0) return {uu > 0.0 ? std::clamp(-uw / uu, 0.0, 1.0) : 0.0, 0.0};
  const double sine2_uuvv = uu * vv - uv * uv;
  double s = 0.0;
  if (uu > 0.0 && sine2_uuvv > 1e-14 * uu * vv) {
    s = std::clamp((uv * vw - uw * vv) / sine2_uuvv, 0.0, 1.0);
  }
  double t = (uv * s + vw) / vv;
  if (t < 0.0 || t > 1.0) {
    t = std::clamp(t, 0.0, 1.0);
    s = uu > 0.0 ? std::clamp((t * uv - uw) / uu, 0.0, 1.0) : 0.0;
  }
  return {s, t};
}

}  // namespace

ClippedFace clip_face(const CoreFace& reference, const Vec3& axis, const CoreFace& incident,
                      bool reference_is_a) {
  const Ids ids{reference, incident, reference_is_a};
  if (incident.count == 2) return clip_segment(reference, axis, incident, ids);
  std::array<Vec3, CoreFace::kMaxCorners> sides;
  for (int k = 0; k < reference.count; ++k) sides[k] = side_normal(reference, axis, k);
  return clip_polygon(reference, incident, ids,
                      [&](int k, const Vec3& p) { return sides[k].dot(p - reference.corners[k]); });
}

ClippedFace clip_to_rectangle(const CoreFace& reference, int u, int v, const Vec3& half,
                              const CoreFace& incident, bool reference_is_a) {
  const Ids ids{reference, incident, reference_is_a};
  std::array<int, 4> axis;
  std::array<double, 4> sign;
  for (int k = 0; k < 4; ++k) {  // side k from corner k to the next: its constant coordinate
    const Vec3& from = reference.corners[k];
    const Vec3& to = reference.corners[(k + 1) % 4];
    axis[k] = (from[u] > 0.0) == (to[u] > 0.0) ? u : v;
    sign[k] = from[axis[k]] > 0.0 ? 1.0 : -1.0;
  }
  return clip_polygon(reference, incident, ids,
                      [&](int k, const Vec3& p) { return sign[k] * p[axis[k]] - half[axis[k]]; });
}

int edge_points(const CoreEdge& a, const CoreEdge& b, const Vec3& normal, double radii,
                std::array<RawPoint, 2>& out) {
  const Vec3 u = a.to - a.from;
  const Vec3 v = b.to - b.from;
  const Vec3 w = a.from - b.from;
  const double uu = u.squaredNorm();
  const double vv = v.squaredNorm();
  const double uv = u.dot(v);
  const double uw = u.dot(w);
  const double vw = v.dot(w);
  const double sine2_uuvv = uu * vv - uv * uv;
  const auto put = [&](int i, double s, double t, std::uint32_t feature) {
    RawPoint& point = out[i];
    point.on_a = a.from + s * u;
    point.on_b = b.from + t * v;
    point.gap = normal.dot(point.on_b - point.on_a) - radii;
    point.feature = feature;
  };
  const auto corner_a = [&](double s) {
    return corner_feature(false, s < 0.5 ? a.from_id : a.to_id);
  };
  const auto corner_b = [&](double t) {
    return corner_feature(true, t < 0.5 ? b.from_id : b.to_id);
  };

  if (uu > 0.0 && vv > 0.0 && sine2_uuvv <= kParallel * kParallel * uu * vv) {
    // Position of the ends of b along a, as a share of its length.
    const double s_from = -uw / uu;
    const double s_to = s_from + uv / uu;
    const double low = std::max(0.0, std::min(s_from, s_to));
    const double high = std::min(1.0, std::max(s_from, s_to));
    if ((high - low) * std::sqrt(uu) > kClipSlop) {
      const std::array<double, 2> ends{low, high};
      for (int i = 0; i < 2; ++i) {
        const double s = ends[i];
        const double t = std::clamp((s - s_from) / (s_to - s_from), 0.0, 1.0);
        put(i, s, t, s <= 0.0 || s >= 1.0 ? corner_a(s) : corner_b(t));
      }
      return 2;
    }
  }
  const auto [s, t] = nearest_shares(uu, vv, uv, uw, vw);
  const bool a_end = s <= 0.0 || s >= 1.0;
  const bool b_end = t <= 0.0 || t >= 1.0;
  put(0, s, t, a_end ? corner_a(s) : b_end ? corner_b(t) : crossing_feature(a.id, b.id));
  return 1;
}

/// Doubled area of a triangle, m^2, about the normal.
static double area(const Vec3& normal, const Vec3& a, const Vec3& b, const Vec3& c) {
  return normal.dot((b - a).cross(c - a));
}

/// Barycentric coordinates of p in the triangle of the first three points, seen along the normal.
static Vec3 shares(const RawPoint* points, const Vec3& normal, const Vec3& p) {
  const Vec3& a = points[0].on_b;
  const Vec3& b = points[1].on_b;
  const Vec3& c = points[2].on_b;
  const double u = area(normal, p, b, c);
  const double v = area(normal, a, p, c);
  const double w = area(normal, a, b, p);
  const double sum = u + v + w;
  return sum == 0.0 ? Vec3(Vec3::Constant(-HUGE_VAL)) : Vec3(Vec3(u, v, w) / sum);
}

/// Height of a point above the plane of the first three, m.
static double above(const RawPoint* points, const Vec3& normal, const RawPoint& p) {
  return p.gap -
         shares(points, normal, p.on_b).dot(Vec3(points[0].gap, points[1].gap, points[2].gap));
}

/// Replaces one of the first three points by point i so that the weight is supported best.
static void exchange(RawPoint* points, int i, const Vec3& normal, const Vec3& weight) {
  int best = 0;
  double inside = -HUGE_VAL;
  for (int k = 0; k < 3; ++k) {
    std::swap(points[k], points[i]);
    const double least = shares(points, normal, weight).minCoeff();
    std::swap(points[k], points[i]);
    if (least <= inside) continue;
    inside = least;
    best = k;
  }
  std::swap(points[best], points[i]);
}

/// Exchanges the first three points until no point is below their plane: these support the weight,
/// and a tilt does not change the choice. The fourth point is the deepest, if it is not among them,
/// else the one that the body would tip on to first, over the side nearest to the weight. Returns
/// whether any was exchanged; there are four points then.
static bool settle(RawPoint* points, int count, const Vec3& normal, double slop,
                   const Vec3& weight) {
  bool changed = false;
  for (int turn = 0; turn < 2 * count; ++turn) {
    int lowest = -1;
    double least = -slop;
    for (int i = 3; i < count; ++i) {
      const double height = above(points, normal, points[i]);
      if (height >= least) continue;
      least = height;
      lowest = i;
    }
    if (lowest < 0) break;
    exchange(points, lowest, normal, weight);
    changed = true;
  }
  const auto deeper = [](const RawPoint& l, const RawPoint& r) { return l.gap < r.gap; };
  RawPoint* const deepest = std::min_element(points, points + count, deeper);
  if (deepest->gap < std::min_element(points, points + 3, deeper)->gap - slop) {
    std::swap(points[3], *deepest);
    return true;
  }
  Eigen::Index side = 0;
  shares(points, normal, weight).minCoeff(&side);
  const auto first_met = [&](const RawPoint& p) {
    return -shares(points, normal, p.on_b)[side] / (std::max(0.0, above(points, normal, p)) + slop);
  };
  int best = 3;
  double most = std::max(0.0, first_met(points[3]));
  for (int i = 4; i < count; ++i) {
    const double score = kBias * first_met(points[i]);
    if (!(score > most)) continue;
    most = score;
    best = i;
  }
  std::swap(points[3], points[best]);
  return changed || best > 3;
}

int reduce(RawPoint* points, int count, const Vec3& normal, double slop, const Vec3& weight,
           const std::uint32_t* kept, int kept_count) {
  if (count <= 4) return count;
  const auto preferred = [&](const RawPoint& p) {
    return std::find(kept, kept + kept_count, p.feature) != kept + kept_count;
  };
  // Points of the last choice first, then by feature: earlier ones win near-ties.
  std::sort(points, points + count, [&](const RawPoint& l, const RawPoint& r) {
    const bool pl = preferred(l);
    const bool pr = preferred(r);
    if (pl != pr) return pl;
    return l < r;
  });
  double deepest = points[0].gap;
  Vec3 middle = Vec3::Zero();
  for (int i = 0; i < count; ++i) {
    deepest = std::min(deepest, points[i].gap);
    middle += points[i].on_b;
  }
  middle /= count;
  /// Moves the point with the best score to index `at`.
  const auto take = [&](int at, auto&& score) {
    int best = -1;
    double best_score = 0.0;
    for (int i = at; i < count; ++i) {
      const double value = score(points[i]);
      if (value > 0.0 && (best < 0 || kBias * value > best_score)) {
        best = i;
        best_score = value;
      }
    }
    if (best < 0) return false;
    std::rotate(points + at, points + best, points + best + 1);
    return true;
  };
  const auto flat = [&](const Vec3& v) { return Vec3(v - normal.dot(v) * normal); };
  // The outermost of the deepest points, so that the support is as wide as possible.
  if (!take(0, [&](const RawPoint& p) {
        return p.gap <= deepest + slop ? 1e-30 + flat(p.on_b - middle).squaredNorm() : 0.0;
      })) {
    return 4;
  }
  const Vec3 p0 = points[0].on_b;
  if (!take(1, [&](const RawPoint& p) { return flat(p.on_b - p0).squaredNorm(); })) return 1;
  const Vec3 p1 = points[1].on_b;
  const auto area = [&](const Vec3& p) { return normal.dot((p1 - p0).cross(p - p0)); };
  if (!take(2, [&](const RawPoint& p) { return std::abs(area(p.on_b)); })) return 2;
  const Vec3 p2 = points[2].on_b;
  // Largest gain outside the triangle.
  const double turn = area(p2) > 0.0 ? 1.0 : -1.0;
  const auto outside = [&](const Vec3& from, const Vec3& to, const Vec3& p) {
    return -turn * normal.dot((to - from).cross(p - from));
  };
  const bool fourth = take(3, [&](const RawPoint& p) {
    return std::max({outside(p0, p1, p.on_b), outside(p1, p2, p.on_b), outside(p2, p0, p.on_b)});
  });
  return settle(points, count, normal, kBearing * slop, weight) || fourth ? 4 : 3;
}

double least_left_out(const RawPoint* points, int chosen, int count, double slop) {
  const auto lowest = [&](int from, int to, double start) {
    for (int i = from; i < to; ++i) start = std::min(start, points[i].gap);
    return start;
  };
  return lowest(chosen, count, HUGE_VAL) - lowest(0, chosen, 0.0) + kBearing * slop;
}

}  // namespace tandem::collision
