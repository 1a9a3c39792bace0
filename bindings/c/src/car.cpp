// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/car.h"

#include <array>

#include "parts.h"

using namespace tandem;
using namespace tandem::c;

struct tandem_car {
  tandem_world& world;
  Car car;

  std::array<pbd::BodyId, 5> bodies() const {
    const auto& wheels = car.wheels();
    return {car.chassis(), wheels[0], wheels[1], wheels[2], wheels[3]};
  }
};

void tandem_car_def_init(tandem_car_def* def) {
  if (def == nullptr) return;
  const CarDef defaults;
  *def = {.pose = to_c(defaults.pose),
          .half_extents = to_c(defaults.half_extents),
          .mass = defaults.mass,
          .wheelbase = defaults.wheelbase,
          .track = defaults.track,
          .axle_height = defaults.axle_height,
          .wheel_radius = defaults.wheel_radius,
          .wheel_width = defaults.wheel_width,
          .wheel_mass = defaults.wheel_mass,
          .stiffness = defaults.stiffness,
          .damping = defaults.damping,
          .travel = defaults.travel,
          .friction = defaults.friction,
          .drive_torque = defaults.drive_torque,
          .brake_torque = defaults.brake_torque,
          .top_speed = defaults.top_speed,
          .max_steer = defaults.max_steer,
          .filter = to_c(defaults.filter)};
}

tandem_car* tandem_car_create(tandem_world* world, const tandem_car_def* def, tandem_error* error) {
  return made_by(error, [&] {
    tandem_world& w = required(world, "world");
    const tandem_car_def& d = required(def, "def");
    return new tandem_car{.world = w,
                          .car = Car(*w.scene, {.pose = from_c(d.pose),
                                                .half_extents = from_c(d.half_extents),
                                                .mass = d.mass,
                                                .wheelbase = d.wheelbase,
                                                .track = d.track,
                                                .axle_height = d.axle_height,
                                                .wheel_radius = d.wheel_radius,
                                                .wheel_width = d.wheel_width,
                                                .wheel_mass = d.wheel_mass,
                                                .stiffness = d.stiffness,
                                                .damping = d.damping,
                                                .travel = d.travel,
                                                .friction = d.friction,
                                                .drive_torque = d.drive_torque,
                                                .brake_torque = d.brake_torque,
                                                .top_speed = d.top_speed,
                                                .max_steer = d.max_steer,
                                                .filter = from_c(d.filter)})};
  });
}

void tandem_car_destroy(tandem_car* car) {
  if (car == nullptr) return;
  remove_all(car->world, car->bodies());
  delete car;
}

tandem_result tandem_car_drive(tandem_car* car, double throttle, double steer, double brake,
                               tandem_error* error) {
  return guarded(error, [&] {
    tandem_car& c = required(car, "car");
    require_all(c.world, c.bodies(), "car");
    c.car.drive({.throttle = throttle, .steer = steer, .brake = brake});
  });
}

double tandem_car_speed(const tandem_car* car) {
  const bool there = car != nullptr && car->world.world.contains(car->car.chassis());
  return there ? car->car.speed() : 0.0;
}

size_t tandem_car_bodies(const tandem_car* car, tandem_body* bodies, size_t capacity) {
  return car != nullptr ? copied(car->bodies(), bodies, capacity) : 0;
}
