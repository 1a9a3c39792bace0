// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <memory>
#include <string>
#include <variant>

#include "tandem/collision/convex_hull.h"
#include "tandem/collision/height_field.h"
#include "tandem/collision/triangle_mesh.h"
#include "tandem/pbd/export.h"
#include "tandem/pbd/types.h"

namespace tandem::collision {

// Shapes are plain values in their own frame; a collider places them on a body.

/// Ball about the origin.
struct TANDEM_API Sphere {
  double radius = 0.5;  ///< m, > 0
};

/// Box about the origin, edges along the axes, from half edges: Box{0.5, 0.5, 1.0}.
struct TANDEM_API Box {
  Box() = default;
  explicit Box(const pbd::Vec3& half) : half_extents(half) {}
  Box(double half_x, double half_y, double half_z) : half_extents(half_x, half_y, half_z) {}
  pbd::Vec3 half_extents = pbd::Vec3::Constant(0.5);  ///< m, each > 0
};

/// All points within `radius` of the segment from (0, 0, -half_height) to (0, 0, half_height).
struct TANDEM_API Capsule {
  double radius = 0.25;      ///< m, > 0
  double half_height = 0.5;  ///< m, > 0; half the length of the segment, caps not included
};

/// Axis along z, from (0, 0, -half_height) to (0, 0, half_height).
struct TANDEM_API Cylinder {
  double radius = 0.5;       ///< m, > 0
  double half_height = 0.5;  ///< m, > 0
};

/// Axis along z: base of the given radius at (0, 0, -half_height), apex at (0, 0, half_height).
struct TANDEM_API Cone {
  double radius = 0.5;       ///< m, > 0
  double half_height = 0.5;  ///< m, > 0; the centre of mass lies half of it below the origin
};

/// The solid behind a plane: a point x is inside if normal . x <= offset.
struct TANDEM_API HalfSpace {
  pbd::Vec3 normal = pbd::Vec3::UnitZ();  ///< unit, out of the solid
  double offset = 0.0;                    ///< m
};

using Mesh = std::shared_ptr<const TriangleMesh>;

using Hull = std::shared_ptr<const ConvexHull>;
using Field = std::shared_ptr<const HeightField>;

using Shape = std::variant<Sphere, Capsule, Box, HalfSpace, Mesh, Cylinder, Cone, Hull, Field>;

/// Whether the shape is valid; if not, `error` names field, value and rule.
TANDEM_API bool validate(const Shape& shape, std::string* error = nullptr);

/// Mass properties of a body of the given shape.
struct TANDEM_API MassProperties {
  double mass = 0.0;                      ///< kg
  pbd::Vec3 com = pbd::Vec3::Zero();      ///< m, centre of mass in the shape's frame
  pbd::Mat3 inertia = pbd::Mat3::Zero();  ///< kg m^2, about `com`, axes of the shape's frame
};

/// @param density  kg/m^3, > 0
/// @throws std::invalid_argument  if the shape is not valid, the density is not positive or gives
///   no finite mass and inertia, or the shape has no finite volume (half-space, height field, mesh
///   with a border or turned inside out)
TANDEM_API MassProperties mass_properties(const Shape& shape, double density);

}  // namespace tandem::collision
