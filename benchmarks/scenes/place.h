// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include "demos/engine/scene.h"

namespace tandem::bench {

inline Pose place(double x, double y, double z) { return {.position = Vec3(x, y, z)}; }

/// A slab of 100 m; its top is z = 0.
inline void add_ground(Scene& scene) {
  scene.add_static(BoxShape{Vec3(50.0, 50.0, 1.0)}, place(0.0, 0.0, -1.0));
}

inline constexpr double kWaterDensity = 1000.0;  ///< kg/m^3

}  // namespace tandem::bench
