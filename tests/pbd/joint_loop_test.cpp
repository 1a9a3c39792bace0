// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "joint_fixture.h"
#include "support/catch.h"

namespace joint_loop_test {

using namespace tandem::pbd;
using namespace tandem::testing;

namespace {

enum class Kind { Ball, Hinge, HingeUpright, Fixed, Slider };
enum class Held { Edge, Corner, Nowhere };

constexpr double kRadius = 0.4;  ///< m
constexpr double kMass = 10.0;   ///< kg

/// Balls on a level square lattice of 1 m, each joined to its neighbours half way.
struct Lattice {
  World world;
  JointBlock* joints = nullptr;
  std::vector<BodyId> bodies;
  double swing_energy = 0.0;  ///< J, all its mass falling by its length

  Lattice(int size, Kind kind, Held held, const WorldDef& def = {}, double damping = 0.0)
      : world(def), joints(&world.add_block<JointBlock>()) {
    for (int row = 0; row < size; ++row) {
      for (int column = 0; column < size; ++column) {
        BodyDef ball = ball_def(kMass, kRadius, Vec3(column, row, 0.0));
        ball.linear_damping = ball.angular_damping = damping;
        const bool fixed =
            row == 0 && (held == Held::Edge || (held == Held::Corner && column == 0));
        if (fixed) {
          ball.type = BodyType::Static;
        } else {
          swing_energy += kMass * kGravity * (size - 1);
        }
        bodies.push_back(world.add_body(ball));
        if (column > 0) join(kind, 1, Vec3(column - 0.5, row, 0.0), Vec3::UnitX());
        if (row > 0) join(kind, size, Vec3(column, row - 0.5, 0.0), Vec3::UnitY());
      }
    }
  }
  /// The newest body with that which came `before` it.
  void join(Kind kind, int before, const Vec3& anchor, const Vec3& along) {
    const BodyId b = bodies.back();
    const BodyId a = bodies[bodies.size() - 1 - static_cast<std::size_t>(before)];
    if (kind == Kind::Ball) joints->add(world, ball_joint_at(world, a, b, anchor));
    if (kind == Kind::Hinge) joints->add(world, hinge_joint_at(world, a, b, anchor, along));
    if (kind == Kind::HingeUpright) {
      joints->add(world, hinge_joint_at(world, a, b, anchor, Vec3::UnitX()));
    }
    if (kind == Kind::Fixed) joints->add(world, fixed_joint_at(world, a, b, anchor));
    if (kind == Kind::Slider) joints->add(world, slider_joint_at(world, a, b, anchor, along));
  }
};

struct Swing {
  bool ok = true;
  double separation = 0.0;  ///< m or rad
  double drift = 0.0;       ///< of the energy of the swing
};

Swing swing(Lattice& lattice, int substeps, double seconds) {
  Solver solver({.substeps = substeps, .sleep_after = 0.0});
  const double energy = lattice.world.mechanical_energy();
  Swing result;
  const int steps = static_cast<int>(std::lround(seconds / kFrame));
  for (int i = 0; i < steps; ++i) {
    result.ok = solver.step(lattice.world, kFrame).status == StepStatus::Ok && result.ok;
    result.separation = std::max(result.separation, lattice.joints->report().residual);
    result.drift = std::max(
        result.drift, std::abs(lattice.world.mechanical_energy() - energy) / lattice.swing_energy);
  }
  return result;
}

void check_swing(int size, Kind kind, Held held, int substeps, double seconds) {
  Lattice lattice(size, kind, held);
  const Swing result = swing(lattice, substeps, seconds);
  INFO(size << " x " << size << ", kind " << static_cast<int>(kind) << ", held "
            << static_cast<int>(held) << ", " << substeps << " substeps: separation "
            << result.separation << " m, energy " << result.drift);
  CHECK(result.ok);
  CHECK(result.separation < 1e-3);
  CHECK(result.drift < 0.01);
}

}  // namespace

TEST_CASE("joint loops: a lattice of ball joints swings, keeps closed and keeps its energy",
          "[pbd][joint][loop][analytic]") {
  for (const int substeps : {2, 4, 32}) {
    check_swing(4, Kind::Ball, Held::Edge, substeps, substeps == 32 ? 5.0 : 12.0);
    check_swing(6, Kind::Ball, Held::Edge, substeps, 3.0);
    check_swing(6, Kind::Ball, Held::Corner, substeps, 2.0);
  }
}

TEST_CASE("joint loops: a lattice of 10 x 10 ball joints does so for longer",
          "[pbd][joint][loop][analytic][long]") {
  for (const int substeps : {2, 4, 32}) {
    check_swing(10, Kind::Ball, Held::Edge, substeps, substeps == 32 ? 2.0 : 5.0);
  }
}

TEST_CASE("joint loops: every kind of joint closes them", "[pbd][joint][loop][analytic]") {
  for (const Kind kind : {Kind::Hinge, Kind::HingeUpright, Kind::Fixed, Kind::Slider}) {
    for (const int substeps : {2, 4, 32}) {
      check_swing(4, kind, Held::Edge, substeps, 1.0);
      check_swing(4, kind, Held::Corner, substeps, 1.0);
    }
  }
}

TEST_CASE("joint loops: a floating loop keeps its momenta", "[pbd][joint][loop][analytic]") {
  Lattice lattice(4, Kind::Ball, Held::Nowhere, weightless());
  for (std::size_t i = 0; i < lattice.bodies.size(); ++i) {
    // Turning about the middle, with a bend that grows outwards.
    const Vec3 x = lattice.world.pose(lattice.bodies[i]).position - Vec3(1.5, 1.5, 0.0);
    const Vec3 spin(0.0, 0.4, 1.0);
    lattice.world.set_twist(lattice.bodies[i],
                            {spin.cross(x) + Vec3(0.1, 0.0, 0.3 * x.x() * x.y()), spin});
  }
  const Vec3 p = linear_momentum(lattice.world);
  const Vec3 l = angular_momentum(lattice.world);
  Solver solver({.joint_tolerance = 1e-10});
  run(lattice.world, solver, 5.0);
  CHECK(lattice.joints->report().residual < 1e-5);
  CHECK((linear_momentum(lattice.world) - p).norm() < 1e-9 * p.norm());
  CHECK((angular_momentum(lattice.world) - l).norm() < 1e-4 * l.norm());
}

TEST_CASE("joint loops: a damped loop comes to rest", "[pbd][joint][loop][unit]") {
  Lattice lattice(5, Kind::Ball, Held::Edge, {}, 1.0);
  Solver solver({.sleep_after = 0.0});
  run(lattice.world, solver, 25.0);
  CHECK(lattice.world.kinetic_energy() < 1e-9 * lattice.swing_energy);
}

}  // namespace joint_loop_test
