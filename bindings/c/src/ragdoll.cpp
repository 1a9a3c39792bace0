// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/ragdoll.h"

#include "parts.h"

using namespace tandem;
using namespace tandem::c;

struct tandem_ragdoll {
  tandem_world& world;
  Ragdoll ragdoll;
};

void tandem_ragdoll_def_init(tandem_ragdoll_def* def) {
  if (def == nullptr) return;
  const RagdollDef defaults;
  *def = {.pose = to_c(defaults.pose),
          .height = defaults.height,
          .mass = defaults.mass,
          .damping = defaults.damping,
          .friction = defaults.material.friction,
          .restitution = defaults.material.restitution,
          .filter = to_c(defaults.filter)};
}

tandem_ragdoll* tandem_ragdoll_create(tandem_world* world, const tandem_ragdoll_def* def,
                                      tandem_error* error) {
  return made_by(error, [&] {
    tandem_world& w = required(world, "world");
    const tandem_ragdoll_def& d = required(def, "def");
    return new tandem_ragdoll{
        .world = w,
        .ragdoll =
            Ragdoll(*w.scene, {.pose = from_c(d.pose),
                               .height = d.height,
                               .mass = d.mass,
                               .damping = d.damping,
                               .material = {.friction = d.friction, .restitution = d.restitution},
                               .filter = from_c(d.filter)})};
  });
}

void tandem_ragdoll_destroy(tandem_ragdoll* ragdoll) {
  if (ragdoll == nullptr) return;
  remove_all(ragdoll->world, ragdoll->ragdoll.bodies());
  delete ragdoll;
}

size_t tandem_ragdoll_bodies(const tandem_ragdoll* ragdoll, tandem_body* bodies, size_t capacity) {
  return ragdoll != nullptr ? copied(ragdoll->ragdoll.bodies(), bodies, capacity) : 0;
}
