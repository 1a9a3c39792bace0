// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "shape_record.h"

#include <cmath>
#include <variant>

namespace tandem::mpi {
namespace {

using collision::Box;
using collision::Capsule;
using collision::Cone;
using collision::Cylinder;
using collision::Sphere;

enum class Kind : std::uint8_t { Sphere, Box, Capsule, Cylinder, Cone, Other };

Kind kind_of(const collision::Shape& shape) {
  if (std::holds_alternative<Sphere>(shape)) return Kind::Sphere;
  if (std::holds_alternative<Box>(shape)) return Kind::Box;
  if (std::holds_alternative<Capsule>(shape)) return Kind::Capsule;
  if (std::holds_alternative<Cylinder>(shape)) return Kind::Cylinder;
  if (std::holds_alternative<Cone>(shape)) return Kind::Cone;
  return Kind::Other;
}

/// The numbers of a shape: three of them at most.
pbd::Vec3 numbers_of(const collision::Shape& shape) {
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
    case Kind::Other:
      break;
  }
  return pbd::Vec3::Zero();
}

collision::Shape shape_of(Kind kind, const pbd::Vec3& n) {
  switch (kind) {
    case Kind::Sphere:
      return Sphere{n.x()};
    case Kind::Capsule:
      return Capsule{n.x(), n.y()};
    case Kind::Cylinder:
      return Cylinder{n.x(), n.y()};
    case Kind::Cone:
      return Cone{n.x(), n.y()};
    case Kind::Box:
    case Kind::Other:
      break;
  }
  return Box{n};
}

}  // namespace

bool can_move(const collision::Shape& shape) { return kind_of(shape) != Kind::Other; }

bool is_surface(const collision::Shape& shape) {
  return std::holds_alternative<collision::Mesh>(shape) ||
         std::holds_alternative<collision::Field>(shape);
}

double reach_of(const collision::ColliderDef& collider) {
  const pbd::Vec3 n = numbers_of(collider.shape);
  double own = n.norm();
  if (kind_of(collider.shape) == Kind::Capsule) own = n.x() + n.y();
  return collider.local.position.norm() + own;
}

void write_collider(const collision::ColliderDef& collider, MessageWriter& out) {
  out.put(kind_of(collider.shape));
  out.vec3(numbers_of(collider.shape));
  out.vec3(collider.local.position);
  out.quat(collider.local.orientation);
  out.put(collider.material);
  out.put(collider.filter);
  out.put<std::uint8_t>(collider.sensor ? 1 : 0);
  out.put(collider.user_data);
}

bool read_collider(MessageReader& in, collision::ColliderDef& collider) {
  const auto kind = in.get<Kind>();
  collider.shape = shape_of(kind, in.vec3());
  collider.local.position = in.vec3();
  collider.local.orientation = in.quat();
  collider.material = in.get<collision::Material>();
  collider.filter = in.get<collision::Filter>();
  collider.sensor = in.get<std::uint8_t>() != 0;
  collider.user_data = in.get<std::uint64_t>();
  return !in.failed() && kind < Kind::Other;
}

}  // namespace tandem::mpi
