// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Hulls of points as files have them: of single precision, on a grid, too many of them, or flat.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "support/bodies.h"
#include "support/catch.h"
#include "tandem/collision/convex_hull.h"
#include "tandem/pbd/random.h"

namespace collision_test {
namespace {

using namespace tandem;
using collision::ConvexHull;
using pbd::Vec3;
using tandem::testing::refusal;

/// How far the farthest point lies above the hull, m.
double most_above(const ConvexHull& hull, const std::vector<Vec3>& points) {
  double most = 0.0;
  for (const Vec3& p : points) {
    for (const auto& face : hull.faces()) {
      most = std::max(most, face.normal.dot(p - hull.centre()) - face.offset);
    }
  }
  return most;
}

/// Evenly on the unit sphere, by the golden angle.
std::vector<Vec3> sphere(int count) {
  std::vector<Vec3> points;
  for (int i = 0; i < count; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / count;
    const double turn = i * std::numbers::pi * (3.0 - std::sqrt(5.0));
    const double r = std::sqrt(1.0 - z * z);
    points.emplace_back(r * std::cos(turn), r * std::sin(turn), z);
  }
  return points;
}

TEST_CASE("hull: points of a grid with the noise of single precision have a hull",
          "[hull][numerics]") {
  pbd::SplitMix64 random(46);
  const auto noise = [&](double size) {
    return Vec3(random.uniform(-size, size), random.uniform(-size, size),
                random.uniform(-size, size));
  };
  for (const double size : {1e-9, 1e-8, 3e-8, 1e-7, 1e-6}) {
    for (int draw = 0; draw < 60; ++draw) {
      CAPTURE(size, draw);
      const Vec3 spacing(random.uniform(0.1, 1.0), random.uniform(0.1, 1.0),
                         random.uniform(0.1, 1.0));
      const int nx = 2 + draw % 4;
      std::vector<Vec3> points;
      for (int i = 0; i < nx * 4; ++i) {
        const Vec3 at(i / 4, i / 2 % 2, i % 2);
        points.push_back(at.cwiseProduct(spacing) + noise(size));
      }
      std::shared_ptr<const ConvexHull> hull;
      REQUIRE_NOTHROW(hull = ConvexHull::make(points, draw % 2 == 0 ? 0.0 : 1e-3));
      const double extent = Vec3(nx - 1, 1.0, 1.0).cwiseProduct(spacing).maxCoeff();
      CHECK(most_above(*hull, points) <= 2.0 * size + 2e-6 * extent);
      CHECK(hull->volume() == Approx((nx - 1) * spacing.prod()).epsilon(1e-4));
    }
  }
}

TEST_CASE("hull: of too many corners as many are kept as may be, and the error is told", "[hull]") {
  const std::vector<Vec3> points = sphere(1000);
  CHECK(refusal([&] { ConvexHull::make(points); }).find("at most 128") != std::string::npos);
  const auto [hull, error] = ConvexHull::simplify(points);
  CHECK(hull->points().size() == ConvexHull::kMaxVertices);
  CHECK(most_above(*hull, points) == Approx(error).epsilon(1e-3));
  // A cap that 128 discs of equal area leave is 1/64 high; a greedy choice comes within twice.
  CHECK(error < 2.0 / 64.0);
  CHECK(hull->volume() > 0.94 * 4.0 / 3.0 * std::numbers::pi);
  for (const Vec3& corner : hull->points()) {
    CHECK(std::find(points.begin(), points.end(), corner) != points.end());
  }
  // A hull that needs no simplification is unchanged, to the bit.
  const std::vector<Vec3> few = sphere(100);
  const auto same = ConvexHull::simplify(few).hull;
  const auto made = ConvexHull::make(few);
  CHECK(std::equal(same->arms().begin(), same->arms().end(), made->arms().begin(),
                   made->arms().end()));
}

TEST_CASE("hull: of points in a plane a thin plate is made", "[hull]") {
  const std::vector<Vec3> points{{0.0, 0.0, 2.0}, {3.0, 0.0, 2.0}, {0.0, 4.0, 2.0}};
  const auto [hull, error] = ConvexHull::simplify(points);
  CHECK(error == Approx(0.5e-3 * 4.0));
  CHECK(hull->volume() == Approx(6.0 * 2.0 * error));
  CHECK(hull->centre().isApprox(Vec3(1.0, 4.0 / 3.0, 2.0), 1e-9));
  CHECK(
      refusal([] {
        ConvexHull::simplify(std::vector<Vec3>{{0.0, 0.0, 0.0}, {1.0, 1.0, 1.0}, {2.0, 2.0, 2.0}});
      }).find("on a line") != std::string::npos);
}

}  // namespace
}  // namespace collision_test
