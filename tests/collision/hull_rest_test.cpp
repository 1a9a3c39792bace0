// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Hulls of random and of scanned points come to rest on every ground: they do not merely look so.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "fixture.h"
#include "tandem/pbd/solver.h"

namespace tandem::collision::testing::hull_rest_test {
namespace {

std::vector<Vec3> random_points(Random& random, double size) {
  std::vector<Vec3> points;
  const int count = 6 + static_cast<int>(random.in(0.0, 50.0));
  for (int i = 0; i < count; ++i) points.push_back(random.vec(0.5 * size));
  return points;
}

/// A box of the given edges, 5 x 5 points a face, each moved by up to `noise`, m.
std::vector<Vec3> scanned_box(Random& random, const Vec3& edges, double noise) {
  std::vector<Vec3> points;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-0.5, 0.5}) {
      for (int i = 0; i < 25; ++i) {
        Vec3 p;
        p[axis] = side;
        p[(axis + 1) % 3] = 0.25 * (i / 5) - 0.5;
        p[(axis + 2) % 3] = 0.25 * (i % 5) - 0.5;
        points.push_back(p.cwiseProduct(edges) + random.vec(noise));
      }
    }
  }
  return points;
}

/// A tin of 24 sides, each corner moved by up to `noise`, m.
std::vector<Vec3> scanned_tin(Random& random, double radius, double height, double noise) {
  std::vector<Vec3> points;
  for (int i = 0; i < 48; ++i) {
    const double angle = std::numbers::pi * (i % 24) / 12;
    points.push_back(Vec3(radius * std::cos(angle), radius * std::sin(angle),
                          i < 24 ? -0.5 * height : 0.5 * height) +
                     random.vec(noise));
  }
  return points;
}

struct Level {
  const char* name;
  Shape shape;
  Vec3 origin;
};

/// Level grounds at height 0, 20 m wide for a size of 1 m.
std::vector<Level> grounds(double size) {
  const double half = 10.0 * size;
  const Vec3 middle(half, half, size);
  std::vector<Vec3> corners;
  for (int i = 0; i < 8; ++i) {
    corners.emplace_back((i & 1) != 0 ? half : -half, (i & 2) != 0 ? half : -half,
                         (i & 4) != 0 ? 0.0 : -size);
  }
  return {{"half-space", HalfSpace{}, Vec3::Zero()},
          {"box", Box{middle}, Vec3(0, 0, -size)},
          {"mesh", flat_mesh(2.0 * half, 1), Vec3::Zero()},
          {"field", HeightField::make(2, 2, 2.0 * half, 2.0 * half, std::vector<double>(4, 0.0)),
           Vec3(-half, -half, 0)},
          {"hull", ConvexHull::make(corners), Vec3::Zero()}};
}

struct Drop {
  Fixture f;
  std::vector<BodyId> ids;
  std::vector<Hull> hulls;

  Drop(const Level& ground, std::span<const Hull> dropped, double size, std::uint64_t seed) {
    f.fixed(ground.shape, {ground.origin, Quat::Identity()});
    Random random(seed);
    for (const Hull& hull : dropped) {
      const auto properties = mass_properties(Shape(hull), 1000.0);
      const Quat turn = random.quat();
      double lowest = HUGE_VAL;
      for (const Vec3& p : hull->points()) {
        lowest = std::min(lowest, (turn * Vec3(p - properties.com)).z());
      }
      const double row = static_cast<double>(ids.size());
      const Vec3 place(3.0 * size * (row - 1.5), 0.37 * size, 0.1 * size - lowest);
      const BodyId id = f.world.add_body(
          {.pose = {place, turn}, .mass = properties.mass, .inertia = properties.inertia});
      f.scene.add(f.world, {.body = id, .shape = hull, .local = {.position = -properties.com}});
      ids.push_back(id);
      hulls.push_back(hull);
    }
    f.world.set_contact_source(&f.scene);
  }

  double depth(std::size_t i) const {
    const Pose& pose = f.world.pose(ids[i]);
    double deepest = 0.0;
    for (const Vec3& arm : hulls[i]->arms()) deepest = std::max(deepest, -pose.to_world(arm).z());
    return deepest;
  }
};

/// None moves at the end, none has sunk in.
void check_rest(std::span<const Hull> hulls, double size, std::uint64_t seed) {
  for (const Level& ground : grounds(size)) {
    INFO(ground.name << ", size " << size << " m, seed " << seed);
    Drop drop(ground, hulls, size, seed);
    pbd::Solver solver({.sleep_after = 0.0});
    // A hull that rocks from one face to the next loses little in each blow: twice the five seconds
    // in which most lie still.
    const int steps = static_cast<int>(600 * std::max(1.0, std::sqrt(size)));
    for (int step = 0; step < steps; ++step) (void)solver.step(drop.f.world, kDt);
    for (std::size_t i = 0; i < hulls.size(); ++i) {
      INFO("hull " << i);
      CHECK(drop.f.world.twist(drop.ids[i]).angular.norm() <= 1e-3);
      CHECK(drop.depth(i) <= std::max(3e-4, 1e-3 * size));
    }
  }
}

TEST_CASE("hull rest: hulls of random points lie still", "[collision][property]") {
  for (const double size : {0.02, 0.3, 2.0}) {
    for (std::uint64_t seed = 1; seed <= 2; ++seed) {
      Random random(seed);
      std::vector<Hull> hulls;
      for (int i = 0; i < 4; ++i) hulls.push_back(ConvexHull::make(random_points(random, size)));
      check_rest(hulls, size, seed);
    }
  }
}

TEST_CASE("hull rest: scanned boxes and tins lie still", "[collision][property]") {
  for (const double size : {0.1, 1.0}) {
    Random random(7);
    std::vector<Hull> hulls;
    for (const double share : {1e-5, 1e-4, 1e-3}) {
      hulls.push_back(
          ConvexHull::make(scanned_box(random, Vec3(size, 0.7 * size, 0.5 * size), share * size)));
    }
    hulls.push_back(ConvexHull::make(scanned_tin(random, 0.35 * size, size, 2e-3 * size)));
    check_rest(hulls, size, 7);
  }
}

// A hull lies on many corners, of which four bear; the others would sink unnoticed.
TEST_CASE("hull rest: parcels with faces scanned at many points lie still",
          "[collision][property]") {
  for (std::uint64_t seed = 1; seed <= 24; ++seed) {
    Random random(seed);
    std::vector<Hull> hulls;
    for (int i = 0; i < 4; ++i) {
      hulls.push_back(ConvexHull::make(scanned_box(random, Vec3(0.4, 0.28, 0.16), 5e-4)));
    }
    check_rest(hulls, 0.4, seed);
  }
}

// The face that lies most nearly on the ground need not have the corner that gets there first.
TEST_CASE("hull rest: a falling hull is stopped by its foremost corner", "[collision][property]") {
  constexpr double kSize = 0.4;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    Random random(seed);
    const Hull hull = ConvexHull::make(random_points(random, kSize));
    const Level ground = grounds(kSize)[seed % 5];
    Drop drop(ground, {&hull, 1}, kSize, seed);
    drop.f.world.set_twist(drop.ids[0], {.linear = Vec3(0, 0, -2)});
    pbd::Solver solver({.sleep_after = 0.0});
    double deepest = 0.0;
    for (int step = 0; step < 60; ++step) {
      (void)solver.step(drop.f.world, 1.0 / 240.0);
      deepest = std::max(deepest, drop.depth(0));
    }
    INFO(ground.name << ", seed " << seed);
    CHECK(deepest <= 0.01 * kSize);
  }
}

TEST_CASE("hull rest: points less than the tolerance outside are left out",
          "[collision][property]") {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    const auto points = scanned_box(random, Vec3::Ones(), random.in(1e-6, 1e-2));
    const double tolerance = random.in(1e-4, 1e-2);
    const auto hull = ConvexHull::make(points, tolerance);
    INFO("seed " << seed);
    for (const Vec3& p : points) {
      for (const ConvexHull::Face& face : hull->faces()) {
        // The thickness is at most the longest diagonal.
        CHECK(face.normal.dot(p - hull->centre()) <= face.offset + 1.8 * tolerance);
      }
    }
    const auto again = ConvexHull::make(hull->points(), tolerance);
    REQUIRE(again->arms().size() == hull->arms().size());
    for (std::size_t i = 0; i < hull->arms().size(); ++i)
      CHECK(again->arms()[i] == hull->arms()[i]);
    CHECK(again->centre() == hull->centre());
  }
  CHECK_THROWS_WITH(ConvexHull::make(std::vector<Vec3>(4, Vec3::Zero()), -1.0),
                    Catch::Contains("tolerance"));
}

}  // namespace
}  // namespace tandem::collision::testing::hull_rest_test
