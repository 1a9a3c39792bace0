// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// E2, E3: a dropped hull comes to rest, with random or scanned corners.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "everyday/any_world.h"
#include "everyday/ground.h"
#include "everyday/group.h"
#include "tandem/pbd/random.h"

namespace tandem::everyday {
namespace {

using Points = std::vector<Vec3>;

Vec3 in_ball(pbd::SplitMix64& random) {
  for (;;) {
    const double x = random.uniform(-1.0, 1.0);
    const double y = random.uniform(-1.0, 1.0);
    const double z = random.uniform(-1.0, 1.0);
    const Vec3 point(x, y, z);
    if (point.squaredNorm() <= 1.0) return point;
  }
}

Points random_points(pbd::SplitMix64& random, int count, double size) {
  Points points;
  for (int i = 0; i < count; ++i) points.push_back(0.5 * size * in_ball(random));
  return points;
}

/// A cube of 5 x 5 points per face, each moved by up to `bump` sizes.
Points bumpy_cube(pbd::SplitMix64& random, double size, double bump) {
  Points points;
  for (int i = 0; i < 125; ++i) {
    const int x = i % 5;
    const int y = i / 5 % 5;
    const int z = i / 25;
    if (x % 4 != 0 && y % 4 != 0 && z % 4 != 0) continue;
    points.push_back(size * (0.25 * Vec3(x - 2, y - 2, z - 2) + bump * in_ball(random)));
  }
  return points;
}

/// An upright tin of 24 sides, with points measured to 0.2 mm.
Points scanned_tin(pbd::SplitMix64& random, double size, double error) {
  Points points;
  for (int i = 0; i < 24; ++i) {
    const double turn = 2.0 * std::numbers::pi * i / 24.0;
    for (const double z : {-0.5, 0.5}) {
      points.push_back(size * Vec3(0.35 * std::cos(turn), 0.35 * std::sin(turn), z) +
                       error * in_ball(random));
    }
  }
  return points;
}

/// Three grids of points on each pair of a box's faces.
Points scanned_parcel(pbd::SplitMix64& random, double size, double error) {
  Points points = bumpy_cube(random, 1.0, 0.0);
  for (Vec3& point : points) {
    point = size * point.cwiseProduct(Vec3(1.0, 0.7, 0.4)) + error * in_ball(random);
  }
  return points;
}

/// Drops it by a tenth of its size; checks residual motion and depth.
void check_rest(Tally& tally, const bench::MakeEngine& peer, Ground ground, const Points& points,
                double size, const std::string& which) {
  const auto hull = collision::ConvexHull::make(points);
  const double time = 5.0 * std::max(1.0, std::sqrt(size));
  double lowest = HUGE_VAL;
  for (const Vec3& point : hull->points()) lowest = std::min(lowest, point.z());
  const SolidDef def{.pose = {.position = Vec3(0.0, 0.0, 0.1 * size - lowest)}};
  bool asleep = false;
  {
    const auto world = make_world(peer);
    AnyWorld& scene = *world;
    add_ground(scene, ground, 0.5, 10.0 * size);
    const BodyId body = scene.add(hull, def);
    for (double t = 0.0; t < time && !asleep; t += kFrame) {
      scene.step(kFrame);
      asleep = !scene.awake(body);
    }
  }
  tally.failed("awake", !asleep, 0, which);
  const auto world = make_world(peer, {.sleeping = false});
  AnyWorld& scene = *world;
  add_ground(scene, ground, 0.5, 10.0 * size);
  const BodyId body = scene.add(hull, def);
  double spin = 0.0;
  double deep = 0.0;
  for (double t = 0.0; t < time + 1.0; t += kFrame) {
    scene.step(kFrame);
    if (t < time) continue;
    spin = std::max(spin, scene.twist(body).angular.norm());
    deep = std::max(deep, depth_below(scene.pose(body), hull->points()));
  }
  tally.at_most("spin, sleep off", spin, 1e-3, "rad/s", which);
  tally.at_most("depth", 1e3 * deep, std::max(0.3, size), "mm", which);
}

void random_hulls(Tally& tally, Extent extent, const bench::MakeEngine& peer, Ground ground) {
  const bool full = extent == Extent::Full;
  for (const double size : full ? std::vector{0.02, 0.1, 0.3, 1.0, 10.0} : std::vector{0.3}) {
    for (const int count : full ? std::vector{6, 12, 30, 60, 128} : std::vector{12, 60}) {
      pbd::SplitMix64 random(2);
      for (int i = 0; i < (full ? 20 : 3); ++i) {
        const Points points = random_points(random, count, size);
        check_rest(tally, peer, ground, points, size,
                   told({{"size", size}, {"points", count}, {"hull", i}}));
      }
    }
  }
}

void bumpy_cubes(Tally& tally, Extent extent, const bench::MakeEngine& peer, Ground ground) {
  const bool full = extent == Extent::Full;
  for (const double size : full ? std::vector{0.02, 0.1, 1.0, 10.0} : std::vector{1.0}) {
    for (const double bump : full ? std::vector{1e-5, 1e-4, 3e-4, 1e-3, 1e-2} : std::vector{1e-4}) {
      pbd::SplitMix64 random(3);
      for (int i = 0; i < (full ? 5 : 2); ++i) {
        const Points points = bumpy_cube(random, size, bump);
        check_rest(tally, peer, ground, points, size,
                   told({{"size", size}, {"bump", bump}, {"cube", i}}));
      }
    }
  }
}

void scans(Tally& tally, Extent extent, const bench::MakeEngine& peer, Ground ground) {
  pbd::SplitMix64 random(4);
  for (int i = 0; i < (extent == Extent::Full ? 20 : 2); ++i) {
    check_rest(tally, peer, ground, scanned_tin(random, 0.1, 2e-4), 0.1, told({{"tin", i}}));
    check_rest(tally, peer, ground, scanned_parcel(random, 0.4, 5e-4), 0.4, told({{"parcel", i}}));
  }
}

}  // namespace

std::vector<Group> rest_groups(const bench::MakeEngine& peer) {
  std::vector<Group> groups;
  const auto add = [&](const char* kind, const char* name, auto run) {
    for (const Ground ground : kGrounds) {
      groups.push_back({kind, name, name_of(ground),
                        [=](Tally& tally, Extent extent) { run(tally, extent, peer, ground); },
                        ground == Ground::HalfSpace || ground == Ground::Box});
    }
  };
  add("E2", "hulls of random points", random_hulls);
  add("E3", "bumpy cubes", bumpy_cubes);
  add("E3", "scanned tins and parcels", scans);
  return groups;
}

}  // namespace tandem::everyday
