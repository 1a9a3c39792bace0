// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "session/geometry.h"

#include <cmath>
#include <numbers>

#include "support/catch.h"
#include "tandem/pbd/math.h"

namespace tandem::demos::geometry_test {
namespace {

using pbd::Pose;
using pbd::Vec3;

const Vec3 kHalf = Vec3::Constant(0.05);

Pose at(double x, double y, double z, const Vec3& rotation = Vec3::Zero()) {
  return {Vec3(x, y, z), pbd::exp_map(rotation)};
}

TEST_CASE("geometry: overlap of boxes along a face is the depth", "[demos][analytic]") {
  CHECK(box_overlap(at(0, 0, 0), kHalf, at(0, 0, 0.099), kHalf) == Approx(0.001));
  CHECK(box_overlap(at(0, 0, 0), kHalf, at(0.02, -0.03, 0.099), kHalf) == Approx(0.001));
  CHECK(box_overlap(at(0, 0, 0), kHalf, at(0, 0, 0.101), kHalf) == 0.0);
  CHECK(box_overlap(at(0, 0, 0), Vec3(0.8, 0.4, 0.02), at(0.5, 0.1, 0.06), kHalf) == Approx(0.01));
}

TEST_CASE("geometry: a box on its edge reaches as far as its diagonal", "[demos][analytic]") {
  const double diagonal = 0.05 * std::numbers::sqrt2;
  const Vec3 turn(std::numbers::pi / 4.0, 0.0, 0.0);
  CHECK(box_overlap(at(0, 0, 0), kHalf, at(0, 0, 0.05 + diagonal - 1e-3, turn), kHalf) ==
        Approx(1e-3));
  CHECK(box_overlap(at(0, 0, 0), kHalf, at(0, 0, 0.05 + diagonal + 1e-3, turn), kHalf) == 0.0);
  CHECK(ground_overlap(at(0, 0, diagonal - 2e-3, turn), kHalf) == Approx(2e-3));
  CHECK(ground_overlap(at(0, 0, diagonal + 2e-3, turn), kHalf) == 0.0);
}

TEST_CASE("geometry: crossed edges are parted by no face but by their common normal",
          "[demos][analytic]") {
  // Two boxes on edge, the edges crossed at right angles, one above the other: faces overlap by far
  // more than the 1 mm that the edges do.
  const double diagonal = 0.05 * std::numbers::sqrt2;
  const Pose low = at(0, 0, 0, Vec3(std::numbers::pi / 4.0, 0.0, 0.0));
  const Vec3 turn(0.0, std::numbers::pi / 4.0, 0.0);
  CHECK(box_overlap(low, kHalf, at(0, 0, 2.0 * diagonal - 1e-3, turn), kHalf) == Approx(1e-3));
  CHECK(box_overlap(low, kHalf, at(0, 0, 2.0 * diagonal + 1e-3, turn), kHalf) == 0.0);
}

TEST_CASE("geometry: each overlapping pair of a scene gives one number", "[demos][unit]") {
  SceneBuilder builder;
  builder.box("a", Vec3::Constant(0.1), 1.0, Vec3(0.0, 0.0, 0.049));   // 1 mm in the ground
  builder.box("b", Vec3::Constant(0.1), 1.0, Vec3(0.02, 0.0, 0.146));  // 3 mm in a
  builder.box("c", Vec3::Constant(0.1), 1.0, Vec3(0.5, 0.0, 0.06));
  const Scene scene = builder.build({}, 0.5);
  std::vector<double> depths;
  append_penetrations(scene, depths);
  REQUIRE(depths.size() == 2);
  CHECK(depths[0] == Approx(0.001));
  CHECK(depths[1] == Approx(0.003));
}

}  // namespace
}  // namespace tandem::demos::geometry_test
