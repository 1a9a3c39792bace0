// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <pybind11/stl.h>

#include <array>
#include <stdexcept>
#include <string>

#include "bind.h"
#include "body.h"
#include "keywords.h"
#include "report.h"
#include "scene_options.h"
#include "shape.h"
#include "tandem/pbd/validate.h"
#include "tandem/pbd/world_copy.h"

namespace tandem::python {
namespace {

/// Result of save().
struct Snapshot {
  pbd::WorldCopy copy;
};

BodyType body_type(const std::string& name) {
  if (name == "static") return BodyType::Static;
  if (name == "kinematic") return BodyType::Kinematic;
  if (name == "dynamic") return BodyType::Dynamic;
  pbd::detail::refuse("type", "'static', 'kinematic' or 'dynamic'", "'" + name + "'");
}

}  // namespace

SceneOptions options_of(const py::kwargs& given, const char* function) {
  require_known(given, function,
                {"gravity", "substeps", "position_iterations", "joint_iterations",
                 "velocity_iterations", "refine", "sleep_after", "threads", "hit_speed"});
  SceneOptions options;
  take(given, "gravity", options.gravity);
  take(given, "substeps", options.solver.substeps);
  take(given, "position_iterations", options.solver.position_iterations);
  take(given, "joint_iterations", options.solver.joint_iterations);
  take(given, "velocity_iterations", options.solver.velocity_iterations);
  take(given, "refine", options.solver.refine);
  take(given, "sleep_after", options.solver.sleep_after);
  take(given, "threads", options.solver.threads);
  take(given, "hit_speed", options.events.hit_speed);
  return options;
}

namespace {

SolidDef solid_of(const py::kwargs& given) {
  require_known(given, "add",
                {"type",
                 "density",
                 "mass",
                 "position",
                 "orientation",
                 "velocity",
                 "angular_velocity",
                 "friction",
                 "restitution",
                 "category",
                 "mask",
                 "group",
                 "sensor",
                 "gravity_scale",
                 "linear_damping",
                 "angular_damping",
                 "lock_linear",
                 "lock_angular",
                 "bullet",
                 "can_sleep",
                 "sleep_speed",
                 "sleep_spin",
                 "stable_id"});
  SolidDef def;
  if (given.contains("type")) def.type = body_type(py::str(given["type"]));
  take(given, "density", def.density);
  take(given, "mass", def.mass);
  take(given, "position", def.pose.position);
  take(given, "orientation", def.pose.orientation);
  take(given, "velocity", def.twist.linear);
  take(given, "angular_velocity", def.twist.angular);
  take(given, "friction", def.material.friction);
  take(given, "restitution", def.material.restitution);
  take(given, "category", def.filter.category);
  take(given, "mask", def.filter.mask);
  take(given, "group", def.filter.group);
  take(given, "sensor", def.sensor);
  take(given, "gravity_scale", def.gravity_scale);
  take(given, "linear_damping", def.linear_damping);
  take(given, "angular_damping", def.angular_damping);
  take(given, "lock_linear", def.locks.linear);
  take(given, "lock_angular", def.locks.angular);
  take(given, "bullet", def.bullet);
  take(given, "can_sleep", def.can_sleep);
  take(given, "sleep_speed", def.sleep_speed);
  take(given, "sleep_spin", def.sleep_spin);
  take(given, "stable_id", def.stable_id);
  return def;
}

Body add_body(Core& core, const py::object& shape, const py::kwargs& given) {
  const SolidDef def = solid_of(given);
  Access scene(core);
  core.require_room_for(1);
  if (py::isinstance<ShapeValue>(shape)) {
    return {core.shared_from_this(), scene->add(shape.cast<const ShapeValue&>().shape, def)};
  }
  std::vector<collision::CompoundPart> parts;
  for (const py::handle part : shape) parts.push_back(part.cast<const PartValue&>().part);
  return {core.shared_from_this(), scene->add(parts, def)};
}

std::vector<Body> bodies(Core& core) {
  const pbd::World& world = core.scene().world();
  std::vector<Body> result;
  for (std::uint32_t slot = 0; slot < world.slot_count(); ++slot) {
    const BodyId id = world.body_at(slot);
    if (id.valid()) result.push_back({core.shared_from_this(), id});
  }
  return result;
}

Report step(Core& core, double dt, int steps) {
  require_steps(dt, steps);
  Access scene(core);
  const Core::Busy busy(core);
  const py::gil_scoped_release released;
  const pbd::StepReport* report = nullptr;
  for (int i = 0; i < steps; ++i) {
    report = &scene->step(dt);
    if (report->status != pbd::StepStatus::Ok) break;
  }
  return Report(*report, scene->world().time());
}

std::unique_ptr<Snapshot> save(Core& core) {
  auto snapshot = std::make_unique<Snapshot>();
  Access scene(core);
  if (!snapshot->copy.assign(scene->world())) {
    throw std::invalid_argument("Scene.save: a part of the scene cannot be copied");
  }
  return snapshot;
}

void restore(Core& core, const Snapshot& snapshot) {
  Access scene(core);
  core.require_room(snapshot.copy.world().slot_count());
  ++core.restores;
  snapshot.copy.restore(scene->world());
}

}  // namespace

SceneClass bind_scene(py::module_& m) {
  bind_report(m);
  py::class_<Snapshot>(m, "Snapshot",
                       "Everything that the next steps of a scene depend on: Scene.save().");

  SceneClass c(m, "Scene", R"(A world with its shapes and its solver.

Units are m, kg, s; z is up. Keywords, all optional: gravity (m/s^2), substeps, position_iterations,
joint_iterations, velocity_iterations, refine, sleep_after (s, 0 = never), threads, hit_speed (m/s).
Wrong values are ValueErrors that name field, value and rule; the scene is then as it was.

>>> import tandem
>>> scene = tandem.Scene()
>>> floor = scene.add(tandem.HalfSpace(), type="static")
>>> cube = scene.add(tandem.Box(0.05, 0.05, 0.05), density=300.0, position=(0, 0, 1))
>>> report = scene.step(1 / 60, steps=60)
>>> round(float(cube.position[2]), 3)
0.05
>>> scene.add(tandem.Sphere(0.1), density=-1.0)
Traceback (most recent call last):
  ...
ValueError: mass_properties: density must be finite and > 0, is -1
)");
  c.def(py::init(
      [](const py::kwargs& given) { return std::make_shared<Core>(options_of(given, "Scene")); }));
  c.def("add", &add_body, py::arg("shape"),
        R"(Add a body: a shape, or a sequence of Part as one body.

Keywords, all optional: type ('dynamic', 'static', 'kinematic'), density (kg/m^3) or mass (kg),
position, orientation (x, y, z, w), velocity, angular_velocity, friction, restitution, category, mask,
group, sensor, gravity_scale, linear_damping, angular_damping (1/s), lock_linear, lock_angular (three
bools), bullet, can_sleep, sleep_speed (m/s), sleep_spin (rad/s), stable_id.

>>> import tandem
>>> scene = tandem.Scene()
>>> scene.add(tandem.Capsule(0.25, 0.5), mass=70.0, lock_angular=(True, True, True)).mass
70.0
)");
  c.def(
      "remove",
      [](Core& core, const Body& body) {
        Access(core)->remove(id_in(core, body, "Scene.remove: body"));
      },
      py::arg("body"),
      "Remove a body with its shapes and joints. Its row is that of a later body.");
  c.def(
      "set_apart",
      [](Core& core, const Body& a, const Body& b, bool apart) {
        Access(core)->set_apart(id_in(core, a, "Scene.set_apart: a"),
                                id_in(core, b, "Scene.set_apart: b"), apart);
      },
      py::arg("a"), py::arg("b"), py::arg("apart") = true,
      "Two bodies pass through each other, or touch again.");
  c.def_property_readonly("bodies", &bodies, "all bodies, by row");
  c.def_property_readonly("state", &Core::state,
                          R"(n x 13 array that is the storage: writing to it moves bodies.

A row is position (m), orientation (x, y, z, w), velocity (m/s) and angular velocity (rad/s) of the
centre of mass; Body.index says which. The scene takes over what was written, as if it had been set on
the body, with its next call (step, ray_cast, save ...): that wakes the body and brings the quaternion to
length 1. A row that may not be (not finite, a quaternion further than 1e-3 from length 1, a static
body that moves) is a ValueError then, and all rows are as before the writing. Rows of removed bodies
are not read. While an array is alive the number of rows cannot change (BufferError). It keeps the
storage alive. During a step in another thread, neither read nor write.

>>> import tandem
>>> scene = tandem.Scene(gravity=(0, 0, 0))
>>> balls = [scene.add(tandem.Sphere(0.1), position=(i, 0, 0)) for i in range(3)]
>>> state = scene.state
>>> state[:, 9] = 1.0
>>> report = scene.step(0.5)
>>> state[:, :3]
array([[0. , 0. , 0.5],
       [1. , 0. , 0.5],
       [2. , 0. , 0.5]])
)");
  c.def("step", &step, py::arg("dt"), py::arg("steps") = 1,
        R"(Make `steps` steps of dt (s), without the GIL.

Ends after a step whose status is not 'ok', and returns the report of the last one made.

>>> import tandem
>>> scene = tandem.Scene()
>>> scene.step(1 / 60, steps=3).status
'ok'
>>> scene.step(-1.0)
Traceback (most recent call last):
  ...
ValueError: dt must be finite and > 0, is -1
)");
  c.def("save", &save, R"(Copy all that the next steps depend on.

>>> import tandem
>>> scene = tandem.Scene()
>>> ball = scene.add(tandem.Sphere(0.1))
>>> before = scene.save()
>>> report = scene.step(0.1)
>>> scene.restore(before)
>>> scene.time
0.0
)");
  c.def("restore", &restore, py::arg("snapshot"),
        "Be as at save(): steps from there have the same bits. Bodies added since are gone; forget "
        "their objects, as later bodies may be taken for them.");
  c.def(
      "hash", [](Core& core) { return Access(core)->world().hash(); },
      "64 bits over all poses and twists: equal bits, equal hash, as World::hash() in C++.");
  c.def(
      "wake_all",
      [](Core& core) {
        pbd::World& world = core.scene().world();
        for (const Body& body : bodies(core)) world.wake(body.id);
      },
      "Let nothing sleep in the next step.");
  c.def_property_readonly(
      "time", [](Core& core) { return core.scene().world().time(); }, "s, sum of all steps");
  c.def_property(
      "gravity", [](Core& core) { return array_of(core.scene().world().gravity()); },
      [](Core& core, const py::object& value) {
        core.scene().world().set_gravity(vec3(value, "gravity"));
      },
      "m/s^2 (a copy)");
  c.def_property_readonly(
      "kinetic_energy", [](Core& core) { return Access(core)->world().kinetic_energy(); }, "J");
  c.def_property_readonly(
      "mechanical_energy", [](Core& core) { return Access(core)->world().mechanical_energy(); },
      "J, kinetic and gravitational, 0 at the origin");
  return c;
}

}  // namespace tandem::python
