// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/cloth.h"

#include <vector>

#include "parts.h"

using namespace tandem;
using namespace tandem::c;

struct tandem_cloth {
  tandem_world& world;
  Cloth cloth;
  std::vector<pbd::BodyId> handles;
};

void tandem_cloth_def_init(tandem_cloth_def* def) {
  if (def == nullptr) return;
  const ClothDef defaults;
  *def = {.pose = to_c(defaults.pose),
          .width = defaults.width,
          .height = defaults.height,
          .columns = defaults.columns,
          .rows = defaults.rows,
          .density = defaults.density,
          .radius = defaults.radius,
          .stretching = defaults.stretching,
          .shearing = defaults.shearing,
          .bending = defaults.bending,
          .damping = defaults.damping,
          .friction = defaults.material.friction,
          .restitution = defaults.material.restitution,
          .filter = to_c(defaults.filter)};
}

tandem_cloth* tandem_cloth_create(tandem_world* world, const tandem_cloth_def* def,
                                  tandem_error* error) {
  return made_by(error, [&] {
    tandem_world& w = required(world, "world");
    const tandem_cloth_def& d = required(def, "def");
    return new tandem_cloth{
        .world = w,
        .cloth =
            Cloth(*w.scene, {.pose = from_c(d.pose),
                             .width = d.width,
                             .height = d.height,
                             .columns = d.columns,
                             .rows = d.rows,
                             .density = d.density,
                             .radius = d.radius,
                             .stretching = d.stretching,
                             .shearing = d.shearing,
                             .bending = d.bending,
                             .damping = d.damping,
                             .material = {.friction = d.friction, .restitution = d.restitution},
                             .filter = from_c(d.filter)}),
        .handles = {}};
  });
}

void tandem_cloth_destroy(tandem_cloth* cloth) {
  if (cloth == nullptr) return;
  remove_all(cloth->world, cloth->handles);
  remove_all(cloth->world, cloth->cloth.particles());
  delete cloth;
}

size_t tandem_cloth_bodies(const tandem_cloth* cloth, tandem_body* bodies, size_t capacity) {
  return cloth != nullptr ? copied(cloth->cloth.particles(), bodies, capacity) : 0;
}

tandem_result tandem_cloth_attach(tandem_cloth* cloth, int32_t column, int32_t row,
                                  tandem_body host, tandem_attachment* attachment,
                                  tandem_error* error) {
  return guarded(error, [&] {
    const pbd::ClothRowId held = required(cloth, "cloth").cloth.attach(column, row, from_c(host));
    if (attachment != nullptr) *attachment = {held.number};
  });
}

tandem_result tandem_cloth_tether(tandem_cloth* cloth, tandem_error* error) {
  return guarded(error, [&] {
    tandem_cloth& c = required(cloth, "cloth");
    require_all(c.world, c.cloth.particles(), "cloth");
    c.cloth.tether();
  });
}

tandem_result tandem_cloth_add_handle(tandem_cloth* cloth, double u, double v, double reach,
                                      double share, tandem_body* body, tandem_error* error) {
  return guarded(error, [&] {
    tandem_cloth& c = required(cloth, "cloth");
    tandem_body& out = required(body, "body");
    require_all(c.world, c.cloth.particles(), "cloth");
    c.handles.reserve(c.handles.size() + 1);
    c.handles.push_back(c.cloth.add_handle(u, v, reach, share));
    out = to_c(c.handles.back());
  });
}
