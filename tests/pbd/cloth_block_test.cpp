// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/pbd/cloth_block.h"

#include <limits>

#include "support/bodies.h"
#include "support/catch.h"
#include "support/forged.h"
#include "support/targets.h"

namespace cloth_block_test {

using namespace tandem::pbd;
using namespace tandem::testing;

namespace {

constexpr double kStep = 1.0 / 60.0;

BodyId particle(World& world, const Vec3& at, double mass = 0.01) {
  return world.add_body({.pose = {.position = at},
                         .mass = mass,
                         .inertia = 1e-4 * Mat3::Identity(),
                         .locks = {.angular = {true, true, true}}});
}

/// A strand of six on a static body, with one row of each other kind.
struct Line {
  World world;
  ClothBlock* cloth = nullptr;
  std::vector<BodyId> points;
  BodyId hook;
  ClothRowId strand, tether, bend, hold;
  Solver solver;

  Line() {
    cloth = &world.add_block<ClothBlock>();
    hook = world.add_body({.type = BodyType::Static});
    for (int i = 0; i < 6; ++i) points.push_back(particle(world, Vec3(0.1 * i, 0.0, 0.0)));
    strand = cloth->add(world, StrandDef{.points = points});
    tether = cloth->add(world, ClothTetherDef{.a = points[0], .b = points[5], .length = 0.5});
    bend = cloth->add(world, MeanDef{.points = {points[1], points[2], points[3]},
                                     .weights = {1.0, -2.0, 1.0},
                                     .compliance = 1e-3});
    hold = cloth->add(world, AttachmentDef{.particle = points[0], .host = hook});
  }
  void steps(int count) {
    for (int i = 0; i < count; ++i) solver.step(world, kStep);
  }
};

}  // namespace

TEST_CASE("cloth block: rows go with their bodies or by id, and the others hold", "[pbd][unit]") {
  Line line;
  line.steps(30);
  CHECK(line.cloth->report().rows == 5 + 3);
  line.cloth->remove(line.bend);
  CHECK_FALSE(line.cloth->contains(line.bend));
  CHECK(names(refusal([&] { line.cloth->remove(line.bend); }), "id", "", "of a row of this block"));
  // Cut at the third: two on the hook, three that fall as one.
  line.world.remove_body(line.points[2]);
  CHECK(line.cloth->contains(line.strand));
  CHECK(line.cloth->contains(line.tether));
  CHECK(line.cloth->report().rows == 1 + 2 + 2);
  line.cloth->remove(line.tether);
  line.steps(60);
  const auto apart = [&](int a, int b) {
    return (line.world.pose(line.points[static_cast<std::size_t>(a)]).position -
            line.world.pose(line.points[static_cast<std::size_t>(b)]).position)
        .norm();
  };
  CHECK(apart(0, 1) == Approx(0.1).epsilon(1e-3));
  CHECK(apart(3, 4) == Approx(0.1).epsilon(1e-3));
  CHECK(line.world.pose(line.points[4]).position.z() < -3.0);
  CHECK(line.world.pose(line.points[0]).position.norm() < 1e-6);
}

TEST_CASE("cloth block: a copy keeps its rows where the original changes", "[pbd][unit]") {
  Line line;
  Line same;
  REQUIRE(same.cloth->assign(*line.cloth));
  line.cloth->remove(line.tether);
  CHECK(same.cloth->contains(line.tether));
  CHECK(same.cloth->report().rows == line.cloth->report().rows + 1);
}

TEST_CASE("cloth block: more sweeps leave less, and none or too many are refused", "[pbd][unit]") {
  double left[2] = {};
  for (const int sweeps : {1, 20}) {
    Line line;
    line.cloth->set_sweeps(sweeps);
    // A second strand across the first pulls at it.
    std::vector<BodyId> cross = {line.points[5], particle(line.world, Vec3(0.5, 0.2, 0.0), 1.0)};
    line.cloth->add(line.world, StrandDef{.points = cross});
    line.steps(20);
    left[sweeps == 1 ? 0 : 1] = line.cloth->report().residual;
  }
  CHECK(left[1] < 0.5 * left[0]);
  Line line;
  CHECK(names(refusal([&] { line.cloth->set_sweeps(0); }), "sweeps", "0", "from 1"));
}

TEST_CASE("cloth block: a correction drags the rest along and never becomes velocity",
          "[pbd][consensus]") {
  World world({.gravity = Vec3::Zero()});
  ClothBlock& cloth = world.add_block<ClothBlock>();
  std::vector<BodyId> points;
  for (int i = 0; i < 4; ++i) points.push_back(particle(world, Vec3(0.1 * i, 0.0, 0.0)));
  cloth.add(world, StrandDef{.points = points});
  const BodyId handle = particle(world, Vec3(0.05, 0.0, 0.0), 1e-4);
  cloth.add(world, MeanDef{.points = {handle, points[0], points[1]},
                           .weights = {-1.0, 0.5, 0.5},
                           .leads = true});
  FixedTargets source;
  world.set_target_source(&source);
  Solver solver({.sleep_after = 0.0});
  const Pose aim{.position = Vec3(0.05, 0.03, 0.02)};
  for (int i = 0; i < 120; ++i) {
    source.targets = {{.body = handle, .pose = aim, .share = 0.5}};
    solver.step(world, kStep);
  }
  CHECK((world.pose(handle).position - aim.position).norm() < 1e-4);
  const Vec3 mean = 0.5 * (world.pose(points[0]).position + world.pose(points[1]).position);
  CHECK((mean - aim.position).norm() < 1e-4);
  for (const BodyId point : points) CHECK(world.twist(point).linear.norm() < 1e-3);
}

TEST_CASE("cloth block: no snapshot that somebody made up breaks it", "[pbd][input]") {
  Line line;
  line.steps(10);
  const auto bytes = line.world.snapshot();
  int taken = 0, refused_count = 0;
  for (const double value : {std::numeric_limits<double>::quiet_NaN(), 1e300, -1.0, 0.0}) {
    for (std::size_t at = 29; at + 8 + kCheckBytes < bytes.size(); at += 3) {
      std::vector<std::byte> with;
      ByteWriter(with).f64(value);
      bool refused = false;
      // Its result for huge but finite numbers is unspecified: it does not crash.
      const bool fine = survives(line.world, forged(bytes, at, with), refused);
      if (!std::isfinite(value)) CHECK(fine);
      ++(refused ? refused_count : taken);
      line.world.restore(bytes);
    }
  }
  CHECK(refused_count > 100);
  CHECK(taken > 100);
}

TEST_CASE("cloth block: invalid definitions are refused by name", "[pbd][input]") {
  Line line;
  ClothBlock& cloth = *line.cloth;
  const auto refused = [&](const auto& def) {
    return refusal([&] { cloth.add(line.world, def); });
  };
  const std::vector<BodyId> two = {line.points[0], line.points[1]};
  CHECK(
      names(refused(StrandDef{.points = {line.points[0]}}), "number of points", "1", "at least 2"));
  CHECK(names(refused(StrandDef{.points = two, .lengths = {1.0, 1.0}}), "number of lengths", "2",
              "one less"));
  CHECK(names(refused(StrandDef{.points = two, .lengths = {-1.0}}), "lengths", "-1", "> 0"));
  CHECK(names(refused(StrandDef{.points = two, .compliance = -1.0}), "compliance", "-1", ">= 0"));
  CHECK(names(refused(StrandDef{.points = {line.hook, line.points[1]}}), "points", "",
              "hold no particle"));
  CHECK(names(refused(ClothTetherDef{.a = two[0], .b = two[0], .length = 1.0}), "b", "",
              "another body"));
  CHECK(names(refused(ClothTetherDef{.a = two[0], .b = two[1]}), "length", "0", "> 0"));
  CHECK(names(refused(MeanDef{.points = two, .weights = {1.0}}), "number of weights", "1",
              "that of points"));
  CHECK(names(refused(MeanDef{.points = two, .weights = {1.0, 1.0}}), "sum of weights", "2", "0"));
  CHECK(names(refused(AttachmentDef{.particle = two[0], .host = line.hook}), "particle", "",
              "nothing holds"));
  CHECK(names(refused(AttachmentDef{.particle = two[1], .host = two[0]}), "host", "", "no point"));
  CHECK(cloth.report().rows == 5 + 3);
}

}  // namespace cloth_block_test
