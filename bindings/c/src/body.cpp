// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "convert.h"
#include "guard.h"
#include "world_impl.h"

using namespace tandem;
using namespace tandem::c;

namespace {

pbd::BodyType type_of(tandem_body_type type) {
  switch (type) {
    case TANDEM_STATIC:
      return pbd::BodyType::Static;
    case TANDEM_KINEMATIC:
      return pbd::BodyType::Kinematic;
    case TANDEM_DYNAMIC:
      return pbd::BodyType::Dynamic;
  }
  refuse_unlisted("type", type, "tandem_body_type");
}

/// A call on the world, about a body.
template <class Call>
tandem_result on_world(tandem_world* world, tandem_error* error, Call&& call) {
  return guarded(error, [&] { call(required(world, "world").world); });
}

}  // namespace

void tandem_body_def_init(tandem_body_def* def) {
  if (def == nullptr) return;
  const pbd::BodyDef defaults;
  *def = {.type = TANDEM_DYNAMIC,
          .pose = to_c(defaults.pose),
          .twist = to_c(defaults.twist),
          .mass = defaults.mass,
          .inertia = {},
          .gravity_scale = defaults.gravity_scale,
          .linear_damping = defaults.linear_damping,
          .angular_damping = defaults.angular_damping,
          .bullet = 0,
          .can_sleep = 1};
  matrix_to_c(defaults.inertia, def->inertia);
}

tandem_result tandem_body_add(tandem_world* world, const tandem_body_def* def, tandem_body* body,
                              tandem_error* error) {
  return guarded(error, [&] {
    const tandem_body_def& d = required(def, "def");
    tandem_body& out = required(body, "body");
    out = to_c(required(world, "world")
                   .world.add_body({.type = type_of(d.type),
                                    .pose = from_c(d.pose),
                                    .twist = from_c(d.twist),
                                    .mass = d.mass,
                                    .inertia = matrix_from_c(d.inertia),
                                    .gravity_scale = d.gravity_scale,
                                    .linear_damping = d.linear_damping,
                                    .angular_damping = d.angular_damping,
                                    .bullet = d.bullet != 0,
                                    .can_sleep = d.can_sleep != 0}));
  });
}

tandem_result tandem_body_remove(tandem_world* world, tandem_body body, tandem_error* error) {
  return on_world(world, error, [&](pbd::World& w) { w.remove_body(from_c(body)); });
}

int32_t tandem_body_exists(const tandem_world* world, tandem_body body) {
  return world != nullptr && world->world.contains(from_c(body)) ? 1 : 0;
}

tandem_result tandem_body_state(const tandem_world* world, tandem_body body, tandem_state* state,
                                tandem_error* error) {
  return guarded(error, [&] {
    required(state, "state") = to_c(required(world, "world").world.state(from_c(body)));
  });
}

tandem_result tandem_body_states(const tandem_world* world, const tandem_body* bodies, size_t count,
                                 tandem_state* states, tandem_error* error) {
  return guarded(error, [&] {
    const pbd::World& w = required(world, "world").world;
    if (count == 0) return;
    const tandem_body* const ids = &required(bodies, "bodies");
    tandem_state* const out = &required(states, "states");
    // All or none.
    for (size_t i = 0; i < count; ++i) (void)w.state(from_c(ids[i]));
    for (size_t i = 0; i < count; ++i) out[i] = to_c(w.state(from_c(ids[i])));
  });
}

int32_t tandem_body_awake(const tandem_world* world, tandem_body body) {
  const bool there = world != nullptr && world->world.contains(from_c(body));
  return there && world->world.awake(from_c(body)) ? 1 : 0;
}

tandem_result tandem_body_set_pose(tandem_world* world, tandem_body body, const tandem_pose* pose,
                                   tandem_error* error) {
  return on_world(world, error,
                  [&](pbd::World& w) { w.set_pose(from_c(body), from_c(required(pose, "pose"))); });
}

tandem_result tandem_body_set_twist(tandem_world* world, tandem_body body,
                                    const tandem_twist* twist, tandem_error* error) {
  return on_world(world, error, [&](pbd::World& w) {
    w.set_twist(from_c(body), from_c(required(twist, "twist")));
  });
}

tandem_result tandem_body_move_to(tandem_world* world, tandem_body body, const tandem_pose* pose,
                                  tandem_error* error) {
  return on_world(world, error, [&](pbd::World& w) {
    w.set_kinematic_target(from_c(body), from_c(required(pose, "pose")));
  });
}

tandem_result tandem_body_apply_force(tandem_world* world, tandem_body body, tandem_vec3 force,
                                      const tandem_vec3* point, tandem_error* error) {
  return on_world(world, error, [&](pbd::World& w) {
    if (point == nullptr) {
      w.apply_force(from_c(body), from_c(force));
    } else {
      w.apply_force(from_c(body), from_c(force), from_c(*point));
    }
  });
}

tandem_result tandem_body_apply_torque(tandem_world* world, tandem_body body, tandem_vec3 torque,
                                       tandem_error* error) {
  return on_world(world, error,
                  [&](pbd::World& w) { w.apply_torque(from_c(body), from_c(torque)); });
}

tandem_result tandem_body_apply_impulse(tandem_world* world, tandem_body body, tandem_vec3 impulse,
                                        const tandem_vec3* point, tandem_error* error) {
  return on_world(world, error, [&](pbd::World& w) {
    const pbd::BodyId id = from_c(body);
    w.apply_impulse(id, from_c(impulse), point != nullptr ? from_c(*point) : w.pose(id).position);
  });
}
