// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "joint.h"

#include <pybind11/stl.h>

#include <tuple>
#include <utility>

#include "bind.h"
#include "body.h"
#include "tandem/pbd/validate.h"

namespace tandem::python {
namespace {

using Limits = std::optional<std::pair<double, double>>;

/// Parameters of all joints.
struct Strength {
  double compliance = 0.0;
  double damping = 0.0;
  double break_force = 0.0;
  double break_torque = 0.0;
};

template <class Def>
Def with(Def def, const Strength& s) {
  def.compliance = s.compliance;
  def.damping = s.damping;
  def.break_force = s.break_force;
  def.break_torque = s.break_torque;
  return def;
}

void limit(pbd::JointAxis& axis, const Limits& limits) {
  if (!limits) return;
  axis.freedom = pbd::Freedom::Limited;
  std::tie(axis.lower, axis.upper) = *limits;
}

/// Add the joint that `make` returns for the world and the two bodies.
template <class Make>
Joint add_joint(Core& core, const std::optional<Body>& a, const std::optional<Body>& b,
                Make&& make) {
  const BodyId id_a = id_in(core, a, "joint: a");
  const BodyId id_b = id_in(core, b, "joint: b");
  Access scene(core);
  return {core.shared_from_this(), scene->add_joint(make(scene->world(), id_a, id_b))};
}

/// The free coordinate of a hinge or a slider.
pbd::JointAxis& free_axis(pbd::SixDofJointDef& def) {
  pbd::JointAxis* axis = nullptr;
  int count = 0;
  for (auto* axes : {&def.linear, &def.angular}) {
    for (pbd::JointAxis& candidate : *axes) {
      if (candidate.freedom == pbd::Freedom::Locked) continue;
      axis = &candidate;
      ++count;
    }
  }
  if (count != 1) pbd::detail::refuse("joint", "a hinge or a slider, for a motor");
  return *axis;
}

void set_motor(const Joint& joint, std::optional<double> speed, std::optional<double> target,
               double max_force, double stiffness, double damping) {
  if (speed && target) pbd::detail::refuse("set_motor: target", "None where there is a speed");
  pbd::SixDofJointDef def = joint.block().def(joint.id);
  pbd::JointMotor& motor = free_axis(def).motor;
  motor = {.mode = speed    ? pbd::MotorMode::Velocity
                   : target ? pbd::MotorMode::Position
                            : pbd::MotorMode::Off,
           .target = speed.value_or(target.value_or(0.0)),
           .max_force = max_force,
           .stiffness = stiffness,
           .damping = damping};
  joint.block().set(joint.core->scene().world(), joint.id, def);
}

void bind_handle(py::module_& m) {
  py::class_<Joint>(m, "Joint", R"(A joint of a scene, made by Scene.hinge() and the others.

>>> import tandem
>>> scene = tandem.Scene(gravity=(0, 0, 0))
>>> door = scene.add(tandem.Box(0.4, 0.02, 1.0), position=(0.4, 0, 0))
>>> hinge = scene.hinge(None, door, anchor=(0, 0, 0), axis=(0, 0, 1))
>>> hinge.set_motor(speed=1.0)
>>> report = scene.step(1 / 60, steps=60)
>>> round(hinge.angle, 2)
1.0
)")
      .def_property_readonly(
          "angle", [](const Joint& j) { return j.block().hinge_angle(j.id); },
          "rad, of a hinge, after the last step; counts turns")
      .def_property_readonly(
          "displacement", [](const Joint& j) { return j.block().slider_position(j.id); },
          "m, of a slider, after the last step")
      .def_property_readonly(
          "force", [](const Joint& j) { return array_of(j.state().force); },
          "N, world, on body b, in the last substep")
      .def_property_readonly(
          "torque", [](const Joint& j) { return array_of(j.state().torque); }, "N m, likewise")
      .def_property_readonly(
          "residual", [](const Joint& j) { return j.state().residual; },
          "m or rad, largest violation of a rigid row")
      .def_property_readonly("broken", [](const Joint& j) { return j.state().broken; })
      .def_property(
          "enabled", [](const Joint& j) { return j.block().def(j.id).enabled; },
          [](const Joint& j, bool value) { j.block().set_enabled(j.id, value); })
      .def("set_motor", &set_motor, py::kw_only(), py::arg("speed") = py::none(),
           py::arg("target") = py::none(), py::arg("max_force") = pbd::kUnlimited,
           py::arg("stiffness") = 0.0, py::arg("damping") = 0.0,
           "Drive a hinge or slider at a speed or to a target (rad/s, rad, N m; m/s, m, N); "
           "neither: off. With stiffness or damping it is a spring and damper whose force is at "
           "most max_force.")
      .def(
          "remove", [](const Joint& j) { j.block().remove(j.id); }, "From its scene, at once.");
}

}  // namespace

void bind_joints(py::module_& m, SceneClass& scene) {
  bind_handle(m);
  const auto define = [&](const char* name, auto&& function, const char* doc, const auto&... more) {
    scene.def(name, function, py::arg("a").none(true), py::arg("b").none(true), py::arg("anchor"),
              more..., py::kw_only(), py::arg("compliance") = 0.0, py::arg("damping") = 0.0,
              py::arg("break_force") = 0.0, py::arg("break_torque") = 0.0, doc);
  };
  using MaybeBody = std::optional<Body>;
  define(
      "fixed",
      [](Core& core, const MaybeBody& a, const MaybeBody& b, const py::object& anchor,
         double compliance, double damping, double break_force, double break_torque) {
        return add_joint(core, a, b, [&](const pbd::World& world, BodyId id_a, BodyId id_b) {
          return with(pbd::fixed_joint_at(world, id_a, id_b, vec3(anchor, "anchor")),
                      {compliance, damping, break_force, break_torque});
        });
      },
      "Hold b in a as they are now. None is the world, here and in the other joints.\n\n"
      "anchor: m, world. compliance: m/N. damping: N s/m. break_force: N, 0 = never. break_torque: "
      "N m.");
  define(
      "ball",
      [](Core& core, const MaybeBody& a, const MaybeBody& b, const py::object& anchor,
         const py::object& axis, double cone, double compliance, double damping, double break_force,
         double break_torque) {
        return add_joint(core, a, b, [&](const pbd::World& world, BodyId id_a, BodyId id_b) {
          auto def =
              pbd::ball_joint_at(world, id_a, id_b, vec3(anchor, "anchor"), vec3(axis, "axis"));
          def.cone = cone;
          return with(def, {compliance, damping, break_force, break_torque});
        });
      },
      "Hold a point of b at one of a; cone (rad) is the largest swing of `axis`.",
      py::arg("axis") = py::make_tuple(1.0, 0.0, 0.0), py::arg("cone") = pbd::kUnlimited);
  define(
      "hinge",
      [](Core& core, const MaybeBody& a, const MaybeBody& b, const py::object& anchor,
         const py::object& axis, const Limits& limits, double compliance, double damping,
         double break_force, double break_torque) {
        return add_joint(core, a, b, [&](const pbd::World& world, BodyId id_a, BodyId id_b) {
          auto def =
              pbd::hinge_joint_at(world, id_a, id_b, vec3(anchor, "anchor"), vec3(axis, "axis"));
          limit(def.axis, limits);
          return with(def, {compliance, damping, break_force, break_torque});
        });
      },
      "Let b turn about an axis of a; limits: (lower, upper) in rad from where it is now.",
      py::arg("axis"), py::arg("limits") = py::none());
  define(
      "slider",
      [](Core& core, const MaybeBody& a, const MaybeBody& b, const py::object& anchor,
         const py::object& axis, const Limits& limits, double compliance, double damping,
         double break_force, double break_torque) {
        return add_joint(core, a, b, [&](const pbd::World& world, BodyId id_a, BodyId id_b) {
          auto def =
              pbd::slider_joint_at(world, id_a, id_b, vec3(anchor, "anchor"), vec3(axis, "axis"));
          limit(def.axis, limits);
          return with(def, {compliance, damping, break_force, break_torque});
        });
      },
      "Let b move along an axis of a, without turning; limits: (lower, upper) in m from where it "
      "is now.",
      py::arg("axis"), py::arg("limits") = py::none());
}

}  // namespace tandem::python
