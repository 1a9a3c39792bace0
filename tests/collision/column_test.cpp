// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// What falls together, and further in a step than it is large.
#include "scenes.h"
#include "tandem/pbd/solver.h"

namespace column_test {

using namespace tandem::collision;
using namespace tandem::collision::testing;
using tandem::pbd::Solver;

TEST_CASE("column: small things that fall together do not pass through each other",
          "[collision][unit]") {
  Random random(77);
  for (int i = 0; i < 60; ++i) {
    const double edge = random.in(0.015, 0.06);
    const double gap = edge * random.in(0.3, 2.0);
    const double half = 0.5 * edge;
    const std::array<Shape, 3> shapes{Box{Vec3::Constant(half)}, Sphere{half},
                                      Cylinder{half, half}};
    const double mass = 1000.0 * edge * edge * edge;
    Fixture f;
    f.fixed(Box{Vec3(1, 1, 0.5)}, at(0, 0, -0.5));
    std::vector<BodyId> column;
    const double height = edge * random.in(0.2, 8.0);
    for (int k = 0; k < 12; ++k) {
      column.push_back(
          f.world.add_body({.pose = at(0, 0, height + half + k * (edge + gap)),
                            .mass = mass,
                            .inertia = mass * edge * edge / 6.0 * tandem::pbd::Mat3::Identity()}));
      f.scene.add(f.world, {.body = column.back(), .shape = shapes[i % 3]});
    }
    f.world.set_contact_source(&f.scene);
    Solver solver;
    double least = edge;
    for (int step = 0; step < 60; ++step) {
      (void)solver.step(f.world, kDt);
      double below = -half;  // the ground
      for (const BodyId id : column) {
        const double z = f.world.pose(id).position.z();
        least = std::min(least, z - below);  // negative where they have changed places
        below = z;
      }
    }
    INFO("kind " << i % 3 << " edge " << edge << " gap " << gap << " height " << height);
    CHECK(least > 0.8 * edge);
  }
}

}  // namespace column_test
