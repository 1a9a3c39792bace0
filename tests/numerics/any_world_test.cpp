// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// A scene of benchmarks/everyday is the same scene in every engine that this build has.
#include "everyday/any_world.h"

#include "peers/engines.h"
#include "support/catch.h"

namespace any_world_test {

using namespace tandem;
using everyday::AnyWorld;
using everyday::make_world;

namespace {

/// A wedge whose centre of mass and principal axes are not those of its frame.
collision::Shape wedge() {
  return collision::ConvexHull::make(std::vector<Vec3>{{0.0, 0.0, 0.0},
                                                       {0.5, 0.0, 0.0},
                                                       {0.0, 0.3, 0.0},
                                                       {0.5, 0.3, 0.0},
                                                       {0.0, 0.0, 0.2},
                                                       {0.0, 0.3, 0.4}});
}

SolidDef thrown() {
  SolidDef def;
  def.pose = {.position = Vec3(1.0, -2.0, 3.0),
              .orientation = Quat(Eigen::AngleAxisd(0.7, Vec3(1.0, 2.0, -1.0).normalized()))};
  def.twist = {.linear = Vec3(1.0, 2.0, 3.0), .angular = Vec3(3.0, -4.0, 5.0)};
  return def;
}

double angle(const Pose& a, const Pose& b) { return a.orientation.angularDistance(b.orientation); }

}  // namespace

TEST_CASE("any world: a skew hull has its pose, its energy and its path in all engines",
          "[everyday]") {
  const auto ours = make_world({});
  const BodyId body = ours->add(wedge(), thrown());
  const double kinetic = ours->kinetic_energy();
  const double mechanical = ours->mechanical_energy();
  ours->step(1.0 / 60.0);
  for (const auto& [name, make] : bench::built_engines()) {
    INFO(name);
    // Of its axes and centre of mass adapters are told by numbers, in single precision.
    const double share = name == "tandem" ? 1e-9 : 1e-5;
    const auto theirs = make_world(make);
    BodyId same;
    try {
      same = theirs->add(wedge(), thrown());
      CHECK(theirs->kinetic_energy() == Approx(kinetic).epsilon(share));
    } catch (const std::invalid_argument& error) {
      WARN(name << " has no hulls: " << error.what());
      continue;
    }
    CHECK(theirs->mechanical_energy() == Approx(mechanical).epsilon(share));
    CHECK((theirs->pose(same).position - thrown().pose.position).norm() < share * 4.0);
    CHECK(angle(theirs->pose(same), thrown().pose) < share * 10.0);
    theirs->step(1.0 / 60.0);
    // Jolt knows no gyroscopic torque, and substeps of gravity differ.
    const double off = name == "tandem" ? 1e-9 : 3e-3;
    CHECK((theirs->pose(same).position - ours->pose(body).position).norm() < off);
    CHECK(angle(theirs->pose(same), ours->pose(body)) < off);
  }
}

TEST_CASE("any world: round and many-sided bodies rest as high as they are thick, and sleep",
          "[everyday]") {
  for (const auto& [name, make] : bench::built_engines()) {
    for (const bool sleeping : {true, false}) {
      INFO(name << (sleeping ? ", sleeping" : ", never asleep"));
      const auto world = make_world(make, {.sleeping = sleeping});
      world->add(Box{5.0, 5.0, 1.0},
                 {.type = BodyType::Static, .pose = {.position = Vec3(0.0, 0.0, -1.0)}});
      BodyId upright, cut;
      try {
        upright = world->add(Cylinder{0.2, 0.3}, {.pose = {.position = Vec3(0.0, 0.0, 0.32)}});
        cut = world->add(wedge(), {.pose = {.position = Vec3(1.0, 0.0, 0.02)}});
        for (int i = 0; i < 300; ++i) world->step(1.0 / 60.0);
      } catch (const std::invalid_argument& error) {
        WARN(name << " has no such shape: " << error.what());
        continue;
      }
      CHECK(world->pose(upright).position.z() == Approx(0.3).margin(0.025));
      CHECK(world->pose(cut).position.z() == Approx(0.0).margin(0.045));
      CHECK(world->awake(upright) == !sleeping);
      CHECK(world->awake(cut) == !sleeping);
    }
  }
}

TEST_CASE("any world: a bat on its hinge keeps its axis", "[everyday]") {
  for (const auto& [name, make] : bench::built_engines()) {
    INFO(name);
    const auto world = make_world(make, {.gravity = Vec3::Zero()});
    const BodyId bat =
        world->add(Box{0.6, 0.03, 0.03},
                   {.pose = {.position = Vec3(0.6, 0.0, 0.0)},
                    .twist = {.linear = Vec3(0.0, 3.0, 0.0), .angular = Vec3(0.0, 0.0, 5.0)}});
    world->add_hinge(bat, Vec3::Zero(), Vec3::UnitZ());
    for (int i = 0; i < 60; ++i) world->step(1.0 / 60.0);
    const Pose pose = world->pose(bat);
    CHECK(pose.position.norm() == Approx(0.6).margin(0.02));
    CHECK((pose.orientation * Vec3::UnitZ()).z() == Approx(1.0).margin(1e-3));
    // On Jolt's hinge an eighth is lost in that second.
    CHECK(world->twist(bat).angular.z() == Approx(5.0).margin(0.8));
  }
}

}  // namespace any_world_test
