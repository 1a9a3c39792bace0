// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "tandem/pbd/types.h"

// The cliff as plain data, independent of the engine: the benchmarks use it with other engines.
namespace tandem::demos {

inline constexpr double kCliffHalf = 12.0;        ///< m: half extent of the ground
inline constexpr std::uint32_t kCliffCells = 64;  ///< squares along each side, two triangles each
inline constexpr double kCliffBallRadius = 0.15;  ///< m

/// Height (m) of the ground by formula: a plateau at 6 m, a slope, a plain; all wavy.
double cliff_height(double x, double y);
/// Height (m) of the triangles above (x, y) within kCliffHalf.
double cliff_surface(double x, double y);

struct CliffMesh {
  std::vector<pbd::Vec3> vertices;  ///< m
  std::vector<std::array<std::uint32_t, 3>> triangles;
};
CliffMesh cliff_mesh();

/// m: centres of ten layers of ten by ten balls above the edge, each slightly displaced.
/// @param uniform  draws from [0, 1), twice per ball
std::vector<pbd::Vec3> cliff_balls(const std::function<double()>& uniform);

}  // namespace tandem::demos
