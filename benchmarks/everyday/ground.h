// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <span>
#include <string>

#include "tandem/scene.h"

namespace tandem::everyday {

inline constexpr double kFrame = 1.0 / 60.0;  // s
inline constexpr double kGravity = 9.81;      // m/s^2

enum class Ground { HalfSpace, Box, Mesh, Field, Hull };
inline constexpr std::array kGrounds = {Ground::HalfSpace, Ground::Box, Ground::Mesh, Ground::Field,
                                        Ground::Hull};
std::string name_of(Ground ground);

/// A static body to add to a world.
struct Solid {
  collision::Shape shape;
  SolidDef def;
};
/// Level ground with its top at z = 0, extending `reach` (m) from the origin. Cells of meshes and
/// fields are a 16th of it, without a corner at the origin.
Solid level_ground(Ground ground, double friction, double reach);

/// @tparam World  Scene or AnyWorld
template <class World>
BodyId add_ground(World& world, Ground ground, double friction, double reach) {
  const Solid solid = level_ground(ground, friction, reach);
  return world.add(solid.shape, solid.def);
}

/// A level mesh or field over x from `low` to `high` and y from -reach to reach, at z = 0.
collision::Shape level_mesh(double low, double high, double reach, int columns, int rows);

/// Depth of the lowest point below z = 0, m.
double depth_below(const Pose& shape_pose, std::span<const Vec3> points);

std::string told(std::initializer_list<std::pair<const char*, double>> values);

}  // namespace tandem::everyday
