// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// E7: small objects that fall in a column keep their order and do not overlap.
#include <algorithm>
#include <cmath>
#include <vector>

#include "everyday/any_world.h"
#include "everyday/ground.h"
#include "everyday/group.h"

namespace tandem::everyday {
namespace {

enum class Thing { Cube, Ball, Cylinder };

std::string name_of(Thing thing) {
  switch (thing) {
    case Thing::Cube:
      return "column of 12 cubes";
    case Thing::Ball:
      return "column of 12 balls";
    case Thing::Cylinder:
      return "column of 12 cylinders";
  }
  return "";
}

collision::Shape shape_of(Thing thing, double size) {
  switch (thing) {
    case Thing::Cube:
      return Box{Vec3::Constant(0.5 * size)};
    case Thing::Ball:
      return Sphere{0.5 * size};
    case Thing::Cylinder:
      return Cylinder{0.5 * size, 0.5 * size};
  }
  return Sphere{};
}

/// Gaps of half an edge; the first is higher by `phase` of a step's distance at impact.
void column(Tally& tally, const bench::MakeEngine& peer, Thing thing, double size, double phase,
            double bound) {
  const auto world = make_world(peer);
  AnyWorld& scene = *world;
  scene.add(Box{1.0, 1.0, 0.5},
            {.type = BodyType::Static, .pose = {.position = Vec3(0.0, 0.0, -0.5)}});
  const double higher = phase * kFrame * std::sqrt(kGravity * size);
  std::vector<BodyId> bodies;
  for (int i = 0; i < 12; ++i) {
    SolidDef def{.pose = {.position = Vec3(0.0, 0.0, size * (1.0 + 1.5 * i) + higher)}};
    bodies.push_back(scene.add(shape_of(thing, size), def));
  }
  double overlap = 0.0;
  bool order = true;
  for (int i = 0; i < 240; ++i) {
    scene.step(kFrame);
    Vec3 below(0.0, 0.0, -0.5 * size);
    for (const BodyId body : bodies) {
      const Vec3 place = scene.pose(body).position;
      const Vec3 up = place - below;
      below = place;
      // Only stacked neighbours: those that fell off do not count.
      if (std::hypot(up.x(), up.y()) > 0.25 * size) continue;
      const double gap = thing == Thing::Ball && up.z() > 0.0 ? up.norm() : up.z();
      overlap = std::max(overlap, 1.0 - gap / size);
      order = order && up.z() > 0.0;
    }
  }
  const std::string which = told({{"size", size}, {"phase", phase}});
  tally.at_most("overlap", overlap, bound, "edges", which);
  tally.failed("order changed", !order, 0, which);
}

}  // namespace

std::vector<Group> column_groups(const bench::MakeEngine& peer) {
  std::vector<Group> groups;
  for (const Thing thing : {Thing::Cube, Thing::Ball, Thing::Cylinder}) {
    for (const auto& [size, bound] : {std::pair{0.016, 0.3}, {0.03, 0.2}, {0.05, 0.1}}) {
      const std::string edge = std::to_string(static_cast<int>(std::lround(1e3 * size)));
      groups.push_back({"E7", name_of(thing) + " of " + edge + " mm", "box",
                        [=](Tally& tally, Extent extent) {
                          const int phases = extent == Extent::Full ? 12 : 2;
                          for (int i = 0; i < phases; ++i) {
                            column(tally, peer, thing, size, static_cast<double>(i) / phases,
                                   bound);
                          }
                        },
                        true});
    }
  }
  return groups;
}

}  // namespace tandem::everyday
