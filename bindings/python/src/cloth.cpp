// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/cloth.h"

#include <algorithm>

#include "bind.h"
#include "parts.h"

namespace tandem::python {
namespace {

struct ClothPart {
  CorePtr core;
  tandem::Cloth cloth;

  const std::vector<BodyId>& ids() const { return cloth.particles(); }
};

ClothDef cloth_def(const py::kwargs& given) {
  require_known(given, "Cloth",
                {"position", "orientation", "width", "height", "columns", "rows", "density",
                 "radius", "stretching", "shearing", "bending", "damping", "friction",
                 "restitution", "category", "mask", "group"});
  ClothDef def;
  take(given, "position", def.pose.position);
  take(given, "orientation", def.pose.orientation);
  take(given, "width", def.width);
  take(given, "height", def.height);
  take(given, "columns", def.columns);
  take(given, "rows", def.rows);
  take(given, "density", def.density);
  take(given, "radius", def.radius);
  take(given, "stretching", def.stretching);
  take(given, "shearing", def.shearing);
  take(given, "bending", def.bending);
  take(given, "damping", def.damping);
  take_material(given, def.material);
  take_filter(given, def.filter);
  return def;
}

std::unique_ptr<ClothPart> make_cloth(Core& core, const py::kwargs& given) {
  const ClothDef def = cloth_def(given);
  Access scene(core);
  core.require_room_for(static_cast<std::size_t>(std::max(0, def.columns)) *
                        static_cast<std::size_t>(std::max(0, def.rows)));
  return std::unique_ptr<ClothPart>(
      new ClothPart{core.shared_from_this(), tandem::Cloth(*scene, def)});
}

int column_of(const ClothPart& p, int column) {
  return place_of(column, static_cast<std::size_t>(p.cloth.columns()), "Cloth: column");
}

int row_of(const ClothPart& p, int row) {
  return place_of(row, static_cast<std::size_t>(p.cloth.rows()), "Cloth: row");
}

Body particle(const ClothPart& p, int column, int row) {
  return {p.core, p.cloth.particle(column_of(p, column), row_of(p, row))};
}

Attachment attach_cloth(ClothPart& p, int column, int row, const Body& host) {
  const int c = column_of(p, column);
  const int r = row_of(p, row);
  const BodyId body = id_in(*p.core, host, "Cloth.attach: host");
  const Access scene(*p.core);
  require_there(*p.core, p.ids(), "Cloth.attach: cloth");
  return {p.core, p.cloth.attach(c, r, body)};
}

void tether(ClothPart& p) {
  const Access scene(*p.core);
  require_there(*p.core, p.ids(), "Cloth.tether: cloth");
  p.cloth.tether();
}

Body add_handle(ClothPart& p, double u, double v, double reach, double share) {
  const Access scene(*p.core);
  require_there(*p.core, p.ids(), "Cloth.add_handle: cloth");
  p.core->require_room_for(1);
  return {p.core, p.cloth.add_handle(u, v, reach, share)};
}

py::array point(const ClothPart& p, double u, double v) {
  const Access scene(*p.core);
  require_there(*p.core, p.ids(), "Cloth.point: cloth");
  return array_of(p.cloth.point(u, v));
}

py::array grid(const ClothPart& p) {
  const Access scene(*p.core);
  return points_of(*p.core, p.ids()).reshape({p.cloth.rows(), p.cloth.columns(), 3});
}

}  // namespace

void bind_cloth(py::module_& m) {
  py::class_<ClothPart> c(m, "Cloth",
                          R"(A rectangle of cloth of point masses, each a body of the scene.

Keywords, all optional: position, orientation (of its frame: columns along x, rows along y, a corner at the
origin), width, height (m, along x and y), columns, rows (of particles, at least 2), density (kg/m^2),
radius (m: it touches others as balls of this size), stretching (N/m; 0: not at all), shearing (N/m; 0:
freely), bending (N m), damping (1/s), friction, restitution, category, mask, group. As in ClothDef. It
touches nothing between its particles.

>>> import tandem
>>> scene = tandem.Scene()
>>> pole = scene.add(tandem.Box(0.02, 0.02, 1), type="static", position=(0, 0, 1))
>>> flag = tandem.Cloth(scene, position=(0, 0, 2), width=1.5, columns=16, rows=11)
>>> holds = [flag.attach(0, row, pole) for row in range(flag.rows)]
>>> flag.tether()
>>> report = scene.step(1 / 60, steps=30)
>>> flag.points.shape, bool(flag.point(1, 0.5)[2] < 2)
((11, 16, 3), True)
)");
  c.def(py::init(&make_cloth), py::arg("scene"));
  c.def_property_readonly("columns", [](const ClothPart& p) { return p.cloth.columns(); });
  c.def_property_readonly("rows", [](const ClothPart& p) { return p.cloth.rows(); });
  c.def_property_readonly(
      "particles", [](const ClothPart& p) { return bodies_of(p.core, p.ids()); },
      "bodies, row by row");
  c.def_property_readonly("points", &grid,
                          "m, world, rows x columns x 3: where the particles are (a copy)");
  c.def("particle", &particle, py::arg("column"), py::arg("row"),
        "The body there; -1 is the last column or row, also in attach().");
  c.def("point", &point, py::arg("u"), py::arg("v"),
        "Where a point of the cloth is now, m, world; u along columns and v along rows, 0 to 1.");
  c.def("attach", &attach_cloth, py::arg("column"), py::arg("row"), py::arg("host"),
        "Hold a particle where it now is on a body. It touches nothing from then on. Gives an "
        "Attachment.");
  c.def("tether", &tether,
        "Each particle keeps within its distance of the nearest one that is attached by now: what "
        "hangs does not stretch. Once, after attach().");
  c.def("add_handle", &add_handle, py::arg("u"), py::arg("v"), py::arg("reach"), py::arg("share"),
        "Add a body at the mean of the cloth within `reach` (m) of a point, which can be held, "
        "pulled "
        "and shared; share, above 0 and below 1, of the mass there goes to it.");
  bind_life(c);
}

}  // namespace tandem::python
