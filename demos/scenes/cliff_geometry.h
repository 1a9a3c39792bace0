// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "tandem/pbd/types.h"

// The cliff as plain data, for the demo and for the benchmarks, which give it to other engines as
// well. It knows no engine.
namespace tandem::demos {

inline constexpr double kCliffHalf = 12.0;  ///< m: the ground reaches that far from the origin
inline constexpr std::uint32_t kCliffCells = 64;  ///< squares along each side, two triangles each
inline constexpr double kCliffBallRadius = 0.15;  ///< m

/// Height (m) of the ground, as the formula has it: a plateau at 6 m, a slope, a plain; all wavy.
double cliff_height(double x, double y);
/// Height (m) of the triangles above (x, y) within kCliffHalf.
double cliff_surface(double x, double y);

struct CliffMesh {
  std::vector<pbd::Vec3> vertices;  ///< m
  std::vector<std::array<std::uint32_t, 3>> triangles;
};
CliffMesh cliff_mesh();

/// m: the middles of ten layers of ten by ten balls above the edge, each a little out of its place.
/// @param uniform  draws from [0, 1), twice for each ball
std::vector<pbd::Vec3> cliff_balls(const std::function<double()>& uniform);

}  // namespace tandem::demos
