// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "body.h"

#include <pybind11/operators.h>
#include <pybind11/stl.h>

#include <string>

#include "bind.h"
#include "shown.h"
#include "tandem/pbd/validate.h"

namespace tandem::python {
namespace {

pbd::World& world(const Body& body) { return body.core->scene().world(); }

const char* type_name(const Body& body) {
  constexpr const char* kNames[] = {"static", "kinematic", "dynamic"};
  return kNames[static_cast<int>(world(body).props(body.id).type)];
}

void set_pose(const Body& body, const Pose& pose) { Access(*body.core)->set_pose(body.id, pose); }

void set_twist(const Body& body, const pbd::Twist& twist) {
  Access(*body.core)->world().set_twist(body.id, twist);
}

void move_to(const Body& body, const py::object& position, const py::object& orientation) {
  Pose target{vec3(position, "position"), quat(orientation, "orientation")};
  // The world stores centres of mass.
  const Pose shape = body.core->scene().pose(body.id);
  const Vec3 centre = world(body).pose(body.id).position;
  if (centre != shape.position) target.position = target.to_world(shape.to_local(centre));
  world(body).set_kinematic_target(body.id, target);
}

void bind_motion(py::class_<Body>& c) {
  c.def_property(
      "position", [](const Body& b) { return array_of(b.core->scene().pose(b.id).position); },
      [](const Body& b, const py::object& value) {
        set_pose(b, {vec3(value, "position"), b.core->scene().pose(b.id).orientation});
      },
      "m, of the shape's frame (three numbers, a copy)");
  c.def_property(
      "orientation", [](const Body& b) { return array_of(b.core->scene().pose(b.id).orientation); },
      [](const Body& b, const py::object& value) {
        set_pose(b, {b.core->scene().pose(b.id).position, quat(value, "orientation")});
      },
      "unit quaternion x, y, z, w (a copy)");
  c.def_property(
      "velocity", [](const Body& b) { return array_of(world(b).twist(b.id).linear); },
      [](const Body& b, const py::object& value) {
        set_twist(b, {vec3(value, "velocity"), world(b).twist(b.id).angular});
      },
      "m/s, of the centre of mass (a copy)");
  c.def_property(
      "angular_velocity", [](const Body& b) { return array_of(world(b).twist(b.id).angular); },
      [](const Body& b, const py::object& value) {
        set_twist(b, {world(b).twist(b.id).linear, vec3(value, "angular_velocity")});
      },
      "rad/s, world (a copy)");
  c.def("move_to", &move_to, py::arg("position"),
        py::arg("orientation") = py::make_tuple(0.0, 0.0, 0.0, 1.0),
        "Where a kinematic body (its shape's frame) is to be after the next step.");
}

void bind_forces(py::class_<Body>& c) {
  c.def(
      "apply_force",
      [](const Body& b, const py::object& force, const py::object& point) {
        const Vec3 f = vec3(force, "force");
        if (point.is_none()) return world(b).apply_force(b.id, f);
        // The lever is about the body's present position.
        Access(*b.core)->world().apply_force(b.id, f, vec3(point, "point"));
      },
      py::arg("force"), py::arg("point") = py::none(),
      "Add a force (N) to the next step, at a point of the world (m) or the centre of mass.");
  c.def(
      "apply_torque",
      [](const Body& b, const py::object& torque) {
        world(b).apply_torque(b.id, vec3(torque, "torque"));
      },
      py::arg("torque"), "Add a torque (N m, world) to the next step.");
  c.def(
      "apply_impulse",
      [](const Body& b, const py::object& impulse, const py::object& point) {
        const Vec3 p = vec3(impulse, "impulse");
        Access scene(*b.core);
        if (point.is_none()) return scene->world().apply_impulse(b.id, p);
        scene->world().apply_impulse(b.id, p, vec3(point, "point"));
      },
      py::arg("impulse"), py::arg("point") = py::none(),
      "Change the velocity at once, by N s at a point of the world (m) or the centre of mass.");
  c.def(
      "apply_angular_impulse",
      [](const Body& b, const py::object& impulse) {
        Access(*b.core)->world().apply_angular_impulse(b.id, vec3(impulse, "impulse"));
      },
      py::arg("impulse"), "Change the angular velocity at once, by N m s.");
}

}  // namespace

BodyId id_in(const Core& core, const std::optional<Body>& body, const char* field) {
  if (!body) return {};
  if (body->core.get() != &core) {
    pbd::detail::refuse(field, "a body of this scene", "one of another scene");
  }
  return body->id;
}

void bind_bodies(py::module_& m) {
  py::class_<Body> c(
      m, "Body", R"(A body of a scene, made by Scene.add(). Two that name the same body are equal.

>>> import tandem
>>> scene = tandem.Scene(gravity=(0, 0, 0))
>>> ball = scene.add(tandem.Sphere(0.1), mass=2.0)
>>> ball.apply_impulse((4.0, 0.0, 0.0))
>>> ball.velocity
array([2., 0., 0.])
>>> scene.remove(ball)
>>> ball.alive
False
)");
  c.def(py::self == py::self);
  c.def("__hash__", [](const Body& b) {
    return py::hash(py::make_tuple(reinterpret_cast<std::uintptr_t>(b.core.get()), b.id.index,
                                   b.id.generation));
  });
  c.def("__repr__",
        [](const Body& b) { return "<tandem.Body " + std::to_string(b.id.index) + ">"; });
  c.def_property_readonly(
      "index", [](const Body& b) { return b.id.index; }, "its row in Scene.state");
  c.def_property_readonly(
      "alive", [](const Body& b) { return world(b).contains(b.id); }, "not removed yet");
  c.def_property_readonly("type", &type_name, "'static', 'kinematic' or 'dynamic'");
  c.def_property_readonly(
      "mass", [](const Body& b) { return world(b).props(b.id).mass; }, "kg; 0 unless dynamic");
  c.def_property_readonly("awake", [](const Body& b) { return world(b).awake(b.id); });
  c.def_property_readonly(
      "in_contact", [](const Body& b) { return world(b).in_contact(b.id); }, "in the last step");
  c.def_property_readonly(
      "shapes",
      [](const Body& b) {
        py::list shapes;
        world(b).props(b.id);  // refuses removed bodies
        for (const py::handle part : parts_of(b.core->scene(), {&b.id.index, 1})) {
          const auto fields = py::reinterpret_borrow<py::tuple>(part);
          shapes.append(py::make_tuple(fields[1], fields[2], fields[3]));
        }
        return shapes;
      },
      R"(its shapes, each with position (m) and orientation (x, y, z, w) in the body's shape frame

>>> import tandem
>>> scene = tandem.Scene()
>>> ball = scene.add(tandem.Sphere(0.1), position=(0, 0, 1))
>>> [(shape, position, orientation)] = ball.shapes
>>> shape.radius, position
(0.1, array([0., 0., 0.]))
)");
  bind_motion(c);
  bind_forces(c);
}

}  // namespace tandem::python
