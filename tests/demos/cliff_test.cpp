// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "scenes/cliff.h"

#include "demos/scenes/cliff_geometry.h"
#include "measures/report.h"
#include "runner/virtual_runner.h"
#include "runs.h"
#include "support/catch.h"
#include "tandem/pbd/solver.h"

namespace tandem::demos::cliff_test {
namespace {

using pbd::Vec3;

TEST_CASE("cliff: the surface is the triangles'", "[demos][analytic]") {
  const CliffMesh mesh = cliff_mesh();
  REQUIRE(mesh.triangles.size() == 2 * kCliffCells * kCliffCells);
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 97) {
    Vec3 middle = Vec3::Zero();
    for (const std::uint32_t corner : mesh.triangles[t]) middle += mesh.vertices[corner] / 3.0;
    CHECK(cliff_surface(middle.x(), middle.y()) == Approx(middle.z()).margin(1e-12));
  }
}

TEST_CASE("cliff: balls hang in the air, and fall from where they would be by now",
          "[demos][analytic]") {
  const CliffScenario scenario(100);
  Scene scene = scenario.build({});
  pbd::Solver solver;
  for (int i = 0; i < 60; ++i) static_cast<void>(solver.step(*scene.world, 1.0 / 60.0));
  const Vec3 start = scene.bodies[42].start;
  CHECK((scene.pose(42).position - start).norm() == 0.0);
  scenario.on_signal(scene, {1, 1'000'000'000}, 1'100'000'000);
  CHECK(scene.pose(42).position.z() == Approx(start.z() - 0.5 * 9.81 * 0.01));
  CHECK(scene.twist(42).linear.z() == Approx(-0.981));
  static_cast<void>(solver.step(*scene.world, 0.05));
  CHECK(scene.pose(42).position.z() == Approx(start.z() - 0.5 * 9.81 * 0.0225).margin(0.02));
}

TEST_CASE("cliff: a ball under the ground is a fault", "[demos][unit]") {
  const CliffScenario scenario(10);
  Scene scene = scenario.build({});
  CHECK(scenario.fault(scene).empty());
  scene.world->set_pose(scene.bodies[3].body, {Vec3(-3.0, 0.0, 5.0), pbd::Quat::Identity()});
  CHECK_THAT(scenario.fault(scene), Catch::Contains("ball/3"));
}

TEST_CASE("cliff: nothing is lost, nothing tunnels, and the peers agree across an ocean",
          "[demos][soak]") {
  const RunResult result = run_virtual(CliffScenario(200), quiet(5, 8.0));
  for (const PeerRecord& peer : result.peers) {
    CHECK(peer.fault == "");
    CHECK(number(peer, "lost") == 0.0);
    CHECK(number(peer, "over_the_cliff") > 20.0);
    CHECK(number(peer, "deepest_m") < 0.5 * kCliffBallRadius);
  }
  CHECK(evaluate(result.peers).divergence_m.p50 <= 0.01);
}

}  // namespace
}  // namespace tandem::demos::cliff_test
