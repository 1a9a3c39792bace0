// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "support/catch.h"
#include "support/targets.h"
#include "tandem/pbd/distance_joint.h"
#include "tandem/pbd/joint.h"
#include "tandem/pbd/pose_target.h"

namespace pose_target_energy_test {

using namespace tandem::pbd;
using namespace tandem::testing;

namespace {

/// One of two peers with the same three bodies, the first two of them jointed, moving differently.
/// Cubes: the spin energy of a long body depends on how it lies, so that agreeing on a spin while
/// the orientations differ can cost either side energy.
struct Peer {
  World world{weightless()};
  FixedTargets source;
  std::vector<BodyId> bodies;

  explicit Peer(double sign) {
    const Vec3 half(0.2, 0.2, 0.2);
    auto& joints = world.add_block<JointBlock>();
    for (int i = 0; i < 3; ++i) {
      const Vec3 turned = i < 2 ? Vec3(0.0, 0.0, 0.0) : sign * Vec3(0.3, -0.8, 0.5);
      BodyDef def = box_def(1.0 + i, half, Vec3(2.0 * i, 0.0, 0.0), turn(turned));
      // Only the third is free to spin by itself; the pair starts with one common velocity.
      def.twist.linear = i < 2 ? sign * Vec3(0.5, 1.0, -0.4) : sign * Vec3(-0.7, 0.2, 0.9);
      if (i == 2) def.twist.angular = sign * Vec3(2.0, 1.0, -3.0) + Vec3(0.5, 0.0, 1.0);
      bodies.push_back(world.add_body(def));
    }
    joints.add(world, ball_joint_at(world, bodies[0], bodies[1], Vec3(1.0, 0.1, 0.0)));
    world.set_target_source(&source);
  }
  /// The other one's present state, without delay.
  void see(const Peer& other, double share) {
    source.targets.clear();
    for (const BodyId id : bodies) {
      source.targets.push_back({.body = id,
                                .pose = other.world.pose(id),
                                .twist = other.world.twist(id),
                                .share = share});
    }
  }
};

}  // namespace

TEST_CASE("pose_target energy: in a symmetric exchange without delay it never rises",
          "[pbd][consensus][analytic]") {
  for (const int substeps : {1, 4, 10}) {
    for (const double share : {0.05, 0.3, 0.5}) {
      Peer one(1.0);
      Peer two(-1.0);
      Solver solver({.substeps = substeps});
      for (int k = 0; k < 60; ++k) {
        one.see(two, share);
        two.see(one, share);
        const double before = one.world.kinetic_energy() + two.world.kinetic_energy();
        const double by_one = solver.step(one.world, kFrame).energy.velocity_agreement;
        const double by_two = solver.step(two.world, kFrame).energy.velocity_agreement;
        const double after = one.world.kinetic_energy() + two.world.kinetic_energy();
        INFO("share " << share << " step " << k << ": " << before << " -> " << after);
        REQUIRE(by_one + by_two <= 1e-12 * before);
        REQUIRE(after <= before * (1.0 + 1e-9));
      }
      // They do agree, or the claim would be empty.
      CHECK((one.world.twist(one.bodies[2]).linear - two.world.twist(two.bodies[2]).linear).norm() <
            0.2);
    }
  }
}

TEST_CASE("pose_target energy: the average of two velocities has the textbook's energy",
          "[pbd][consensus][analytic]") {
  World world(weightless());
  FixedTargets source;
  BodyDef def = box_def(2.0, Vec3(0.2, 0.2, 0.2), Vec3::Zero());
  def.twist.linear = Vec3(3.0, 0.0, 0.0);
  const BodyId body = world.add_body(def);
  source.targets.push_back({.body = body, .pose = def.pose, .share = 0.25});
  source.targets[0].twist.linear = Vec3(-1.0, 2.0, 0.0);
  world.set_target_source(&source);
  Solver solver;
  const StepReport& report = solver.step(world, kFrame);
  // 0.75 (3, 0) + 0.25 (-1, 2) = (2, 0.5).
  const double change = 0.5 * 2.0 * (4.0 + 0.25 - 9.0);
  CHECK(report.energy.velocity_agreement == Approx(change).epsilon(1e-12));
  CHECK(report.energy.displacement == 0.0);
  CHECK(report.targets == 1);
}

TEST_CASE("pose_target energy: the potential part is m g dz of the displacement",
          "[pbd][consensus][analytic]") {
  for (const int substeps : {1, 4, 10}) {
    World world;
    FixedTargets source;
    BodyDef def = box_def(2.0, Vec3(0.2, 0.2, 0.2), Vec3(0.0, 0.0, 5.0));
    def.gravity_scale = 0.5;
    const BodyId body = world.add_body(def);
    source.targets.push_back({.body = body, .share = 0.25});
    source.targets[0].pose.position = Vec3(0.3, 0.0, 5.4);
    world.set_target_source(&source);
    Solver solver({.substeps = substeps});
    const StepReport& report = solver.step(world, kFrame);
    const double lifted = world.correction(body).translation.z();
    CHECK(lifted == Approx(0.25 * 0.4).epsilon(1e-12));  // both fall alike, so the gap is 0.4 m
    CHECK(report.energy.potential == Approx(2.0 * 0.5 * kGravity * lifted).epsilon(1e-12));
    CHECK(report.energy.velocity_agreement == 0.0);
  }
}

TEST_CASE("pose_target energy: displacement adds none for any turn and spin",
          "[pbd][consensus][analytic]") {
  for (const int substeps : {1, 4, 10}) {
    World world(weightless());
    FixedTargets source;
    BodyDef def = box_def(2.0, Vec3(0.1, 0.2, 0.5), Vec3::Zero());
    def.twist = {Vec3(1.0, 0.0, 0.0), Vec3(3.0, 2.0, -1.0)};
    const BodyId body = world.add_body(def);
    source.targets.push_back({.body = body, .share = 0.5});
    Solver solver({.substeps = substeps});
    // A target that differs in pose alone, so that nothing else changes the energy.
    source.targets[0].pose = {Vec3(0.1, 0.2, 0.3), turn(Vec3(0.4, -0.3, 0.2))};
    source.targets[0].twist = def.twist;
    const double before = world.kinetic_energy();
    world.set_target_source(&source);
    const StepReport& report = solver.step(world, kFrame);
    INFO("displacement " << report.energy.displacement << " J of " << before << " J");
    CHECK(std::abs(report.energy.displacement) <= 1e-12 * before);
    CHECK(world.twist(body).linear == Vec3(1.0, 0.0, 0.0));
    // A body that spins and is turned has another energy at the same spin; the books balance.
    const double booked = report.energy.potential + report.energy.velocity_agreement;
    CHECK(world.kinetic_energy() - before == Approx(booked).margin(1e-9 * before));
  }
}

}  // namespace pose_target_energy_test
