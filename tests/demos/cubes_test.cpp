// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "scenes/cubes.h"

#include <set>
#include <stdexcept>

#include "support/catch.h"
#include "tandem/pbd/solver.h"

namespace tandem::demos::cubes_test {
namespace {

using pbd::Vec3;

TEST_CASE("cubes: ids, measures and places are the same in any order", "[demos][unit]") {
  const CubesScenario scenario;
  const Scene plain = scenario.build({});
  const Scene shuffled = scenario.build({.order_seed = 5, .noise_seed = 0});
  REQUIRE(plain.bodies.size() == 1 + 4 * 4 + 4);
  REQUIRE(shuffled.bodies.size() == plain.bodies.size());
  std::size_t moved = 0;
  std::set<consensus::SharedId> ids;
  for (std::size_t i = 0; i < plain.bodies.size(); ++i) {
    const SceneBody& a = plain.bodies[i];
    const SceneBody& b = shuffled.bodies[i];
    CHECK(a.name == b.name);
    CHECK(a.id == b.id);
    CHECK(a.id == consensus::SharedId::from_name(a.name));
    CHECK(plain.pose(a).position == shuffled.pose(b).position);
    CHECK(plain.world->props(a.body).mass == shuffled.world->props(b.body).mass);
    moved += a.body.index != b.body.index ? 1 : 0;
    ids.insert(a.id);
  }
  CHECK(ids.size() == plain.bodies.size());
  CHECK(moved > plain.bodies.size() / 2);
  CHECK(scene_hash(plain) == scene_hash(shuffled));
  CHECK(scene_hash(plain) != scene_hash(CubesScenario({.height = 3}).build({})));
}

TEST_CASE("cubes: start-up noise is seeded, bounded and independent of the order",
          "[demos][unit]") {
  const CubesScenario scenario;
  const Scene a = scenario.build({.order_seed = 1, .noise_seed = 9});
  const Scene b = scenario.build({.order_seed = 2, .noise_seed = 9});
  const Scene c = scenario.build({.order_seed = 1, .noise_seed = 10});
  double largest = 0.0;
  for (std::size_t i = 0; i < a.bodies.size(); ++i) {
    const Vec3 offset = a.pose(a.bodies[i]).position - a.bodies[i].start;
    largest = std::max(largest, offset.cwiseAbs().maxCoeff());
    CHECK(a.pose(a.bodies[i]).position == b.pose(b.bodies[i]).position);
    CHECK(a.pose(a.bodies[i]).position != c.pose(c.bodies[i]).position);
  }
  CHECK(largest <= 1e-4);
  CHECK(largest > 0.5e-4);
}

TEST_CASE("cubes: nothing overlaps at the start and everything stays where it is",
          "[demos][unit]") {
  const CubesScenario scenario;
  Scene scene = scenario.build({.order_seed = 3, .noise_seed = 4});
  pbd::Solver solver;
  for (int i = 0; i < 120; ++i) {
    REQUIRE(solver.step(*scene.world, 1.0 / 60.0).status == pbd::StepStatus::Ok);
  }
  CHECK(scenario.fault(scene).empty());
  for (const SceneBody& body : scene.bodies) {
    CHECK((scene.pose(body).position - body.start).norm() < 1e-3);
  }
}

TEST_CASE("cubes: a pillar that was touched is a fault", "[demos][unit]") {
  const CubesScenario scenario;
  Scene scene = scenario.build({});
  CHECK(scenario.fault(scene).empty());
  const SceneBody& body = scene.body("pillar/2");
  pbd::Pose pose = scene.pose(body);
  pose.position.x() += 6e-3;
  scene.world->set_pose(body.body, pose);
  CHECK_THAT(scenario.fault(scene), Catch::Contains("pillar/2"));
}

TEST_CASE("cubes: measures that make no scene are refused by name", "[demos][fault]") {
  CHECK_THROWS_WITH(CubesScenario({.stacks = 1}), Catch::Contains("stacks"));
  CHECK_THROWS_WITH(CubesScenario({.edge = -1.0}), Catch::Contains("edge"));
  CHECK_THROWS_WITH(CubesScenario({.stacks = 9}), Catch::Contains("plate"));
  CHECK_THROWS_AS(CubesScenario().build({}).body("nobody"), std::invalid_argument);
}

}  // namespace
}  // namespace tandem::demos::cubes_test
