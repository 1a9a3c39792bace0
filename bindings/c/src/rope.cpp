// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/rope.h"

#include "parts.h"

using namespace tandem;
using namespace tandem::c;

struct tandem_rope {
  tandem_world& world;
  Rope rope;
};

void tandem_rope_def_init(tandem_rope_def* def) {
  if (def == nullptr) return;
  const RopeDef defaults;
  *def = {.from = to_c(defaults.from),
          .to = to_c(defaults.to),
          .length = 0.0,
          .particles = defaults.particles,
          .mass = defaults.mass,
          .radius = defaults.radius,
          .compliance = defaults.compliance,
          .bending = defaults.bending,
          .damping = defaults.damping,
          .friction = defaults.material.friction,
          .restitution = defaults.material.restitution,
          .filter = to_c(defaults.filter)};
}

tandem_rope* tandem_rope_create(tandem_world* world, const tandem_rope_def* def,
                                tandem_error* error) {
  return made_by(error, [&] {
    tandem_world& w = required(world, "world");
    const tandem_rope_def& d = required(def, "def");
    return new tandem_rope{
        .world = w,
        .rope = Rope(*w.scene, {.from = from_c(d.from),
                                .to = from_c(d.to),
                                .length = d.length != 0.0 ? std::optional(d.length) : std::nullopt,
                                .particles = d.particles,
                                .mass = d.mass,
                                .radius = d.radius,
                                .compliance = d.compliance,
                                .bending = d.bending,
                                .damping = d.damping,
                                .material = {.friction = d.friction, .restitution = d.restitution},
                                .filter = from_c(d.filter)})};
  });
}

void tandem_rope_destroy(tandem_rope* rope) {
  if (rope == nullptr) return;
  remove_all(rope->world, rope->rope.particles());
  delete rope;
}

size_t tandem_rope_bodies(const tandem_rope* rope, tandem_body* bodies, size_t capacity) {
  return rope != nullptr ? copied(rope->rope.particles(), bodies, capacity) : 0;
}

tandem_result tandem_rope_attach(tandem_rope* rope, uint32_t particle, tandem_body host,
                                 tandem_attachment* attachment, tandem_error* error) {
  return guarded(error, [&] {
    const pbd::ClothRowId row = required(rope, "rope").rope.attach(particle, from_c(host));
    if (attachment != nullptr) *attachment = {row.number};
  });
}
