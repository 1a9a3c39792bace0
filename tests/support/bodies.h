// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <functional>
#include <stdexcept>
#include <string>

#include "support/oracles.h"
#include "tandem/pbd/solver.h"

/// Short forms for building and running small worlds.
namespace tandem::testing {

inline pbd::BodyDef box_def(double mass, const Vec3& half, const Vec3& position,
                            const Quat& orientation = Quat::Identity()) {
  return {.pose = {position, orientation}, .mass = mass, .inertia = box_inertia(mass, half)};
}

inline pbd::BodyDef ball_def(double mass, double radius, const Vec3& position) {
  return {
      .pose = {position, Quat::Identity()}, .mass = mass, .inertia = sphere_inertia(mass, radius)};
}

inline pbd::BodyId add_ground(pbd::World& world) {
  return world.add_body({.type = pbd::BodyType::Static});
}

inline pbd::WorldDef weightless() { return {.gravity = Vec3::Zero()}; }

/// Steps of 1/60 s; `each` is told after every one.
inline void run(pbd::World& world, pbd::Solver& solver, double seconds,
                const std::function<void()>& each = {}) {
  const int steps = static_cast<int>(std::lround(seconds / kFrame));
  for (int i = 0; i < steps; ++i) {
    solver.step(world, kFrame);
    if (each) each();
  }
}

/// The message of the std::invalid_argument that `call` throws; empty where it throws none.
template <class Call>
std::string refusal(Call&& call) {
  try {
    call();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return {};
}

/// Whether the message names all three: field, value and rule.
inline bool names(const std::string& message, const std::string& field, const std::string& value,
                  const std::string& rule) {
  return message.find(field) != std::string::npos && message.find(value) != std::string::npos &&
         message.find(rule) != std::string::npos;
}

}  // namespace tandem::testing
