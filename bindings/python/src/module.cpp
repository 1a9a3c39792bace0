// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "bind.h"

PYBIND11_MODULE(_tandem, m) {
  using namespace tandem::python;
  m.attr("__version__") = TANDEM_VERSION;
  bind_shapes(m);
  bind_bodies(m);
  auto scene = bind_scene(m);
  bind_joints(m, scene);
  bind_queries(m, scene);
  bind_contacts(m, scene);
  bind_files(scene);
  bind_characters(m);
  bind_cars(m);
  bind_ropes(m);
  bind_cloth(m);
  bind_ragdolls(m);
  bind_shown(scene);
  bind_batch(m);
  bind_networks(m);
  bind_sessions(m);
}
