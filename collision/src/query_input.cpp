// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "query_input.h"

#include <cmath>
#include <stdexcept>

#include "collider_query.h"
#include "gjk.h"
#include "refuse.h"

namespace tandem::collision {
namespace {

void require_finite(const Vec3& value, const char* field) {
  for (int i = 0; i < 3; ++i) {
    if (!std::isfinite(value[i])) refuse(field, value[i], "finite");
  }
}

}  // namespace

void check_distance(double max_distance) {
  if (!(max_distance >= 0.0) || !std::isfinite(max_distance)) {
    refuse("query: max_distance", max_distance, "finite and >= 0");
  }
}

CheckedRay::CheckedRay(const Ray& ray) : origin(ray.origin), limit(ray.max_distance) {
  require_finite(ray.origin, "Ray.origin");
  require_finite(ray.direction, "Ray.direction");
  const double length = ray.direction.stableNorm();
  if (!(length > 0.0)) refuse("Ray.direction", length, "longer than 0");
  if (!(limit > 0.0) || !std::isfinite(limit)) {
    refuse("Ray.max_distance", limit, "finite and > 0");
  }
  direction = (ray.direction / length).normalized();
}

Displacement::Displacement(const Vec3& value) {
  require_finite(value, "query: displacement");
  length = value.stableNorm();
  if (length > 0.0) direction = (value / length).normalized();
}

Probe::Probe(const Shape& shape, const pbd::Pose& pose) : origin(pose.position) {
  std::string error;
  if (!validate(shape, &error)) throw std::invalid_argument("query: shape: " + error);
  require_finite(pose.position, "query: pose.position");
  const double norm = pose.orientation.norm();
  if (!(std::abs(norm - 1.0) < 1e-3)) {
    refuse("query: pose.orientation", norm, "a quaternion of unit norm (within 1e-3)");
  }
  Collider collider = make_collider({.shape = shape}, {});
  if (!collider.is_convex()) {
    refuse("query: shape", static_cast<double>(shape.index()), "a convex shape");
  }
  collider.position = pose.position;
  collider.rotation = pose.orientation.normalized().toRotationMatrix();
  place(collider.core(origin));
}

Probe::Probe(const Vec3& point) : origin(point) {
  require_finite(point, "query: point");
  place(point_core(Vec3::Zero()));
}

void Probe::place(const ConvexCore& placed) {
  core = placed;
  box = bounds_of(core);
  // Rounding of the sum must not make the box smaller.
  const double slack = 1e-15 * origin.cwiseAbs().maxCoeff();
  box = {box.min + origin, box.max + origin};
  box = box.expanded(slack);
}

}  // namespace tandem::collision
