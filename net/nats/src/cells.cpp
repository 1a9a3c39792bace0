// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/nats/cells.h"

#include <algorithm>
#include <cmath>

#include "tandem/pbd/validate.h"

namespace tandem::nats {

using pbd::detail::require;
using pbd::detail::require_in;

namespace {

constexpr double kFarthest = 1e7;  // m
constexpr std::int32_t kBranching = 4;

std::int32_t floor_of(double value) { return static_cast<std::int32_t>(std::floor(value)); }

}  // namespace

void CellOptions::validate() const {
  constexpr const char* kKind = "CellOptions";
  require_in(0.1, 1e5, kKind, "edge", edge, "m");
  require_in(1.0, 6.0, kKind, "levels", levels);
  require(near >= 0.0 && near <= 16.0 * edge, kKind, "near", near, "from 0 to 16 edges");
  require(slack >= 0.01 && slack <= std::max(near, edge), kKind, "slack", slack,
          "from 0.01 m to `near` or an edge");
  require(min_near >= 1, kKind, "min_near", static_cast<double>(min_near), "at least 1");
  require(max_near >= min_near && max_near <= 256, kKind, "max_near", static_cast<double>(max_near),
          "from min_near to 256");
  require_in(0.2, 20.0, kKind, "presence_hz", presence_hz, "1/s");
  require_in(2.0, 5.0, kKind, "summary_hz", summary_hz, "1/s");
}

double cell_edge(const CellOptions& options, int level) {
  return options.edge * std::pow(static_cast<double>(kBranching), level);
}

Cell cell_at(const CellOptions& options, const pbd::Vec3& position, int level) {
  const double edge = cell_edge(options, level);
  const auto index = [edge](double value) {
    return floor_of(std::clamp(value, -kFarthest, kFarthest) / edge);
  };
  return {level, index(position.x()), index(position.y())};
}

Cell parent_of(const Cell& cell) {
  const auto up = [](std::int32_t index) {
    return (index >= 0 ? index : index - (kBranching - 1)) / kBranching;
  };
  return {cell.level + 1, up(cell.x), up(cell.y)};
}

double distance_to(const CellOptions& options, const Cell& cell, const pbd::Vec3& position) {
  const double edge = cell_edge(options, cell.level);
  const auto along = [edge](std::int32_t index, double value) {
    return std::max({0.0, index * edge - value, value - (index + 1.0) * edge});
  };
  return std::max(along(cell.x, position.x()), along(cell.y, position.y()));
}

}  // namespace tandem::nats
