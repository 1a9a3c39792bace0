// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "query_input.h"

#include <cmath>
#include <stdexcept>

#include "collider_query.h"
#include "gjk.h"
#include "tandem/pbd/validate.h"

namespace tandem::collision {
namespace {

using pbd::detail::refuse;
using pbd::detail::require_finite;

}  // namespace

void check_distance(double max_distance) {
  if (!(max_distance >= 0.0) || !std::isfinite(max_distance)) {
    refuse("query: max_distance", "finite and >= 0", max_distance);
  }
}

CheckedRay::CheckedRay(const Ray& ray) : origin(ray.origin), limit(ray.max_distance) {
  require_finite(ray.origin, "Ray", "origin");
  require_finite(ray.direction, "Ray", "direction");
  const double length = ray.direction.stableNorm();
  if (!(length > 0.0)) refuse("Ray: direction", "longer than 0", length);
  if (!(limit > 0.0) || !std::isfinite(limit)) {
    refuse("Ray: max_distance", "finite and > 0", limit);
  }
  direction = (ray.direction / length).normalized();
}

Displacement::Displacement(const Vec3& value) {
  require_finite(value, "query", "displacement");
  length = value.stableNorm();
  if (length > 0.0) direction = (value / length).normalized();
}

Probe::Probe(const Shape& shape, const pbd::Pose& pose) : origin(pose.position) {
  std::string error;
  if (!validate(shape, &error)) throw std::invalid_argument("query: shape: " + error);
  require_finite(pose.position, "query", "pose.position");
  pbd::detail::require_unit(pose.orientation, "query", "pose.orientation");
  Collider collider = make_collider({.shape = shape}, {});
  if (!collider.is_convex()) {
    refuse("query: shape", "a convex shape");
  }
  collider.position = pose.position;
  collider.rotation = pose.orientation.normalized().toRotationMatrix();
  place(collider.core(origin));
}

Probe::Probe(const Vec3& point) : origin(point) {
  require_finite(point, "query", "point");
  place(point_core(Vec3::Zero()));
}

void Probe::place(const ConvexCore& placed) {
  core = placed;
  box = bounds_of(core);
  // Rounding of the sum must not shrink the box.
  const double slack = 1e-15 * origin.cwiseAbs().maxCoeff();
  box = {box.min + origin, box.max + origin};
  box = box.expanded(slack);
}

}  // namespace tandem::collision
