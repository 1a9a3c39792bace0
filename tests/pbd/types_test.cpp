// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/pbd/types.h"

#include "support/catch.h"
#include "support/oracles.h"

namespace types_test {

using namespace tandem::pbd;
using namespace tandem::testing;

TEST_CASE("types: a pose maps points to the world and back", "[pbd][unit]") {
  const Pose pose{Vec3(1.0, 2.0, 3.0), turn(Vec3(0.0, 0.0, kPi / 2.0))};
  // A quarter turn about z sends x to y.
  CHECK((pose.to_world(Vec3(2.0, 0.0, 0.5)) - Vec3(1.0, 4.0, 3.5)).norm() < 1e-15);
  const Pose tilted{Vec3(-4.0, 0.3, 9.0), turn(Vec3(0.4, -1.9, 0.8))};
  const Vec3 point(0.2, -5.0, 1.0);
  CHECK((tilted.to_local(tilted.to_world(point)) - point).norm() < 1e-14);
}

TEST_CASE("types: the layout of a quaternion asks for no alignment beyond a double's",
          "[pbd][unit]") {
  STATIC_REQUIRE(alignof(Quat) == alignof(double));
  STATIC_REQUIRE(sizeof(Quat) == 4 * sizeof(double));
  STATIC_REQUIRE(sizeof(Pose) == 7 * sizeof(double));
}

TEST_CASE("types: default poses and twists are the identity and rest", "[pbd][unit]") {
  const Pose pose;
  const Twist twist;
  CHECK(pose.to_world(Vec3(1.0, 2.0, 3.0)) == Vec3(1.0, 2.0, 3.0));
  CHECK((twist.linear.norm() == 0.0 && twist.angular.norm() == 0.0));
}

}  // namespace types_test
