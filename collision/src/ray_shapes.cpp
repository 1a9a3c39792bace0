// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "ray_shapes.h"

#include <algorithm>
#include <cmath>

#include "gjk.h"
#include "tandem/pbd/portable.h"

namespace tandem::collision {
namespace {

/// Where the ray from `start`, which is outside, enters a ball about the origin, or HUGE_VAL. Uses
/// the ray's nearest point, to keep precision far away.
double enter_ball(const Vec3& start, const Vec3& direction, double radius) {
  const double along = -start.dot(direction);
  if (along < 0.0) return HUGE_VAL;
  const double across2 = (start + along * direction).squaredNorm();
  const double half2 = radius * radius - across2;
  return half2 >= 0.0 ? along - std::sqrt(half2) : HUGE_VAL;
}

struct Entry {
  double distance = HUGE_VAL;
  Vec3 normal = Vec3::UnitZ();  ///< in the shape's frame
};

RayResult ray_ball(const Vec3& start, const Vec3& d, double radius, Entry& out) {
  if (start.squaredNorm() <= radius * radius) return RayResult::Inside;
  out.distance = enter_ball(start, d, radius);
  if (out.distance == HUGE_VAL) return RayResult::Miss;
  out.normal = (start + out.distance * d).normalized();
  return RayResult::Hit;
}

RayResult ray_capsule(const Vec3& start, const Vec3& d, double radius, double half, Entry& out) {
  const Vec3 nearest(0.0, 0.0, std::clamp(start.z(), -half, half));
  if ((start - nearest).squaredNorm() <= radius * radius) return RayResult::Inside;
  for (const double end : {-half, half}) {
    const Vec3 centre(0.0, 0.0, end);
    const double t = enter_ball(start - centre, d, radius);
    if (t >= out.distance) continue;
    out.distance = t;
    out.normal = (start + t * d - centre).normalized();
  }
  // The side, seen along the axis: a disc crossed at a lower speed.
  const double pace = pbd::portable::hypot(d.x(), d.y());
  if (pace > 1e-12) {
    const Vec3 flat(start.x(), start.y(), 0.0);
    const double t = enter_ball(flat, Vec3(d.x(), d.y(), 0.0) / pace, radius) / pace;
    if (t >= 0.0 && t < out.distance && std::abs(start.z() + t * d.z()) <= half) {
      out.distance = t;
      out.normal = Vec3(start.x() + t * d.x(), start.y() + t * d.y(), 0.0).normalized();
    }
  }
  return out.distance < HUGE_VAL ? RayResult::Hit : RayResult::Miss;
}

RayResult ray_box(const Vec3& start, const Vec3& d, const Vec3& half, Entry& out) {
  if ((start.cwiseAbs().array() <= half.array()).all()) return RayResult::Inside;
  double from = -HUGE_VAL;
  double to = HUGE_VAL;
  for (int k = 0; k < 3; ++k) {
    if (std::abs(d[k]) < 1e-100) {
      if (std::abs(start[k]) > half[k]) return RayResult::Miss;
      continue;
    }
    const double side = d[k] > 0.0 ? 1.0 : -1.0;
    const double enter = (-side * half[k] - start[k]) / d[k];
    if (enter > from) {
      from = enter;
      out.normal = Vec3::Zero();
      out.normal[k] = -side;
    }
    to = std::min(to, (side * half[k] - start[k]) / d[k]);
  }
  if (from > to || from < 0.0) return RayResult::Miss;
  out.distance = from;
  return RayResult::Hit;
}

}  // namespace

RayResult ray_core(const ConvexCore& core, const Vec3& direction, double limit, double& distance,
                   Vec3& normal) {
  const Vec3 start = -(core.axes.transpose() * core.centre);
  const Vec3 d = core.axes.transpose() * direction;
  Entry entry;
  RayResult result = RayResult::Miss;
  if (core.kind == CoreKind::Point) {
    result = ray_ball(start, d, core.radius, entry);
  } else if (core.kind == CoreKind::Segment) {
    result = ray_capsule(start, d, core.radius, core.half[2], entry);
  } else if (core.kind == CoreKind::Box && core.radius == 0.0) {
    result = ray_box(start, d, core.half, entry);
  } else {
    Proximity at;
    if (!cast_core(point_core(Vec3::Zero()), core, direction, limit, distance, at)) {
      return RayResult::Miss;
    }
    normal = -at.normal;
    return distance == 0.0 && at.gap < 0.0 ? RayResult::Inside : RayResult::Hit;
  }
  if (result != RayResult::Hit) return result;
  if (entry.distance > limit) return RayResult::Miss;
  distance = std::max(0.0, entry.distance);
  normal = core.axes * entry.normal;
  return result;
}

bool ray_triangle(const std::array<Vec3, 3>& corners, const Vec3& normal, const Vec3& direction,
                  double limit, double& distance) {
  const double pace = direction.dot(normal);
  if (pace == 0.0) return false;
  // Side of each edge on which the ray passes. Two triangles compute the same number for a common
  // edge, with opposite signs, whatever the rounding.
  bool positive = false;
  bool negative = false;
  for (int k = 0; k < 3; ++k) {
    const double side = direction.dot(corners[k].cross(corners[(k + 1) % 3]));
    positive = positive || side > 0.0;
    negative = negative || side < 0.0;
  }
  if (positive && negative) return false;
  const double t = corners[0].dot(normal) / pace;
  if (!(t >= 0.0 && t <= limit)) return false;
  distance = t;
  return true;
}

}  // namespace tandem::collision
