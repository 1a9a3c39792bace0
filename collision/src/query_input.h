// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Input of scene queries. Everything here throws std::invalid_argument naming field, value and
// rule.
#pragma once

#include "collider.h"
#include "tandem/collision/scene_query.h"

namespace tandem::collision {

void check_distance(double max_distance);

/// A valid ray.
struct CheckedRay {
  Vec3 origin;
  Vec3 direction;  ///< unit
  double limit;    ///< m

  explicit CheckedRay(const Ray& ray);
};

/// Unit direction and length; zero displacement has no direction.
struct Displacement {
  Vec3 direction = Vec3::Zero();
  double length = 0.0;  ///< m

  explicit Displacement(const Vec3& value);
};

/// A convex query shape, placed at the origin of the query.
struct Probe {
  Vec3 origin;
  ConvexCore core;
  Aabb box;  ///< world

  Probe(const Shape& shape, const pbd::Pose& pose);
  explicit Probe(const Vec3& point);

 private:
  void place(const ConvexCore& placed);
};

}  // namespace tandem::collision
