// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/pbd/tether.h"

#include <functional>
#include <limits>

#include "support/bodies.h"
#include "support/catch.h"
#include "support/gradient.h"

namespace tether_test {

using namespace tandem::pbd;
using namespace tandem::testing;

namespace {

const Vec3 kHalf(0.2, 0.1, 0.15);

}  // namespace

TEST_CASE("tether: a body hangs m g / k below its anchor", "[pbd][analytic]") {
  World world;
  auto& tethers = world.add_block<Tethers>();
  const BodyId body = world.add_body(box_def(2.0, kHalf, Vec3(0.0, 0.0, 1.0)));
  const ConstraintId id = tethers.add(
      world, {.body = body, .anchor_w = Vec3(0.0, 0.0, 1.0), .stiffness = 300.0, .damping = 25.0});
  Solver solver({.substeps = 10, .sleep_after = 0.0});
  run(world, solver, 8.0);
  CHECK(std::abs(1.0 - world.pose(body).position.z() - 2.0 * kGravity / 300.0) < 1e-9);
  CHECK((tethers.at(id).force() - Vec3(0.0, 0.0, 2.0 * kGravity)).norm() < 1e-6);
}

TEST_CASE("tether: it is an implicit spring-damper to rounding", "[pbd][analytic]") {
  World world(weightless());
  auto& tethers = world.add_block<Tethers>();
  const BodyId body = world.add_body(box_def(2.0, kHalf, Vec3(0.3, -0.2, 0.1)));
  tethers.add(world, {.body = body, .stiffness = 500.0, .damping = 20.0});
  Solver solver({.substeps = 10, .sleep_after = 0.0});
  std::array<ImplicitSpring, 3> exact;
  for (int i = 0; i < 3; ++i) {
    exact[i] = {
        .mass = 2.0, .stiffness = 500.0, .damping = 20.0, .x = world.pose(body).position[i]};
  }
  run(world, solver, 1.0, [&] {
    for (int i = 0; i < 3; ++i) {
      for (int k = 0; k < 10; ++k) exact[i].step(kFrame / 10.0);
      REQUIRE(std::abs(world.pose(body).position[i] - exact[i].x) < 1e-12);
    }
  });
}

TEST_CASE("tether: its force stops at the limit", "[pbd][analytic]") {
  World world(weightless());
  auto& tethers = world.add_block<Tethers>();
  const BodyId body = world.add_body(box_def(2.0, kHalf, Vec3::Zero()));
  const ConstraintId id = tethers.add(world, {.body = body,
                                              .anchor_w = Vec3(3.0, 4.0, 0.0),
                                              .stiffness = 1e4,
                                              .damping = 0.0,
                                              .max_force = 10.0});
  Solver solver({.substeps = 10, .sleep_after = 0.0});
  run(world, solver, 0.5);
  // 5 m away at 1e4 N/m: 10 N all the way, so a = F / m along (3, 4, 0) / 5.
  CHECK(tethers.at(id).force().norm() == Approx(10.0).epsilon(1e-9));
  CHECK((world.twist(body).linear - 0.5 * 5.0 * Vec3(0.6, 0.8, 0.0)).norm() < 1e-9);
}

TEST_CASE("tether: a weight beyond the limit falls with the remaining force", "[pbd][analytic]") {
  World world;
  auto& tethers = world.add_block<Tethers>();
  const BodyId body = world.add_body(box_def(2.0, kHalf, Vec3(0.0, 0.0, -5.0)));
  tethers.add(world, {.body = body, .stiffness = 1e5, .damping = 0.0, .max_force = 5.0});
  Solver solver({.substeps = 10, .sleep_after = 0.0});
  run(world, solver, 1.0);
  CHECK(world.twist(body).linear.z() == Approx(-kGravity + 2.5).epsilon(1e-9));
}

TEST_CASE("tether: the anchor coasts with its velocity and the body follows it without drag",
          "[pbd][analytic]") {
  World world(weightless());
  auto& tethers = world.add_block<Tethers>();
  const Vec3 speed(0.5, 0.0, 0.0);
  const BodyId body = world.add_body(box_def(1.0, kHalf, Vec3::Zero()));
  const ConstraintId id = tethers.add(
      world, {.body = body, .anchor_velocity = speed, .stiffness = 400.0, .damping = 40.0});
  Solver solver({.substeps = 10, .sleep_after = 0.0});
  run(world, solver, 3.0);
  CHECK((tethers.def(id).anchor_w - 3.0 * speed).norm() < 1e-12);
  // C is measured from the moving anchor, so an even motion is not damped.
  CHECK((world.pose(body).position - tethers.def(id).anchor_w).norm() < 1e-9);
  CHECK((world.twist(body).linear - speed).norm() < 1e-9);
}

TEST_CASE("tether: off-centre it turns the body by r x F", "[pbd][analytic]") {
  World world(weightless());
  auto& tethers = world.add_block<Tethers>();
  const double mass = 1.0;
  const BodyId body = world.add_body(box_def(mass, kHalf, Vec3::Zero()));
  tethers.add(world, {.body = body,
                      .anchor_l = Vec3(0.2, 0.0, 0.0),
                      .anchor_w = Vec3(0.2, 100.0, 0.0),
                      .stiffness = 1e4,
                      .damping = 0.0,
                      .max_force = 2.0});
  Solver solver({.substeps = 50, .sleep_after = 0.0});
  solver.step(world, 1e-3);
  // Force 2 N along y at 0.2 m: momenta F t and r F t.
  CHECK((world.twist(body).linear - Vec3(0.0, 2e-3, 0.0)).norm() < 1e-8);
  const double inertia = box_inertia(mass, kHalf)(2, 2);
  CHECK((world.twist(body).angular - Vec3(0.0, 0.0, 0.2 * 2e-3 / inertia)).norm() < 1e-6);
}

TEST_CASE("tether: one stiff projection follows the numerical gradient", "[pbd][gradient]") {
  World world;
  const BodyId body = world.add_body({});
  const Tether::Def def{.body = body,
                        .anchor_l = Vec3(0.2, -0.1, 0.3),
                        .anchor_w = Vec3(0.4, 0.1, 0.2),
                        .stiffness = 1e12,
                        .damping = 0.0};
  std::vector<SolverBody> bodies{solver_body({Vec3(0.1, 0.2, 0.1), turn(Vec3(0.5, -0.2, 0.9))}, 1.5,
                                             box_inertia(1.5, Vec3(0.1, 0.3, 0.2)))};
  const auto c = [&](const std::vector<Pose>& poses) {
    return Eigen::VectorXd(poses[0].to_world(def.anchor_l) - def.anchor_w);
  };
  const Eigen::VectorXd expected = expected_projection(c, bodies);
  Tether tether(def);
  const SubstepContext context{.bodies = bodies, .h = 0.01};
  tether.begin_substep(context);
  tether.project(context);
  CHECK((corrections_of(bodies) - expected).norm() < 1e-6 * expected.norm());
}

TEST_CASE("tether: the momentum that it gives is the impulse of its force", "[pbd][analytic]") {
  World world(weightless());
  auto& tethers = world.add_block<Tethers>();
  const BodyId body = world.add_body(box_def(1.5, kHalf, Vec3::Zero()));
  const ConstraintId id = tethers.add(
      world, {.body = body, .anchor_l = Vec3(0.1, 0.05, 0.0), .anchor_w = Vec3(0.2, 0.3, -0.1)});
  Solver solver({.substeps = 1, .sleep_after = 0.0});
  Vec3 impulse = Vec3::Zero();
  run(world, solver, 1.0, [&] { impulse += kFrame * tethers.at(id).force(); });
  CHECK((linear_momentum(world) - impulse).norm() < 1e-12);
  CHECK(impulse.norm() > 1e-3);
}

TEST_CASE("tether: on a body that cannot move it is harmless", "[pbd][fault]") {
  World world;
  auto& tethers = world.add_block<Tethers>();
  const BodyId wall = add_ground(world);
  const ConstraintId id = tethers.add(world, {.body = wall, .anchor_w = Vec3(1.0, 0.0, 0.0)});
  Solver solver({.substeps = 10, .sleep_after = 0.0});
  CHECK(solver.step(world, kFrame).status == StepStatus::Ok);
  CHECK(world.pose(wall).position.norm() == 0.0);
  CHECK(tethers.at(id).force().allFinite());
}

TEST_CASE("tether: the softest and the stiffest that are accepted stay finite", "[pbd][fault]") {
  for (const double stiffness : {Tether::kMinStiffness, Tether::kMaxStiffness}) {
    World world;
    auto& tethers = world.add_block<Tethers>();
    const BodyId body = world.add_body({});
    tethers.add(world, {.body = body,
                        .anchor_l = Vec3(0.1, 0.0, 0.0),
                        .anchor_w = Vec3(0.2, 0.0, 0.0),
                        .stiffness = stiffness,
                        .damping = 20.0});
    Solver solver({.substeps = 10, .sleep_after = 0.0});
    for (int i = 0; i < 60; ++i) REQUIRE(solver.step(world, kFrame).status == StepStatus::Ok);
  }
}

TEST_CASE("tether: a bad definition is refused naming field, value and rule", "[pbd][fault]") {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInf = std::numeric_limits<double>::infinity();
  using Def = Tether::Def;
  World world;
  auto& tethers = world.add_block<Tethers>();
  const BodyId body = world.add_body({});
  const ConstraintId id = tethers.add(world, {.body = body});
  const auto refused = [&](const char* field, const char* value, const char* rule,
                           const std::function<void(Def&)>& spoil) {
    Def def{.body = body};
    spoil(def);
    for (const std::string& message : {refusal([&] { tethers.add(world, def); }),
                                       refusal([&] { tethers.set(world, id, def); })}) {
      INFO("\"" << message << "\"");
      CHECK(names(message, std::string("tether: ") + field, value, rule));
    }
  };
  refused("body", "body 4294967295", "a body of this world", [&](Def& d) { d.body = {}; });
  refused("anchor_l", "nan", "finite", [&](Def& d) { d.anchor_l.x() = kNan; });
  refused("anchor_w", "inf", "finite", [&](Def& d) { d.anchor_w.y() = kInf; });
  refused("anchor_velocity", "nan", "finite", [&](Def& d) { d.anchor_velocity.z() = kNan; });
  refused("stiffness", "is 0", "1e-9 to 1e15", [&](Def& d) { d.stiffness = 0.0; });
  refused("stiffness", "inf", "1e-9 to 1e15", [&](Def& d) { d.stiffness = kInf; });
  refused("stiffness", "1e-310", "1e-9 to 1e15", [&](Def& d) { d.stiffness = 1e-310; });
  refused("damping", "is -1", "0 to 1e15", [&](Def& d) { d.damping = -1.0; });
  refused("damping", "nan", "0 to 1e15", [&](Def& d) { d.damping = kNan; });
  refused("max_force", "is 0", "> 0", [&](Def& d) { d.max_force = 0.0; });
  refused("max_force", "nan", "> 0", [&](Def& d) { d.max_force = kNan; });
  CHECK(tethers.size() == 1);
  CHECK(tethers.def(id).stiffness == 500.0);
}

}  // namespace tether_test
