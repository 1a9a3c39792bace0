// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <span>
#include <vector>

#include "convert.h"
#include "guard.h"
#include "shape_impl.h"
#include "world_impl.h"

using namespace tandem;
using namespace tandem::c;

namespace {

/// Refuses a negative count, converted to unsigned, before anything is read.
size_t checked_count(size_t count, const char* field) {
  constexpr size_t kMax = size_t{1} << 28;
  if (count >= kMax) {
    pbd::detail::refuse(field, "below 2^28", std::to_string(count));
  }
  return count;
}

std::vector<pbd::Vec3> points_of(const tandem_shape& shape) {
  std::vector<pbd::Vec3> points;
  if (shape.point_count == 0) return points;
  const tandem_vec3* const from = &required(shape.points, "shape.points");
  points.reserve(checked_count(shape.point_count, "shape.point_count"));
  for (size_t i = 0; i < shape.point_count; ++i) points.push_back(from_c(from[i]));
  return points;
}

collision::Mesh mesh_of(const tandem_shape& shape) {
  std::vector<collision::TriangleMesh::Triangle> triangles;
  if (shape.triangle_count > 0) {
    const uint32_t* const from = &required(shape.triangles, "shape.triangles");
    triangles.reserve(checked_count(shape.triangle_count, "shape.triangle_count"));
    for (size_t i = 0; i < shape.triangle_count; ++i) {
      triangles.push_back({from[3 * i], from[3 * i + 1], from[3 * i + 2]});
    }
  }
  return collision::TriangleMesh::make(points_of(shape), triangles);
}

collision::Field heights_of(const tandem_shape& shape) {
  const double* const from = &required(shape.heights, "shape.heights");
  // make() refuses counts out of range; nothing is read for them.
  constexpr uint32_t kMax = 16384;
  const bool readable = shape.columns <= kMax && shape.rows <= kMax;
  const size_t count = readable ? size_t{shape.columns} * shape.rows : 0;
  return collision::HeightField::make(shape.columns, shape.rows, shape.spacing_x, shape.spacing_y,
                                      std::span(from, count));
}

}  // namespace

collision::Shape tandem::c::shape_of(const tandem_shape& shape) {
  switch (shape.kind) {
    case TANDEM_SPHERE:
      return collision::Sphere{shape.radius};
    case TANDEM_BOX:
      return collision::Box{from_c(shape.half_extents)};
    case TANDEM_CAPSULE:
      return collision::Capsule{shape.radius, shape.half_height};
    case TANDEM_CYLINDER:
      return collision::Cylinder{shape.radius, shape.half_height};
    case TANDEM_CONE:
      return collision::Cone{shape.radius, shape.half_height};
    case TANDEM_HALF_SPACE:
      return collision::HalfSpace{from_c(shape.normal), shape.offset};
    case TANDEM_HULL:
      return collision::ConvexHull::make(points_of(shape));
    case TANDEM_MESH:
      return mesh_of(shape);
    case TANDEM_HEIGHTS:
      return heights_of(shape);
  }
  refuse_unlisted("shape.kind", shape.kind, "tandem_shape_kind");
}

void tandem_shape_init(tandem_shape* shape, tandem_shape_kind kind) {
  if (shape == nullptr) return;
  *shape = {};
  shape->kind = kind;
  shape->radius = kind == TANDEM_CAPSULE ? collision::Capsule{}.radius : 0.5;
  shape->half_height = 0.5;
  shape->half_extents = to_c(collision::Box{}.half_extents);
  shape->normal = to_c(collision::HalfSpace{}.normal);
  shape->spacing_x = shape->spacing_y = 1.0;
}

tandem_result tandem_shape_mass(const tandem_shape* shape, double density, tandem_mass* mass,
                                tandem_error* error) {
  return guarded(error, [&] {
    tandem_mass& out = required(mass, "mass");
    const collision::MassProperties found =
        collision::mass_properties(shape_of(required(shape, "shape")), density);
    out.mass = found.mass;
    out.centre_of_mass = to_c(found.com);
    matrix_to_c(found.inertia, out.inertia);
  });
}

void tandem_collider_def_init(tandem_collider_def* def, tandem_shape_kind kind) {
  if (def == nullptr) return;
  const collision::Material material;
  const collision::Filter filter;
  *def = {};
  def->body = TANDEM_NO_BODY;
  tandem_shape_init(&def->shape, kind);
  def->local = kAtOrigin;
  def->friction = material.friction;
  def->restitution = material.restitution;
  def->category = filter.category;
  def->mask = filter.mask;
  def->group = filter.group;
}

tandem_result tandem_collider_add(tandem_world* world, const tandem_collider_def* def,
                                  tandem_collider* collider, tandem_error* error) {
  return guarded(error, [&] {
    tandem_world& w = required(world, "world");
    const tandem_collider_def& d = required(def, "def");
    tandem_collider& out = required(collider, "collider");
    out = to_c(
        w.shapes.add(w.world, {.body = from_c(d.body),
                               .shape = shape_of(d.shape),
                               .local = from_c(d.local),
                               .material = {.friction = d.friction, .restitution = d.restitution},
                               .filter = {.category = d.category, .mask = d.mask, .group = d.group},
                               .sensor = d.sensor != 0}));
  });
}

tandem_result tandem_collider_remove(tandem_world* world, tandem_collider collider,
                                     tandem_error* error) {
  return guarded(error, [&] { required(world, "world").shapes.remove(from_c(collider)); });
}
