// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <cmath>
#include <cstdio>

#include "tandem/obj/load_obj.h"

// A tetrahedron is read from text and weighed.
int main() {
  using namespace tandem;
  const collision::Mesh mesh = obj::parse_obj(
      "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n", "tetrahedron");
  const double mass = collision::mass_properties(collision::Shape(mesh), 600.0).mass;
  std::printf("obj: the tetrahedron weighs %.1f kg\n", mass);
  return std::abs(mass - 100.0) < 1e-9 ? 0 : 1;
}
