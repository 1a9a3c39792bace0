// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/car.h"

#include <array>

#include "bind.h"
#include "joint.h"
#include "parts.h"

namespace tandem::python {
namespace {

struct CarPart {
  CorePtr core;
  tandem::Car car;

  std::array<BodyId, 5> ids() const {
    const auto& wheels = car.wheels();
    return {car.chassis(), wheels[0], wheels[1], wheels[2], wheels[3]};
  }
};

CarDef car_def(const py::kwargs& given) {
  require_known(
      given, "Car",
      {"position",    "orientation",  "half_extents", "mass",         "wheelbase", "track",
       "axle_height", "wheel_radius", "wheel_width",  "wheel_mass",   "stiffness", "damping",
       "travel",      "friction",     "drive_torque", "brake_torque", "top_speed", "max_steer",
       "category",    "mask",         "group"});
  CarDef def;
  take(given, "position", def.pose.position);
  take(given, "orientation", def.pose.orientation);
  take(given, "half_extents", def.half_extents);
  take(given, "mass", def.mass);
  take(given, "wheelbase", def.wheelbase);
  take(given, "track", def.track);
  take(given, "axle_height", def.axle_height);
  take(given, "wheel_radius", def.wheel_radius);
  take(given, "wheel_width", def.wheel_width);
  take(given, "wheel_mass", def.wheel_mass);
  take(given, "stiffness", def.stiffness);
  take(given, "damping", def.damping);
  take(given, "travel", def.travel);
  take(given, "friction", def.friction);
  take(given, "drive_torque", def.drive_torque);
  take(given, "brake_torque", def.brake_torque);
  take(given, "top_speed", def.top_speed);
  take(given, "max_steer", def.max_steer);
  take_filter(given, def.filter);
  return def;
}

std::unique_ptr<CarPart> make_car(Core& core, const py::kwargs& given) {
  const CarDef def = car_def(given);
  Access scene(core);
  core.require_room_for(5);
  return std::unique_ptr<CarPart>(new CarPart{core.shared_from_this(), tandem::Car(*scene, def)});
}

void drive(CarPart& p, double throttle, double steer, double brake) {
  const Access scene(*p.core);
  require_there(*p.core, p.ids(), "Car.drive: car");
  p.car.drive({.throttle = throttle, .steer = steer, .brake = brake});
}

double speed(const CarPart& p) {
  const Access scene(*p.core);
  require_there(*p.core, p.ids(), "Car.speed: car");
  return p.car.speed();
}

std::vector<Joint> wheel_joints(const CarPart& p) {
  std::vector<Joint> result;
  for (const pbd::JointId id : p.car.joints()) result.push_back({p.core, id});
  return result;
}

}  // namespace

void bind_cars(py::module_& m) {
  py::class_<CarPart> c(m, "Car",
                        R"(A chassis on four wheels with springs, all driven, the front two steered.

Keywords, all optional: position, orientation (of the chassis: x forward, y left, z up), half_extents (m,
of the chassis), mass (kg, without wheels), wheelbase, track, axle_height (m), wheel_radius, wheel_width
(m), wheel_mass (kg), stiffness (N/m) and damping (N s/m) of a wheel's spring, travel (m), friction (of
tyres), drive_torque, brake_torque (N m, of all wheels), top_speed (m/s), max_steer (rad), category, mask,
group. As in CarDef.

>>> import tandem
>>> scene = tandem.Scene()
>>> ground = scene.add(tandem.HalfSpace(), type="static")
>>> car = tandem.Car(scene, position=(0, 0, 0.8))
>>> car.drive(throttle=0.5)
>>> report = scene.step(1 / 60, steps=180)
>>> bool(car.speed > 3), bool(car.chassis.position[0] > 3)
(True, True)
)");
  c.def(py::init(&make_car), py::arg("scene"));
  c.def("drive", &drive, py::kw_only(), py::arg("throttle") = 0.0, py::arg("steer") = 0.0,
        py::arg("brake") = 0.0,
        "Until it is called again: throttle from -1 (back) to 1; steer in rad, to the left; brake "
        "from "
        "0 to 1, above 0 nothing drives.");
  c.def_property_readonly("speed", &speed, "m/s, forward");
  c.def_property_readonly("chassis", [](const CarPart& p) {
    return Body{p.core, p.car.chassis()};
  });
  c.def_property_readonly(
      "wheels", [](const CarPart& p) { return bodies_of(p.core, p.car.wheels()); },
      "front left, front right, rear left, rear right");
  c.def_property_readonly("joints", &wheel_joints, "of the wheels, in their order");
  bind_life(c);
}

}  // namespace tandem::python
