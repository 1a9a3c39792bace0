// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <algorithm>
#include <array>

#include "fixture.h"

namespace box_sat_test {

using namespace tandem::collision;
using namespace tandem::collision::testing;

namespace {

/// Convex polytope by its corners, face normals and edge directions.
struct Polytope {
  std::vector<Vec3> corners, faces, edges;
  double radius = 0.0;
};

Polytope box(const Vec3& half, const Pose& pose) {
  Polytope p;
  for (int i = 0; i < 8; ++i) {
    p.corners.push_back(pose.to_world(half.cwiseProduct(
        Vec3((i & 1) != 0 ? 1 : -1, (i & 2) != 0 ? 1 : -1, (i & 4) != 0 ? 1 : -1))));
  }
  for (int i = 0; i < 3; ++i) p.faces.push_back(pose.orientation * Vec3::Unit(i));
  p.edges = p.faces;
  return p;
}

Polytope capsule(const Capsule& c, const Pose& pose) {
  return {{pose.to_world(Vec3(0, 0, c.half_height)), pose.to_world(Vec3(0, 0, -c.half_height))},
          {},
          {pose.orientation * Vec3::UnitZ()},
          c.radius};
}

double separation(const Polytope& a, const Polytope& b, const Vec3& n) {
  double most_a = -HUGE_VAL;
  double least_b = HUGE_VAL;
  for (const Vec3& p : a.corners) most_a = std::max(most_a, n.dot(p));
  for (const Vec3& p : b.corners) least_b = std::min(least_b, n.dot(p));
  return least_b - most_a - a.radius - b.radius;
}

/// All face normals and edge products, both signs.
std::vector<Vec3> axes_of(const Polytope& a, const Polytope& b) {
  std::vector<Vec3> axes;
  const auto add = [&](const Vec3& axis) {
    if (axis.norm() < 1e-6) return;
    axes.push_back(axis.normalized());
    axes.push_back(-axis.normalized());
  };
  for (const Vec3& n : a.faces) add(n);
  for (const Vec3& n : b.faces) add(n);
  for (const Vec3& u : a.edges) {
    for (const Vec3& v : b.edges) add(u.cross(v));
  }
  return axes;
}

/// Largest separation over all of them: the signed distance where the polytopes overlap, a lower
/// bound of it where they do not.
double best_separation(const Polytope& a, const Polytope& b) {
  double best = -HUGE_VAL;
  for (const Vec3& axis : axes_of(a, b)) best = std::max(best, separation(a, b, axis));
  return best;
}

/// How far b has to go along n until the two, which overlap, are apart.
double way_out(const Polytope& a, const Polytope& b, const Vec3& n) {
  double shortest = HUGE_VAL;
  for (const Vec3& axis : axes_of(a, b)) {
    const double along = axis.dot(n);
    if (along > 1e-6) shortest = std::min(shortest, -separation(a, b, axis) / along);
  }
  return shortest;
}

}  // namespace

TEST_CASE("box pairs: depth and normal agree with a search over all 15 axes",
          "[collision][analytic]") {
  Random random(2026);
  int overlapping = 0;
  int edges = 0;
  for (int k = 0; k < 6000; ++k) {
    const Vec3 ha = random.vec_in(0.1, 0.6);
    const Vec3 hb = random.vec_in(0.1, 0.6);
    const Pose pa{random.vec(0.5), random.quat()};
    const Pose pb{random.vec(0.5), random.quat()};
    Fixture f;
    f.add(Box{ha}, pa);
    f.add(Box{hb}, pb);
    f.collect();
    const Polytope a = box(ha, pa);
    const Polytope b = box(hb, pb);
    const double truth = best_separation(a, b);
    INFO("case " << k << " true separation " << truth);
    if (truth >= 0.02) {
      CHECK(f.manifolds.empty());
      continue;
    }
    if (truth >= 0.0) {  // speculative: may be left out where the features pass by each other
      for (const Manifold& m : f.manifolds) CHECK(f.deepest(m) >= truth - 1e-3);
      continue;
    }
    ++overlapping;
    REQUIRE(f.manifolds.size() == 1);
    const Manifold& m = f.manifolds[0];
    REQUIRE(m.count >= 1);
    edges += m.count == 1 ? 1 : 0;
    CHECK(m.normal.norm() == Approx(1.0).epsilon(1e-9));
    // A face may be preferred where the way out along it is at most about 5 % longer (the library's
    // rule and ours). How far that is: until some axis separates.
    const double way = way_out(a, b, m.normal);
    CHECK(way >= -truth - 1e-9);
    CHECK(way <= -truth * 1.11 + 1e-3);
    // The deepest point carries the depth: no more than the normal separates, and at least the true
    // depth where a face was preferred (its deepest corner may hang over the face's border).
    CHECK(f.deepest(m) >= separation(a, b, m.normal) - 1e-9);
    CHECK(f.deepest(m) <= 0.97 * truth + 1e-3);
  }
  CHECK(overlapping > 3000);
  CHECK(edges > 100);
}

TEST_CASE("capsule and box: depth and normal agree with a search over all axes",
          "[collision][analytic]") {
  Random random(77);
  int overlapping = 0;
  for (int k = 0; k < 3000; ++k) {
    const Capsule shape{random.in(0.05, 0.2), random.in(0.1, 0.5)};
    const Vec3 half = random.vec_in(0.1, 0.6);
    const Pose pa{random.vec(0.4), random.quat()};
    const Pose pb{random.vec(0.4), random.quat()};
    Fixture f;
    f.add(shape, pa);
    f.add(Box{half}, pb);
    f.collect();
    const Polytope a = capsule(shape, pa);
    const Polytope b = box(half, pb);
    const double truth = best_separation(a, b);
    if (truth > -shape.radius - 1e-6) continue;  // the axis is outside: corners count too
    ++overlapping;
    INFO("case " << k << " true separation " << truth);
    REQUIRE(f.manifolds.size() == 1);
    const Manifold& m = f.manifolds[0];
    CHECK(separation(a, b, m.normal) == Approx(truth).margin(1e-6));
    CHECK(f.deepest(m) == Approx(truth).margin(0.021 * shape.radius + 1e-6));
  }
  CHECK(overlapping > 800);
}

TEST_CASE("capsule and box: the gap of a capsule outside is the distance, by brute force",
          "[collision][analytic]") {
  Random random(78);
  int compared = 0;
  for (int k = 0; k < 1500; ++k) {
    const Capsule shape{0.3, 0.4};
    const Vec3 half(0.3, 0.4, 0.5);
    const Pose pa{random.vec(0.9), random.quat()};
    Fixture f;
    f.add(shape, pa);
    f.fixed(Box{half});
    f.collect();
    // Distance from a point to the box is convex along the segment: golden-section search.
    const auto distance = [&](double s) {
      const Vec3 p = pa.to_world(Vec3(0, 0, s));
      return (p - p.cwiseMax(-half).cwiseMin(half)).norm();
    };
    double low = -shape.half_height;
    double high = shape.half_height;
    for (int i = 0; i < 200; ++i) {
      const double third = (high - low) / 3.0;
      if (distance(low + third) < distance(high - third)) {
        high -= third;
      } else {
        low += third;
      }
    }
    const double core = distance(0.5 * (low + high));
    if (core < 1e-3) continue;
    const double truth = core - shape.radius;
    INFO("case " << k << " distance " << truth);
    if (truth > 0.02 + 1e-9) {
      CHECK(f.manifolds.empty());
    } else if (truth < 0.02 - 1e-3) {
      REQUIRE(f.manifolds.size() == 1);
      CHECK(f.deepest(f.manifolds[0]) == Approx(truth).margin(1e-3));
      ++compared;
    }
  }
  CHECK(compared > 300);
}

}  // namespace box_sat_test
