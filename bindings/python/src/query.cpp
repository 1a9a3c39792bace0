// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <pybind11/stl.h>

#include <algorithm>

#include "bind.h"
#include "body.h"
#include "shape.h"

namespace tandem::python {
namespace {

/// A hit of any query.
struct Hit {
  Body body;
  Vec3 point;
  Vec3 normal;
  double distance = 0.0;
  std::optional<std::uint32_t> triangle;
};

std::optional<std::uint32_t> triangle_of(std::uint32_t index) {
  if (index == collision::TriangleMesh::kNone) return {};
  return index;
}

collision::QueryFilter filter_of(const Core& core, std::uint32_t mask,
                                 const std::optional<Body>& ignore) {
  collision::QueryFilter filter;
  filter.filter.mask = mask;
  filter.ignore_body = id_in(core, ignore, "ignore");
  return filter;
}

collision::Ray ray_of(const py::object& origin, const py::object& direction, double max_distance) {
  return {vec3(origin, "origin"), vec3(direction, "direction"), max_distance};
}

Hit hit_of(Core& core, const collision::RayHit& hit) {
  return {{core.shared_from_this(), hit.body},
          hit.point,
          hit.normal,
          hit.distance,
          triangle_of(hit.triangle)};
}

using Ignore = std::optional<Body>;

std::optional<Hit> ray_cast(Core& core, const py::object& origin, const py::object& direction,
                            double max_distance, std::uint32_t mask, const Ignore& ignore) {
  const auto hit = Access(core)->query().ray_cast(ray_of(origin, direction, max_distance),
                                                  filter_of(core, mask, ignore));
  if (!hit) return {};
  return hit_of(core, *hit);
}

std::vector<Hit> ray_cast_all(Core& core, const py::object& origin, const py::object& direction,
                              double max_distance, std::uint32_t mask, const Ignore& ignore) {
  std::vector<collision::RayHit> found;
  Access(core)->query().ray_cast_all(ray_of(origin, direction, max_distance), found,
                                     filter_of(core, mask, ignore));
  std::vector<Hit> hits;
  for (const auto& hit : found) hits.push_back(hit_of(core, hit));
  return hits;
}

std::optional<Hit> shape_cast(Core& core, const ShapeValue& shape, const py::object& position,
                              const py::object& displacement, const py::object& orientation,
                              std::uint32_t mask, const Ignore& ignore) {
  const Vec3 way = vec3(displacement, "displacement");
  const auto hit = Access(core)->query().shape_cast(
      shape.shape, {vec3(position, "position"), quat(orientation, "orientation")}, way,
      filter_of(core, mask, ignore));
  if (!hit) return {};
  return Hit{{core.shared_from_this(), hit->body},
             hit->point,
             hit->normal,
             hit->fraction * way.norm(),
             triangle_of(hit->triangle)};
}

std::vector<Body> overlap(Core& core, const ShapeValue& shape, const py::object& position,
                          const py::object& orientation, std::uint32_t mask, const Ignore& ignore) {
  std::vector<collision::ColliderId> found;
  Access scene(core);
  scene->query().overlap(shape.shape,
                         {vec3(position, "position"), quat(orientation, "orientation")}, found,
                         filter_of(core, mask, ignore));
  std::vector<BodyId> ids;
  for (const auto collider : found) ids.push_back(scene->shapes().collider(collider).body);
  std::sort(ids.begin(), ids.end());
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());  // compounds have several colliders
  std::vector<Body> bodies;
  for (const BodyId id : ids) bodies.push_back({core.shared_from_this(), id});
  return bodies;
}

std::optional<Hit> closest(Core& core, const py::object& point, double max_distance,
                           std::uint32_t mask, const Ignore& ignore) {
  const auto hit = Access(core)->query().closest(vec3(point, "point"), max_distance,
                                                 filter_of(core, mask, ignore));
  if (!hit) return {};
  return Hit{{core.shared_from_this(), hit->body},
             hit->on_collider,
             hit->normal,
             hit->distance,
             triangle_of(hit->triangle)};
}

}  // namespace

void bind_queries(py::module_& m, SceneClass& scene) {
  py::class_<Hit>(m, "Hit", "A hit of a query.")
      .def_readonly("body", &Hit::body)
      .def_property_readonly(
          "point", [](const Hit& h) { return array_of(h.point); }, "m, world, on the body")
      .def_property_readonly(
          "normal", [](const Hit& h) { return array_of(h.normal); }, "unit, out of the body")
      .def_readonly("distance", &Hit::distance,
                    "m, along the ray or the way; for closest() negative inside")
      .def_readonly("triangle", &Hit::triangle, "of a mesh or height field, else None");

  const py::object turned = py::make_tuple(0.0, 0.0, 0.0, 1.0);
  const auto query = [&](const char* name, auto function, const char* doc, const auto&... more) {
    scene.def(name, function, more..., py::kw_only(), py::arg("mask") = ~std::uint32_t{0},
              py::arg("ignore") = py::none(), doc);
  };
  query("ray_cast", &ray_cast, R"(The first hit of a ray, or None. direction may have any length.

mask: which categories it meets; ignore: a body that is left out. So in the other queries.

>>> import tandem
>>> scene = tandem.Scene()
>>> ball = scene.add(tandem.Sphere(1.0), position=(5, 0, 0))
>>> hit = scene.ray_cast((0, 0, 0), (1, 0, 0))
>>> hit.body == ball, hit.distance
(True, 4.0)
)",
        py::arg("origin"), py::arg("direction"), py::arg("max_distance") = 1000.0);
  query("ray_cast_all", &ray_cast_all, "The first hit of each shape, by distance.",
        py::arg("origin"), py::arg("direction"), py::arg("max_distance") = 1000.0);
  query("shape_cast", &shape_cast,
        "The first hit of a convex shape that moves without turning, or None.", py::arg("shape"),
        py::arg("position"), py::arg("displacement"), py::arg("orientation") = turned);
  query("overlap", &overlap, "All bodies that share a point with a convex shape, by row.",
        py::arg("shape"), py::arg("position"), py::arg("orientation") = turned);
  query("closest", &closest, "The nearest place to a point within max_distance (m), or None.",
        py::arg("point"), py::arg("max_distance"));
}

}  // namespace tandem::python
