// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "shapes.h"

#include "exact.h"
#include "reader.h"

namespace tandem::scene_files {
namespace {

using collision::Shape;
using Triangle = collision::TriangleMesh::Triangle;

template <class Round>
Round read_round(Reader& io) {
  Round shape;
  shape.radius = io.at().at("radius").number();
  shape.half_height = io.at().at("halfHeight").number();
  io.has("radius");
  io.has("halfHeight");
  return shape;
}

template <class T>
T required(Reader& io, const char* key) {
  T value{};
  io.at().at(key);  // refuses a missing key
  io(key, value);
  return value;
}

collision::Mesh read_mesh(Reader& io) {
  io.has("vertices");
  io.has("triangles");
  const Place corners = io.at().at("vertices");
  corners.count(&SceneLimits::points, corners.size());
  const std::vector<Vec3> vertices = read_points(corners);
  const Place list = io.at().at("triangles");
  list.count(&SceneLimits::triangles, list.size());
  std::vector<Triangle> triangles(list.size());
  for (std::size_t i = 0; i < triangles.size(); ++i) read(list.at(i), triangles[i]);
  return collision::TriangleMesh::make(vertices, triangles);
}

collision::Field read_field(Reader& io) {
  const auto columns = required<std::uint32_t>(io, "columns");
  const auto rows = required<std::uint32_t>(io, "rows");
  io.has("spacing");
  io.has("heights");
  const Place spacing = io.at().at("spacing");
  const auto cell = read_numbers<2>(spacing);
  const Place list = io.at().at("heights");
  list.count(&SceneLimits::points, list.size());
  std::vector<double> heights(list.size());
  for (std::size_t i = 0; i < heights.size(); ++i) heights[i] = list.at(i).number();
  return collision::HeightField::make(columns, rows, cell.x(), cell.y(), heights);
}

Shape read_kind(Reader& io, const std::string& type) {
  if (type == "box") return Box(required<Vec3>(io, "halfExtents"));
  if (type == "sphere") return Sphere{required<double>(io, "radius")};
  if (type == "capsule") return read_round<Capsule>(io);
  if (type == "cylinder") return read_round<Cylinder>(io);
  if (type == "cone") return read_round<Cone>(io);
  if (type == "halfSpace") {
    HalfSpace plane;
    io("normal", plane.normal);
    io("offset", plane.offset);
    return plane;
  }
  if (type == "mesh") return read_mesh(io);
  if (type == "heightField") return read_field(io);
  if (type != "hull") {
    io.at().at("type").refuse(
        "one of box, sphere, capsule, cylinder, cone, halfSpace, hull, mesh, heightField");
  }
  io.has("points");
  double tolerance = collision::ConvexHull::kTolerance;
  io("tolerance", tolerance);
  const Place points = io.at().at("points");
  points.count(&SceneLimits::hull_points, points.size());
  return collision::ConvexHull::make(read_points(points), tolerance);
}

json numbers(std::span<const Vec3> points) {
  json list = json::array();
  for (const Vec3& p : points) list.push_back({p.x(), p.y(), p.z()});
  return list;
}

json round_json(const char* type, const auto& shape) {
  return {{"type", type}, {"radius", shape.radius}, {"halfHeight", shape.half_height}};
}

struct ShapeWriter {
  json operator()(const Sphere& s) const { return {{"type", "sphere"}, {"radius", s.radius}}; }
  json operator()(const Box& s) const {
    return {{"type", "box"},
            {"halfExtents", {s.half_extents.x(), s.half_extents.y(), s.half_extents.z()}}};
  }
  json operator()(const Capsule& s) const { return round_json("capsule", s); }
  json operator()(const Cylinder& s) const { return round_json("cylinder", s); }
  json operator()(const Cone& s) const { return round_json("cone", s); }
  json operator()(const HalfSpace& s) const {
    const Vec3 n = before_normalized(s.normal);
    return {{"type", "halfSpace"}, {"normal", {n.x(), n.y(), n.z()}}, {"offset", s.offset}};
  }
  json operator()(const collision::Mesh& mesh) const {
    json triangles = json::array();
    for (const Triangle& t : mesh->triangles()) triangles.push_back(t);
    return {{"type", "mesh"},
            {"vertices", numbers(mesh->vertices())},
            {"triangles", std::move(triangles)}};
  }
  json operator()(const collision::Hull& hull) const {
    json shape{{"type", "hull"}, {"points", numbers(hull->points())}};
    if (hull->tolerance() != collision::ConvexHull::kTolerance) {
      shape["tolerance"] = hull->tolerance();
    }
    return shape;
  }
  json operator()(const collision::Field& field) const {
    json heights = json::array();
    for (std::uint32_t v = 0; v < field->vertex_count(); ++v) {
      heights.push_back(field->vertex(v).z());
    }
    return {{"type", "heightField"},
            {"columns", field->columns()},
            {"rows", field->rows()},
            {"spacing", {field->spacing_x(), field->spacing_y()}},
            {"heights", std::move(heights)}};
  }
};

}  // namespace

std::vector<Vec3> read_points(const Place& at) {
  std::vector<Vec3> points(at.size());
  for (std::size_t i = 0; i < points.size(); ++i) read(at.at(i), points[i]);
  return points;
}

void read_value(const Place& at, Shape& shape) {
  Reader io(at);
  io.has("type");
  const std::string type = at.at("type").text();
  at.guard([&] {
    shape = read_kind(io, type);
    std::string error;
    if (!collision::validate(shape, &error)) throw std::invalid_argument(error);
  });
  io.finish();
}

json write_shape(const Shape& shape) { return std::visit(ShapeWriter{}, shape); }

}  // namespace tandem::scene_files
