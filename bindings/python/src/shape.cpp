// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "shape.h"

#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>

#include "bind.h"

namespace tandem::python {
namespace {

/// A Python type per kind; the C++ shape has all the data.
template <int kind>
struct Kind : ShapeValue {};
using SphereValue = Kind<0>;
using BoxValue = Kind<1>;
using CapsuleValue = Kind<2>;
using CylinderValue = Kind<3>;
using ConeValue = Kind<4>;
using HalfSpaceValue = Kind<5>;
using HullValue = Kind<6>;
using MeshValue = Kind<7>;
using HeightFieldValue = Kind<8>;

template <class Value>
Value checked(collision::Shape shape) {
  std::string error;
  if (!collision::validate(shape, &error)) throw std::invalid_argument(error);
  Value value;
  value.shape = std::move(shape);
  return value;
}

/// The alternative for this type.
template <class Shape>
const Shape& get(const ShapeValue& value) {
  return std::get<Shape>(value.shape);
}

/// Spheres, capsules and the like: a radius, and half a height if they have one.
template <class Value, class Shape>
void bind_round(py::module_& m, const char* name, const char* doc) {
  py::class_<Value, ShapeValue> bound(m, name, doc);
  bound.def_property_readonly(
      "radius", [](const Value& v) { return get<Shape>(v).radius; }, "m");
  if constexpr (requires(Shape s) { s.half_height; }) {
    bound.def(py::init([](double radius, double half_height) {
                return checked<Value>(Shape{radius, half_height});
              }),
              py::arg("radius"), py::arg("half_height"));
    bound.def_property_readonly(
        "half_height", [](const Value& v) { return get<Shape>(v).half_height; }, "m");
  } else {
    bound.def(py::init([](double radius) { return checked<Value>(Shape{radius}); }),
              py::arg("radius"));
  }
}

MeshValue make_mesh(const py::object& vertices, const py::object& triangles) {
  const std::vector<Vec3> places = points(vertices, "Mesh: vertices");
  std::vector<collision::TriangleMesh::Triangle> corners;
  for (const Vec3& row : points(triangles, "Mesh: triangles")) {
    collision::TriangleMesh::Triangle triangle;
    for (int i = 0; i < 3; ++i) {
      // make() refuses values out of range; the conversion must not see them.
      const bool whole = row[i] >= 0.0 && row[i] < 4294967295.0;
      triangle[static_cast<std::size_t>(i)] =
          whole ? static_cast<std::uint32_t>(row[i]) : collision::TriangleMesh::kNone;
    }
    corners.push_back(triangle);
  }
  return checked<MeshValue>(collision::TriangleMesh::make(places, corners));
}

HeightFieldValue make_field(
    const py::array_t<double, py::array::c_style | py::array::forcecast>& heights, double spacing_x,
    double spacing_y) {
  if (heights.ndim() != 2)
    throw std::invalid_argument("HeightField: heights must be rows x columns");
  const std::span<const double> values(heights.data(), static_cast<std::size_t>(heights.size()));
  return checked<HeightFieldValue>(collision::HeightField::make(
      static_cast<std::uint32_t>(heights.shape(1)), static_cast<std::uint32_t>(heights.shape(0)),
      spacing_x, spacing_y, values));
}

template <class Row>
auto rows_of(std::span<const Row> rows) {
  using Number = std::remove_cvref_t<decltype(rows[0][0])>;
  py::array_t<Number> result({static_cast<py::ssize_t>(rows.size()), py::ssize_t{3}});
  auto to = result.template mutable_unchecked<2>();
  for (py::ssize_t i = 0; i < result.shape(0); ++i) {
    const Row& row = rows[static_cast<std::size_t>(i)];
    to(i, 0) = row[0];
    to(i, 1) = row[1];
    to(i, 2) = row[2];
  }
  return result;
}

py::array_t<double> hull_vertices(const HullValue& value) {
  const collision::ConvexHull& hull = *get<collision::Hull>(value);
  std::vector<Vec3> corners;
  for (const Vec3& arm : hull.arms()) corners.push_back(hull.centre() + arm);
  return rows_of<Vec3>(corners);
}

/// Faces as fans.
py::array_t<std::uint32_t> hull_triangles(const HullValue& value) {
  const collision::ConvexHull& hull = *get<collision::Hull>(value);
  std::vector<collision::TriangleMesh::Triangle> triangles;
  for (const collision::ConvexHull::Face& face : hull.faces()) {
    const auto corners = hull.face_corners(face);
    for (std::size_t i = 2; i < corners.size(); ++i) {
      triangles.push_back({corners[0], corners[i - 1], corners[i]});
    }
  }
  return rows_of<collision::TriangleMesh::Triangle>(triangles);
}

py::array_t<double> field_heights(const HeightFieldValue& value) {
  const collision::HeightField& field = *get<collision::Field>(value);
  py::array_t<double> result(
      {static_cast<py::ssize_t>(field.rows()), static_cast<py::ssize_t>(field.columns())});
  double* to = result.mutable_data();
  for (std::uint32_t v = 0; v < field.vertex_count(); ++v) to[v] = field.vertex(v).z();
  return result;
}

}  // namespace

py::object object_of(const collision::Shape& shape) {
  const auto as = [&]<class Value>(Value value) {
    value.shape = shape;
    return py::cast(std::move(value));
  };
  struct Type {
    decltype(as)& make;
    py::object operator()(const Sphere&) const { return make(SphereValue{}); }
    py::object operator()(const Box&) const { return make(BoxValue{}); }
    py::object operator()(const Capsule&) const { return make(CapsuleValue{}); }
    py::object operator()(const Cylinder&) const { return make(CylinderValue{}); }
    py::object operator()(const Cone&) const { return make(ConeValue{}); }
    py::object operator()(const HalfSpace&) const { return make(HalfSpaceValue{}); }
    py::object operator()(const collision::Hull&) const { return make(HullValue{}); }
    py::object operator()(const collision::Mesh&) const { return make(MeshValue{}); }
    py::object operator()(const collision::Field&) const { return make(HeightFieldValue{}); }
  };
  return std::visit(Type{as}, shape);
}

void bind_shapes(py::module_& m) {
  py::class_<ShapeValue>(m, "Shape",
                         R"(A shape in its own frame: Sphere, Box and the others. Lengths are in m.

>>> import tandem
>>> tandem.Sphere(-1.0)
Traceback (most recent call last):
  ...
ValueError: Sphere.radius must be > 0 and at most 1e6 m, is -1
)");
  bind_round<SphereValue, Sphere>(m, "Sphere", "Ball about the origin.");
  bind_round<CapsuleValue, Capsule>(
      m, "Capsule", "All within `radius` of a segment of half length `half_height` along z.");
  bind_round<CylinderValue, Cylinder>(m, "Cylinder",
                                      "Round about z, from -half_height to half_height.");
  bind_round<ConeValue, Cone>(m, "Cone",
                              "Round about z: base at -half_height, apex at half_height.");
  py::class_<BoxValue, ShapeValue>(m, "Box", "Box about the origin, by halves of its edges.")
      .def(py::init([](double x, double y, double z) {
             return checked<BoxValue>(Box{x, y, z});
           }),
           py::arg("half_x"), py::arg("half_y"), py::arg("half_z"))
      .def_property_readonly(
          "half_extents", [](const BoxValue& v) { return array_of(get<Box>(v).half_extents); },
          "m (three numbers, a copy)");
  py::class_<HalfSpaceValue, ShapeValue>(m, "HalfSpace",
                                         "All behind a plane: x with normal . x <= offset.")
      .def(py::init([](const py::object& normal, double offset) {
             return checked<HalfSpaceValue>(HalfSpace{vec3(normal, "HalfSpace: normal"), offset});
           }),
           py::arg("normal") = py::make_tuple(0.0, 0.0, 1.0), py::arg("offset") = 0.0)
      .def_property_readonly(
          "normal", [](const HalfSpaceValue& v) { return array_of(get<HalfSpace>(v).normal); },
          "unit (a copy)")
      .def_property_readonly(
          "offset", [](const HalfSpaceValue& v) { return get<HalfSpace>(v).offset; }, "m");
  py::class_<HullValue, ShapeValue>(m, "Hull", "Convex hull of n x 3 points, at most 128 corners.")
      .def(py::init([](const py::object& at) {
             return checked<HullValue>(collision::ConvexHull::make(points(at, "Hull: points")));
           }),
           py::arg("points"))
      .def_property_readonly("vertices", &hull_vertices, "m, its corners (n x 3, a copy)")
      .def_property_readonly(
          "triangles", &hull_triangles,
          "indices into vertices, counter-clockwise from outside (n x 3, a copy)");
  py::class_<MeshValue, ShapeValue>(m, "Mesh",
                                    "Triangles: n x 3 vertices, m x 3 indices into them.")
      .def(py::init(&make_mesh), py::arg("vertices"), py::arg("triangles"))
      .def_property_readonly(
          "vertices",
          [](const MeshValue& v) { return rows_of(get<collision::Mesh>(v)->vertices()); },
          "m; equal ones are one (n x 3, a copy)")
      .def_property_readonly(
          "triangles",
          [](const MeshValue& v) { return rows_of(get<collision::Mesh>(v)->triangles()); },
          "indices into vertices (n x 3, a copy)");
  py::class_<HeightFieldValue, ShapeValue>(
      m, "HeightField", "Heights (rows x columns) over a grid; columns run along x, rows along y.")
      .def(py::init(&make_field), py::arg("heights"), py::arg("spacing_x"), py::arg("spacing_y"))
      .def_property_readonly("heights", &field_heights, "m (rows x columns, a copy)")
      .def_property_readonly(
          "spacing_x",
          [](const HeightFieldValue& v) { return get<collision::Field>(v)->spacing_x(); }, "m")
      .def_property_readonly(
          "spacing_y",
          [](const HeightFieldValue& v) { return get<collision::Field>(v)->spacing_y(); }, "m");

  py::class_<PartValue>(m, "Part", R"(One shape of a body that has several.

>>> import tandem
>>> scene = tandem.Scene()
>>> dumbbell = scene.add([tandem.Part(tandem.Sphere(0.1), position=(x, 0, 0)) for x in (-1, 1)])
>>> round(dumbbell.mass, 3)
8.378
)")
      .def(py::init([](const ShapeValue& shape, const py::object& position,
                       const py::object& orientation, double density) {
             return PartValue{
                 {shape.shape,
                  {vec3(position, "Part: position"), quat(orientation, "Part: orientation")},
                  density}};
           }),
           py::arg("shape"), py::kw_only(), py::arg("position") = py::make_tuple(0.0, 0.0, 0.0),
           py::arg("orientation") = py::make_tuple(0.0, 0.0, 0.0, 1.0),
           py::arg("density") = 1000.0);
}

}  // namespace tandem::python
