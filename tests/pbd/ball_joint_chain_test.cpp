// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "support/bodies.h"
#include "support/catch.h"
#include "tandem/pbd/joint.h"

namespace ball_joint_chain_test {

using namespace tandem::pbd;
using namespace tandem::testing;

namespace {

/// 20 links of 0.2 m, level, let go: the end mass swings down on a chain of 4 m.
struct Chain {
  static constexpr int kLinks = 20;
  static constexpr double kLink = 0.2;  ///< m
  World world;
  std::vector<BodyId> links;
  double end_mass;

  explicit Chain(double mass) : end_mass(mass) {
    auto& joints = world.add_block<JointBlock>();
    BodyId before;
    for (int i = 0; i < kLinks; ++i) {
      const Vec3 centre(kLink * (i + 0.5), 0.0, 0.0);
      BodyDef def = box_def(1.0, Vec3(0.5 * kLink, 0.03, 0.03), centre);
      if (i + 1 == kLinks) def = ball_def(end_mass, 0.1, centre);
      links.push_back(world.add_body(def));
      joints.add(world, ball_joint_at(world, before, links.back(), Vec3(kLink * i, 0.0, 0.0)));
      before = links.back();
    }
  }
  /// How much further the end is from the hook than the chain is long, as a part of its 4 m.
  double stretch() const {
    const double length = kLink * (kLinks - 0.5);
    return (world.pose(links.back()).position.norm() - length) / (kLink * kLinks);
  }
  /// J, between level and hanging.
  double swing_energy() const {
    return kGravity *
           (end_mass * kLink * (kLinks - 0.5) + (kLinks - 1) * 1.0 * kLink * 0.5 * (kLinks - 1));
  }
};

struct Swing {
  double stretch = 0.0;
  double gained = 0.0;  ///< largest mechanical energy over that of the start, J
  bool finite = true;
};

Swing swing(Chain& chain, int substeps) {
  Solver solver({.substeps = substeps, .sleep_after = 0.0});
  Swing result;
  const double start = chain.world.mechanical_energy();
  for (int i = 0; i < 300; ++i) {
    result.finite = result.finite && solver.step(chain.world, kFrame).status == StepStatus::Ok;
    result.stretch = std::max(result.stretch, chain.stretch());
    result.gained = std::max(result.gained, chain.world.mechanical_energy() - start);
  }
  return result;
}

}  // namespace

TEST_CASE("ball_joint chain: 20 even links stretch by less than 0.13 % and gain no energy",
          "[pbd][ball_joint][regression][long]") {
  Chain chain(1.0);
  const Swing result = swing(chain, 10);
  INFO("stretch " << 100.0 * result.stretch << " %, gained " << result.gained << " J of "
                  << chain.swing_energy());
  CHECK(result.finite);
  CHECK(result.stretch < 0.0013);
  CHECK(result.gained < 0.01 * chain.swing_energy());
}

TEST_CASE("ball_joint chain: with a 100 times heavier end the stretch stays within its bound",
          "[pbd][ball_joint][regression][long]") {
  struct Case {
    int substeps;
    double bound;
  };
  // Stretch of a scalar sweep with the same number of substeps, as the upper limit.
  for (const Case& c : {Case{10, 0.0144}, Case{20, 0.0035}}) {
    Chain chain(100.0);
    const Swing result = swing(chain, c.substeps);
    INFO(c.substeps << " substeps: stretch " << 100.0 * result.stretch << " %, gained "
                    << result.gained << " J of " << chain.swing_energy());
    CHECK(result.finite);
    CHECK(result.stretch < c.bound);
    CHECK(result.gained < 0.01 * chain.swing_energy());
  }
}

TEST_CASE("ball_joint chain: with 5 substeps a 100 times heavier end is still stable",
          "[pbd][ball_joint][regression]") {
  Chain chain(100.0);
  const Swing result = swing(chain, 5);
  INFO("stretch " << 100.0 * result.stretch << " %, gained " << result.gained << " J of "
                  << chain.swing_energy());
  CHECK(result.finite);
  CHECK(result.stretch < 0.056);
  CHECK(result.gained < 0.01 * chain.swing_energy());
}

/// A square lattice of boxes that hangs on its first row. One cone that nothing reaches, or none.
std::vector<Vec3> lattice_after(double seconds, bool with_cone, double compliance,
                                double break_force) {
  constexpr int kSize = 3;
  World world;
  auto& joints = world.add_block<JointBlock>();
  std::vector<BodyId> bodies;
  const auto join = [&](std::size_t before, const Vec3& anchor) {
    const BodyId a = bodies[bodies.size() - 1 - before];
    BallJointDef def = ball_joint_at(world, a, bodies.back(), anchor);
    def.compliance = compliance;
    if (with_cone && joints.size() == 5) def.cone = 3.0;
    if (joints.size() == 7) def.break_force = break_force;
    joints.add(world, def);
  };
  for (int row = 0; row < kSize; ++row) {
    for (int column = 0; column < kSize; ++column) {
      BodyDef def = box_def(1.0, Vec3(0.4, 0.3, 0.2), Vec3(column, row, 0.0));
      if (row == 0) def.type = BodyType::Static;
      bodies.push_back(world.add_body(def));
      if (column > 0) join(1, Vec3(column - 0.5, row, 0.0));
      if (row > 0) join(kSize, Vec3(column, row - 0.5, 0.0));
    }
  }
  Solver solver({.joint_iterations = 100, .joint_tolerance = 1e-13, .sleep_after = 0.0});
  run(world, solver, seconds);
  std::vector<Vec3> places;
  for (const BodyId body : bodies) places.push_back(world.pose(body).position);
  return places;
}

TEST_CASE("ball joint: parts of them alone move as parts that another row makes general",
          "[pbd][joint][unit]") {
  for (const double compliance : {0.0, 1e-4}) {
    for (const double break_force : {0.0, 8.0}) {
      const auto alone = lattice_after(0.4, false, compliance, break_force);
      const auto general = lattice_after(0.4, true, compliance, break_force);
      double off = 0.0;
      for (std::size_t i = 0; i < alone.size(); ++i) {
        off = std::max(off, (alone[i] - general[i]).norm());
      }
      INFO("compliance " << compliance << ", breaks at " << break_force << " N: " << off << " m");
      CHECK(alone.back().z() < -0.1);
      CHECK(off < 1e-8);
    }
  }
}

}  // namespace ball_joint_chain_test
