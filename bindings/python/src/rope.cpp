// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/rope.h"

#include <algorithm>

#include "bind.h"
#include "parts.h"

namespace tandem::python {
namespace {

struct RopePart {
  CorePtr core;
  tandem::Rope rope;

  const std::vector<BodyId>& ids() const { return rope.particles(); }
};

RopeDef rope_def(const py::kwargs& given) {
  require_known(given, "Rope",
                {"start", "end", "length", "particles", "mass", "radius", "compliance", "bending",
                 "damping", "friction", "restitution", "category", "mask", "group"});
  RopeDef def;
  take(given, "start", def.from);
  take(given, "end", def.to);
  take(given, "length", def.length);
  take(given, "particles", def.particles);
  take(given, "mass", def.mass);
  take(given, "radius", def.radius);
  take(given, "compliance", def.compliance);
  take(given, "bending", def.bending);
  take(given, "damping", def.damping);
  take_material(given, def.material);
  take_filter(given, def.filter);
  // By their Python names: "from" is a keyword.
  pbd::detail::require_finite(def.from, "Rope", "start");
  pbd::detail::require_finite(def.to, "Rope", "end");
  return def;
}

std::unique_ptr<RopePart> make_rope(Core& core, const py::kwargs& given) {
  const RopeDef def = rope_def(given);
  Access scene(core);
  core.require_room_for(static_cast<std::size_t>(std::max(0, def.particles)));
  return std::unique_ptr<RopePart>(
      new RopePart{core.shared_from_this(), tandem::Rope(*scene, def)});
}

Attachment attach_rope(RopePart& p, int particle, const Body& host) {
  const int place = place_of(particle, p.ids().size(), "Rope.attach: particle");
  const BodyId body = id_in(*p.core, host, "Rope.attach: host");
  const Access scene(*p.core);
  require_there(*p.core, p.ids(), "Rope.attach: rope");
  return {p.core, p.rope.attach(static_cast<std::size_t>(place), body)};
}

/// The scene's block of cloth and ropes that contains it; null if none does.
pbd::ClothBlock* block_of(const Attachment& a) {
  for (const auto& block : a.core->scene().world().blocks()) {
    auto* const cloth = dynamic_cast<pbd::ClothBlock*>(block.get());
    if (cloth != nullptr && cloth->contains(a.id)) return cloth;
  }
  return nullptr;
}

void detach(const Attachment& a) {
  const Access scene(*a.core);
  pbd::ClothBlock* const block = block_of(a);
  if (block == nullptr) {
    pbd::detail::refuse("Attachment.remove: attachment", "one that still holds");
  }
  block->remove(a.id);
}

}  // namespace

void bind_ropes(py::module_& m) {
  py::class_<Attachment>(m, "Attachment",
                         "Attachment of a particle to a body: Rope.attach(), Cloth.attach().")
      .def_property_readonly(
          "alive", [](const Attachment& a) { return block_of(a) != nullptr; }, "it still holds")
      .def("remove", &detach, "Let go: the particle keeps its velocity.");

  py::class_<RopePart> c(m, "Rope", R"(A rope of point masses, each a body of the scene.

Keywords, all optional: start, end (m, world), length (m; longer than their distance it hangs), particles
(at least 2; odd where it hangs), mass (kg, of all of it), radius (m: it touches others as balls of this
size), compliance (1/N: strain for each newton), bending (N m^2), damping (1/s), friction, restitution,
category, mask, group. As in RopeDef. It touches nothing between its particles.

>>> import numpy, tandem
>>> scene = tandem.Scene()
>>> hook = scene.add(tandem.Sphere(0.01), type="static", position=(0, 0, 2))
>>> rope = tandem.Rope(scene, start=(0, 0, 2), end=(1, 0, 2), particles=21)
>>> held = rope.attach(0, hook)
>>> report = scene.step(1 / 60, steps=120)
>>> pieces = numpy.linalg.norm(numpy.diff(rope.points, axis=0), axis=1)
>>> rope.points.shape, round(float(pieces.sum()), 2)
((21, 3), 1.0)
)");
  c.def(py::init(&make_rope), py::arg("scene"));
  c.def_property_readonly(
      "particles", [](const RopePart& p) { return bodies_of(p.core, p.ids()); },
      "bodies, from one end to the other");
  c.def_property_readonly(
      "points",
      [](const RopePart& p) {
        const Access scene(*p.core);
        return points_of(*p.core, p.ids());
      },
      "m, world, n x 3: where the particles are (a copy)");
  c.def(
      "attach", &attach_rope, py::arg("particle"), py::arg("host"),
      "Hold a particle where it now is on a body; -1 is the last one. It touches nothing from then "
      "on. Gives an Attachment.");
  bind_life(c);
}

}  // namespace tandem::python
