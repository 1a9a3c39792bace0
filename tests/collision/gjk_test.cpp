// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "gjk.h"

#include "fixture.h"

namespace gjk_test {

using namespace tandem::collision;
using namespace tandem::collision::testing;

namespace {

ConvexCore random_core(Random& random, int kind) {
  ConvexCore core;
  core.kind = static_cast<CoreKind>(kind);
  core.centre = random.vec(1.5);
  core.axes = random.quat().toRotationMatrix();
  if (core.kind == CoreKind::Segment) core.half = Vec3(0, 0, random.in(0.1, 1.0));
  if (core.kind == CoreKind::Box) core.half = random.vec_in(0.02, 1.0);
  if (core.kind == CoreKind::Triangle) {
    for (Vec3& corner : core.corners) corner = core.centre + random.vec(1.0);
    core.centre = (core.corners[0] + core.corners[1] + core.corners[2]) / 3.0;
    core.front =
        (core.corners[1] - core.corners[0]).cross(core.corners[2] - core.corners[0]).normalized();
  }
  if (core.kind < CoreKind::Box) core.radius = random.in(0.05, 0.5);
  core.size = 0.5;
  return core;
}

/// m by which the point lies outside the core's bounding planes (a core is the meet of those that
/// are tested; for a triangle its plane and its edges').
double outside(const ConvexCore& core, const Vec3& p) {
  if (core.kind == CoreKind::Triangle) {
    double most = std::abs(core.front.dot(p - core.corners[0]));
    for (int k = 0; k < 3; ++k) {
      const Vec3 edge = (core.corners[(k + 1) % 3] - core.corners[k]).normalized();
      most = std::max(most, edge.cross(core.front).dot(p - core.corners[k]));
    }
    return most;
  }
  const Vec3 local = core.axes.transpose() * (p - core.centre);
  return (local.cwiseAbs() - core.half).maxCoeff();
}

}  // namespace

TEST_CASE("gjk: witnesses lie on both cores, and planes through them bound the cores",
          "[collision][unit]") {
  // Together these two prove the distance: the first that it is not less, the second not more.
  Random random(11);
  int apart = 0;
  for (int i = 0; i < 20000; ++i) {
    const ConvexCore a = random_core(random, i % 4);
    const ConvexCore b = random_core(random, (i / 4) % 4);
    const CoreDistance d = core_distance(a, b);
    if (!d.apart) {
      CHECK(proximity(a, b).gap <= 1e-9);
      continue;
    }
    ++apart;
    REQUIRE(outside(a, d.on_a) < 1e-12);
    REQUIRE(outside(b, d.on_b) < 1e-12);
    REQUIRE((d.on_b - d.on_a - d.distance * d.normal).norm() < 1e-12);
    REQUIRE(std::abs(-b.reach(-d.normal) - a.reach(d.normal) - d.distance) < 1e-10);
    REQUIRE(d.least <= d.distance);
  }
  CHECK(apart > 10000);
}

TEST_CASE("gjk: the bounds meet for all sizes", "[collision][unit]") {
  // Millimetres against kilometres, needles and plates among them: long, thin simplices.
  Random random(13);
  const auto scale = [&] { return std::pow(10.0, random.in(-3.0, 3.0)); };
  for (int i = 0; i < 20000; ++i) {
    ConvexCore a = random_core(random, 1 + i % 2);
    ConvexCore b = random_core(random, 1 + (i / 2) % 2);
    for (ConvexCore* core : {&a, &b}) {
      core->radius = 0.0;
      core->centre *= scale();
      core->half *= scale();
      if (core->kind == CoreKind::Box) core->half[i % 3] *= std::pow(10.0, random.in(-3.0, 0.0));
      if (i % 3 == 0) core->axes.setIdentity();
    }
    const CoreDistance d = core_distance(a, b);
    if (!d.apart) continue;
    REQUIRE(d.distance - (-b.reach(-d.normal) - a.reach(d.normal)) < 1e-11 * d.size);
  }
}

TEST_CASE("gjk: a cast stops where the shapes touch and not before", "[collision][unit]") {
  Random random(12);
  int hits = 0;
  int misses = 0;
  for (int i = 0; i < 4000; ++i) {
    const ConvexCore a = random_core(random, i % 3);
    ConvexCore b = random_core(random, (i / 3) % 4);
    const Vec3 shift = 3.0 * random.vec(1.0).normalized();
    b.centre += shift;
    for (Vec3& corner : b.corners) corner += shift;
    const Vec3 direction = (shift.normalized() + random.vec(0.4)).normalized();
    double travel = 0.0;
    Proximity at;
    const bool hit = cast_core(a, b, direction, 6.0, travel, at);
    (hit ? hits : misses) += 1;
    ConvexCore moved = a;
    const double end = hit ? travel : 6.0;
    for (int k = 0; k <= 40; ++k) {
      moved.centre = a.centre + (end * k / 40.0 - 1e-6) * direction;
      const double gap = proximity(moved, b).gap;
      if (hit && travel > 0.0 && k == 40) {
        REQUIRE(gap > 0.0);
        REQUIRE(gap < 1.1e-6);
        REQUIRE(direction.dot(at.normal) > 0.0);
      } else if (travel > 0.0 || !hit) {
        REQUIRE(gap > -1e-9);
      }
    }
  }
  CHECK(hits > 500);
  CHECK(misses > 500);
}

TEST_CASE("gjk: a grazing cast keeps to the analytic contact time", "[collision][analytic]") {
  // Two balls that pass at almost the sum of their radii.
  ConvexCore a = point_core(Vec3(-5, 0, 0));
  a.radius = 0.5;
  for (const double share : {0.0, 0.5, 0.9, 0.999, 0.999999}) {
    ConvexCore b = point_core(Vec3(0, 0.8 * share, 0));
    b.radius = 0.3;
    double travel = 0.0;
    Proximity at;
    REQUIRE(cast_core(a, b, Vec3::UnitX(), 20.0, travel, at));
    CHECK(travel == Approx(5.0 - 0.8 * std::sqrt(1.0 - share * share)).margin(2e-6));
  }
  ConvexCore b = point_core(Vec3(0, 0.8 + 1e-6, 0));
  b.radius = 0.3;
  double travel = 0.0;
  Proximity at;
  CHECK_FALSE(cast_core(a, b, Vec3::UnitX(), 20.0, travel, at));
}

}  // namespace gjk_test
