// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "sphere_contact.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "tandem/pbd/portable.h"

namespace tandem::collision {
namespace {

/// m: a shorter difference of two points has no direction.
constexpr double kNoDirection = 1e-9;

/// In the shape's frame: the nearest point of the core, the unit normal out of the core, and the
/// distance along it.
struct Nearest {
  Vec3 point = Vec3::Zero();
  Vec3 out = Vec3::UnitZ();
  double distance = 0.0;
};

Nearest from_point(const Vec3& p, const Vec3& point, const Vec3& fallback) {
  const Vec3 d = p - point;
  const double distance = d.norm();
  if (distance < kNoDirection) return {point, fallback, 0.0};
  return {point, d / distance, distance};
}

Nearest on_box(const Vec3& p, const Vec3& half) {
  const Vec3 inside = p.cwiseMax(-half).cwiseMin(half);
  const double distance2 = (p - inside).squaredNorm();
  if (distance2 > kNoDirection * kNoDirection) {
    const double distance = std::sqrt(distance2);
    return {inside, (p - inside) / distance, distance};
  }
  int axis = 0;
  const double depth = (half - p.cwiseAbs()).minCoeff(&axis);
  const double sign = p[axis] < 0.0 ? -1.0 : 1.0;
  Nearest n{inside, sign * Vec3::Unit(axis), -depth};
  n.point[axis] = sign * half[axis];
  return n;
}

struct Flat {
  double r, z;
};

/// A solid of revolution about z, by the outline of its half section: corners (r, z) from axis to
/// axis, counter-clockwise with r to the right; the axis itself is no side.
Nearest on_outline(const Vec3& p, const Flat* outline, int count) {
  const double r = pbd::portable::hypot(p.x(), p.y());
  const Vec3 radial = r > kNoDirection ? Vec3(p.x() / r, p.y() / r, 0.0) : Vec3(Vec3::UnitX());
  bool inside = true;
  double best = HUGE_VAL;
  Flat point{0.0, 0.0};
  Flat normal{0.0, 1.0};
  for (int i = 0; i + 1 < count; ++i) {
    const Flat from = outline[i];
    const Flat side{outline[i + 1].r - from.r, outline[i + 1].z - from.z};
    const double length = pbd::portable::hypot(side.r, side.z);
    const Flat out{side.z / length, -side.r / length};
    const double height = out.r * (r - from.r) + out.z * (p.z() - from.z);
    if (height > 0.0) inside = false;
    const double t = std::clamp(
        ((r - from.r) * side.r + (p.z() - from.z) * side.z) / (length * length), 0.0, 1.0);
    const Flat q{from.r + t * side.r, from.z + t * side.z};
    const double d = pbd::portable::hypot(r - q.r, p.z() - q.z);
    if (d >= best) continue;
    best = d;
    point = q;
    normal = out;
  }
  if (!inside && best > kNoDirection) {
    normal = {(r - point.r) / best, (p.z() - point.z) / best};
  }
  return {point.r * radial + Vec3(0, 0, point.z), normal.r * radial + Vec3(0, 0, normal.z),
          inside ? -best : best};
}

}  // namespace

SphereContact sphere_contact(const Vec3& centre, const Collider& b) {
  SphereContact contact;
  if (b.kind == Kind::HalfSpace) {
    const HalfSpace& plane = std::get<HalfSpace>(b.def.shape);
    const Vec3 n = b.rotation * plane.normal;
    contact.distance = n.dot(centre - b.position) - plane.offset;
    contact.normal = -n;
    contact.on_b = contact.distance * contact.normal;
    return contact;
  }
  const Vec3 between = centre - b.position;
  if (b.kind == Kind::Sphere) {
    const double distance = between.norm();
    contact.radius_b = std::get<Sphere>(b.def.shape).radius;
    contact.distance = distance;
    contact.on_b = -between;
    if (distance > kNoDirection) contact.normal = -between / distance;
    return contact;
  }
  const Vec3 p = b.rotation.transpose() * between;
  Nearest nearest;
  if (const auto* box = std::get_if<Box>(&b.def.shape)) {
    nearest = on_box(p, box->half_extents);
  } else if (const auto* capsule = std::get_if<Capsule>(&b.def.shape)) {
    const double z = std::clamp(p.z(), -capsule->half_height, capsule->half_height);
    nearest = from_point(p, Vec3(0, 0, z), Vec3::UnitX());
    contact.radius_b = capsule->radius;
  } else if (const auto* cylinder = std::get_if<Cylinder>(&b.def.shape)) {
    const double r = cylinder->radius;
    const double h = cylinder->half_height;
    const std::array<Flat, 4> outline{{{0, -h}, {r, -h}, {r, h}, {0, h}}};
    nearest = on_outline(p, outline.data(), 4);
  } else if (const auto* cone = std::get_if<Cone>(&b.def.shape)) {
    const double h = cone->half_height;
    const std::array<Flat, 3> outline{{{0, -h}, {cone->radius, -h}, {0, h}}};
    nearest = on_outline(p, outline.data(), 3);
  }
  contact.normal = b.rotation * -nearest.out;
  contact.on_b = b.rotation * nearest.point - between;
  contact.distance = nearest.distance;
  return contact;
}

Vec3 nearest_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c, int& region) {
  const Vec3 ab = b - a;
  const Vec3 ac = c - a;
  const Vec3 ap = p - a;
  const double d1 = ab.dot(ap);
  const double d2 = ac.dot(ap);
  if (d1 <= 0.0 && d2 <= 0.0) return region = 4, a;
  const Vec3 bp = p - b;
  const double d3 = ab.dot(bp);
  const double d4 = ac.dot(bp);
  if (d3 >= 0.0 && d4 <= d3) return region = 5, b;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return region = 0, a + d1 / (d1 - d3) * ab;
  const Vec3 cp = p - c;
  const double d5 = ab.dot(cp);
  const double d6 = ac.dot(cp);
  if (d6 >= 0.0 && d5 <= d6) return region = 6, c;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return region = 2, a + d2 / (d2 - d6) * ac;
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0) {
    const double w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return region = 1, b + w * (c - b);
  }
  const double scale = 1.0 / (va + vb + vc);
  region = 3;
  return a + (vb * scale) * ab + (vc * scale) * ac;
}

}  // namespace tandem::collision
