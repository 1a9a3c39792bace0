// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <pybind11/stl.h>

#include "bind.h"
#include "body.h"

namespace tandem::python {
namespace {

using Pair = std::pair<Body, Body>;

struct Impact {
  Pair pair;
  Vec3 point;
  Vec3 normal;
  double speed = 0.0;
  double impulse = 0.0;
};

struct Contacts {
  std::vector<Pair> begun, ended, touching, sensor_begun, sensor_ended, in_sensors;
  std::vector<Impact> hits;
};

Pair pair_of(Core& core, BodyId a, BodyId b) {
  return {{core.shared_from_this(), a}, {core.shared_from_this(), b}};
}

template <class Pairs>
std::vector<Pair> pairs_of(Core& core, const Pairs& pairs) {
  std::vector<Pair> result;
  for (const auto& pair : pairs) {
    if constexpr (requires { pair.sensor_body; }) {
      result.push_back(pair_of(core, pair.sensor_body, pair.visitor_body));
    } else {
      result.push_back(pair_of(core, pair.body_a, pair.body_b));
    }
  }
  return result;
}

Contacts contacts(Core& core) {
  const collision::ContactEvents& events = Access(core)->events();
  Contacts result{.begun = pairs_of(core, events.begun()),
                  .ended = pairs_of(core, events.ended()),
                  .touching = pairs_of(core, events.touching()),
                  .sensor_begun = pairs_of(core, events.sensor_begun()),
                  .sensor_ended = pairs_of(core, events.sensor_ended()),
                  .in_sensors = pairs_of(core, events.in_sensors()),
                  .hits = {}};
  for (const collision::ContactHit& hit : events.hits()) {
    result.hits.push_back({pair_of(core, hit.pair.body_a, hit.pair.body_b), hit.point, hit.normal,
                           hit.speed, hit.impulse});
  }
  return result;
}

}  // namespace

void bind_contacts(py::module_& m, SceneClass& scene) {
  py::class_<Impact>(m, "Impact", "Two bodies that ran into each other.")
      .def_property_readonly("a", [](const Impact& i) { return i.pair.first; })
      .def_property_readonly("b", [](const Impact& i) { return i.pair.second; })
      .def_property_readonly(
          "point", [](const Impact& i) { return array_of(i.point); }, "m, world")
      .def_property_readonly(
          "normal", [](const Impact& i) { return array_of(i.normal); }, "unit, from a to b")
      .def_readonly("speed", &Impact::speed, "m/s, > 0")
      .def_readonly("impulse", &Impact::impulse, "N s");
  py::class_<Contacts>(m, "Contacts",
                       "Contacts: lists of pairs of bodies, one for each pair of shapes.")
      .def_readonly("begun", &Contacts::begun)
      .def_readonly("ended", &Contacts::ended, "Bodies that were removed end theirs.")
      .def_readonly("touching", &Contacts::touching)
      .def_readonly("hits", &Contacts::hits, "faster than the scene's hit_speed")
      .def_readonly("sensor_begun", &Contacts::sensor_begun, "(sensor, visitor)")
      .def_readonly("sensor_ended", &Contacts::sensor_ended)
      .def_readonly("in_sensors", &Contacts::in_sensors);
  scene.def("contacts", &contacts,
            R"(What began, ended and hit in the last step (the last one of several).

The first call has all that touches begin; a scene that is never asked does not look.

>>> import tandem
>>> scene = tandem.Scene()
>>> floor = scene.add(tandem.HalfSpace(), type="static")
>>> ball = scene.add(tandem.Sphere(0.1), position=(0, 0, 0.12), velocity=(0, 0, -3))
>>> before = scene.contacts()
>>> report = scene.step(1 / 60)
>>> [(hit.a == floor, hit.b == ball, hit.speed > 3) for hit in scene.contacts().hits]
[(True, True, True)]
)");
}

}  // namespace tandem::python
