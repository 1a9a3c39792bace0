// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "shape_record.h"

#include <algorithm>
#include <cmath>
#include <variant>

namespace tandem::mpi {
namespace {

using collision::Box;
using collision::Capsule;
using collision::Cone;
using collision::Cylinder;
using collision::Sphere;

enum class Kind : std::uint8_t { Sphere, Box, Capsule, Cylinder, Cone, Hull, Other };

Kind kind_of(const collision::Shape& shape) {
  if (std::holds_alternative<Sphere>(shape)) return Kind::Sphere;
  if (std::holds_alternative<Box>(shape)) return Kind::Box;
  if (std::holds_alternative<Capsule>(shape)) return Kind::Capsule;
  if (std::holds_alternative<Cylinder>(shape)) return Kind::Cylinder;
  if (std::holds_alternative<Cone>(shape)) return Kind::Cone;
  if (std::holds_alternative<collision::Hull>(shape)) return Kind::Hull;
  return Kind::Other;
}

/// Ordinal of a hull in `hulls`; their number if it is not there.
std::size_t place_of(const collision::Shape& shape, const Hulls& hulls) {
  const auto at = std::find(hulls.begin(), hulls.end(), std::get<collision::Hull>(shape));
  return static_cast<std::size_t>(at - hulls.begin());
}

/// The numbers of a shape: at most three.
pbd::Vec3 numbers_of(const collision::Shape& shape, const Hulls& hulls) {
  switch (kind_of(shape)) {
    case Kind::Sphere:
      return {std::get<Sphere>(shape).radius, 0.0, 0.0};
    case Kind::Box:
      return std::get<Box>(shape).half_extents;
    case Kind::Capsule:
      return {std::get<Capsule>(shape).radius, std::get<Capsule>(shape).half_height, 0.0};
    case Kind::Cylinder:
      return {std::get<Cylinder>(shape).radius, std::get<Cylinder>(shape).half_height, 0.0};
    case Kind::Cone:
      return {std::get<Cone>(shape).radius, std::get<Cone>(shape).half_height, 0.0};
    case Kind::Hull:
      return {static_cast<double>(place_of(shape, hulls)), 0.0, 0.0};
    case Kind::Other:
      break;
  }
  return pbd::Vec3::Zero();
}

/// @param n  from numbers_of(); a hull's ordinal was checked
collision::Shape shape_of(Kind kind, const pbd::Vec3& n, const Hulls& hulls) {
  switch (kind) {
    case Kind::Sphere:
      return Sphere{n.x()};
    case Kind::Capsule:
      return Capsule{n.x(), n.y()};
    case Kind::Cylinder:
      return Cylinder{n.x(), n.y()};
    case Kind::Cone:
      return Cone{n.x(), n.y()};
    case Kind::Hull:
      return hulls[static_cast<std::size_t>(n.x())];
    case Kind::Box:
    case Kind::Other:
      break;
  }
  return Box{n};
}

}  // namespace

bool can_move(const collision::Shape& shape, const Hulls& hulls) {
  if (kind_of(shape) == Kind::Hull) return place_of(shape, hulls) < hulls.size();
  return kind_of(shape) != Kind::Other;
}

bool is_surface(const collision::Shape& shape) {
  return std::holds_alternative<collision::Mesh>(shape) ||
         std::holds_alternative<collision::Field>(shape);
}

double reach_of(const collision::ColliderDef& collider) {
  if (const auto* const hull = std::get_if<collision::Hull>(&collider.shape)) {
    double furthest = 0.0;
    for (const pbd::Vec3& arm : (*hull)->arms()) furthest = std::max(furthest, arm.norm());
    return collider.local.position.norm() + (*hull)->centre().norm() + furthest;
  }
  const pbd::Vec3 n = numbers_of(collider.shape, {});
  double own = n.norm();
  if (kind_of(collider.shape) == Kind::Capsule) own = n.x() + n.y();
  return collider.local.position.norm() + own;
}

void write_collider(const collision::ColliderDef& collider, const Hulls& hulls,
                    MessageWriter& out) {
  out.put(kind_of(collider.shape));
  out.vec3(numbers_of(collider.shape, hulls));
  out.vec3(collider.local.position);
  out.quat(collider.local.orientation);
  out.put(collider.material);
  out.put(collider.filter);
  out.put<std::uint8_t>(collider.sensor ? 1 : 0);
  out.put(collider.user_data);
}

bool read_collider(MessageReader& in, const Hulls& hulls, collision::ColliderDef& collider) {
  const auto kind = in.get<Kind>();
  const pbd::Vec3 numbers = in.vec3();
  const auto count = static_cast<double>(hulls.size());
  if (kind == Kind::Hull && !(numbers.x() >= 0.0 && numbers.x() < count)) return false;
  collider.shape = shape_of(kind, numbers, hulls);
  collider.local.position = in.vec3();
  collider.local.orientation = in.quat();
  collider.material = in.get<collision::Material>();
  collider.filter = in.get<collision::Filter>();
  collider.sensor = in.get<std::uint8_t>() != 0;
  collider.user_data = in.get<std::uint64_t>();
  return !in.failed() && kind < Kind::Other;
}

}  // namespace tandem::mpi
