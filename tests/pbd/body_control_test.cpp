// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <cmath>

#include "support/bodies.h"
#include "support/catch.h"
#include "support/toy_contacts.h"
#include "tandem/pbd/contact.h"
#include "tandem/pbd/joint.h"
#include "tandem/pbd/solver.h"

namespace body_control_test {

using namespace tandem::pbd;
using namespace tandem::testing;

namespace {

const Vec3 kHalf = Vec3::Constant(0.5);

/// A box that lies on the plane z = 0.
struct Resting {
  World world;
  ToyContacts contacts;
  BodyId ground, box;
  Solver solver;

  Resting() {
    world.set_contact_source(&contacts);
    ground = add_ground(world);
    box = world.add_body(box_def(2.0, kHalf, Vec3(0.0, 0.0, 0.5)));
    contacts.box_on_plane(ground, Vec3::UnitZ(), 0.0, box, kHalf, {});
  }
  void sleep() {
    run(world, solver, 2.0);
    REQUIRE_FALSE(world.awake(box));
  }
};

}  // namespace

TEST_CASE("bodies: a force acts for one step, off the centre with its moment", "[pbd][analytic]") {
  World world(weightless());
  const BodyId body = world.add_body(box_def(2.0, kHalf, Vec3::Zero()));
  const double inertia = world.props(body).inertia(2, 2);
  Solver solver;
  world.apply_force(body, Vec3(0.0, 6.0, 0.0), Vec3(0.5, 0.0, 0.0));
  solver.step(world, kFrame);
  solver.step(world, kFrame);  // nothing acts any more
  CHECK((world.twist(body).linear - Vec3(0.0, 3.0 * kFrame, 0.0)).norm() < 1e-12);
  CHECK(world.twist(body).angular.z() == Approx(3.0 / inertia * kFrame).epsilon(1e-9));
  const double spin = world.twist(body).angular.z();
  world.apply_impulse(body, Vec3(0.0, -6.0 * kFrame, 0.0), world.pose(body).position);
  CHECK(world.twist(body).linear.norm() < 1e-12);
  world.apply_impulse(body, Vec3(0.0, 0.0, 1.0));  // at the centre of mass, wherever that is
  CHECK(world.twist(body).linear.z() == 0.5);
  CHECK(world.twist(body).angular.z() == spin);
}

TEST_CASE("bodies: damping is exponential at any step", "[pbd][analytic]") {
  for (const double dt : {kFrame, 0.1}) {
    World world(weightless());
    BodyDef def = box_def(1.0, kHalf, Vec3::Zero());
    def.twist = {Vec3(2.0, 0.0, 0.0), Vec3(0.0, 0.0, 3.0)};
    def.linear_damping = 0.5;
    def.angular_damping = 0.25;
    const BodyId body = world.add_body(def);
    Solver solver;
    for (int i = 0; i * dt < 1.0 - 1e-9; ++i) solver.step(world, dt);
    const double seconds = world.time();
    CHECK(world.twist(body).linear.x() == Approx(2.0 * std::exp(-0.5 * seconds)).epsilon(1e-12));
    CHECK(world.twist(body).angular.z() == Approx(3.0 * std::exp(-0.25 * seconds)).epsilon(1e-12));
  }
}

TEST_CASE("bodies: nothing moves a locked axis", "[pbd][unit]") {
  Resting scene;
  scene.world.set_locks(scene.box, {.linear = {true, false, false}, .angular = {true, true, true}});
  scene.world.set_twist(scene.box, {Vec3(1.0, 1.0, 0.0), Vec3(1.0, 2.0, 3.0)});
  run(scene.world, scene.solver, 0.5);
  CHECK(scene.world.pose(scene.box).position.x() == 0.0);
  CHECK(scene.world.pose(scene.box).position.y() > 0.09);  // friction stops it after 0.1 m
  CHECK(angle_between(scene.world.pose(scene.box).orientation, Quat::Identity()) == 0.0);
}

TEST_CASE("bodies: a kinematic body is where it was sent, and stands there", "[pbd][unit]") {
  World world;
  const BodyId cart = world.add_body({.type = BodyType::Kinematic});
  const Pose goal{Vec3(0.3, -0.2, 0.1), turn(Vec3(0.2, 0.5, -0.4))};
  Solver solver;
  world.set_kinematic_target(cart, goal);
  for (int i = 0; i < 3; ++i) {
    solver.step(world, kFrame);
    CHECK((world.pose(cart).position - goal.position).norm() < 1e-15);
    CHECK(angle_between(world.pose(cart).orientation, goal.orientation) < 1e-12);
    CHECK(world.twist(cart).linear.norm() == 0.0);
  }
  CHECK_THROWS_WITH(world.set_kinematic_target(world.add_body({}), goal),
                    Catch::Contains("a kinematic body"));
}

TEST_CASE("sleep: a resting body sleeps, bit for bit in place, until it is disturbed",
          "[pbd][unit]") {
  Resting scene;
  scene.sleep();
  const auto before = scene.world.hash();
  const StepReport& report = scene.solver.step(scene.world, kFrame);
  CHECK(report.awake == 0);
  CHECK(scene.world.hash() == before);
  CHECK(scene.world.in_contact(scene.box));

  SECTION("by an impulse") {
    scene.world.apply_impulse(scene.box, Vec3(0.0, 0.0, 4.0), Vec3(0.0, 0.0, 0.5));
    run(scene.world, scene.solver, 0.1);
    CHECK(scene.world.pose(scene.box).position.z() > 0.55);
  }
  SECTION("by a force") {
    scene.world.apply_force(scene.box, Vec3(0.0, 0.0, 1.0));
    CHECK(scene.world.awake(scene.box));
  }
  SECTION("by losing its support") {
    scene.world.remove_body(scene.ground);
    run(scene.world, scene.solver, 0.5);
    CHECK(scene.world.pose(scene.box).position.z() < 0.0);
  }
  SECTION("by having its support moved away") {
    scene.contacts.remove_body(scene.box);
    run(scene.world, scene.solver, 0.5);
    CHECK(scene.world.pose(scene.box).position.z() < 0.0);
  }
  SECTION("by another gravity") {
    scene.world.set_gravity(Vec3(0.0, 0.0, 9.81));
    run(scene.world, scene.solver, 0.5);
    CHECK(scene.world.pose(scene.box).position.z() > 1.0);
  }
  SECTION("and a restored sleeper sleeps on") {
    const auto bytes = scene.world.snapshot();
    scene.world.wake(scene.box);
    scene.world.restore(bytes);
    CHECK_FALSE(scene.world.awake(scene.box));
  }
}

TEST_CASE("sleep: a freely drifting body stays awake, however slow", "[pbd][unit]") {
  World world(weightless());
  BodyDef def = box_def(1.0, kHalf, Vec3::Zero());
  def.twist.linear = Vec3(1e-4, 0.0, 0.0);
  const BodyId body = world.add_body(def);
  Solver solver;
  run(world, solver, 10.0);
  CHECK(world.awake(body));
  CHECK(world.pose(body).position.x() == Approx(1e-3).epsilon(1e-9));
}

TEST_CASE("refinement: a heavy body on a light one gets more substeps, its neighbour does not",
          "[pbd][unit]") {
  World world;
  ToyContacts contacts;
  world.set_contact_source(&contacts);
  const BodyId ground = add_ground(world);
  const BodyId light = world.add_body(box_def(1.0, kHalf, Vec3(0.0, 0.0, 0.5)));
  const BodyId heavy = world.add_body(box_def(1000.0, kHalf, Vec3(0.0, 0.0, 1.5)));
  const BodyId other = world.add_body(box_def(1.0, kHalf, Vec3(5.0, 0.0, 0.5)));
  contacts.box_on_plane(ground, Vec3::UnitZ(), 0.0, light, kHalf, {});
  contacts.box_on_box(light, kHalf, heavy, kHalf, {});
  contacts.box_on_plane(ground, Vec3::UnitZ(), 0.0, other, kHalf, {});
  Solver solver({.sleep_after = 0.0});
  StepReport last;
  run(world, solver, 3.0);
  last = solver.step(world, kFrame);
  CHECK(last.groups == 2);
  CHECK(last.substeps > solver.options().substeps);
  CHECK(world.pose(heavy).position.z() == Approx(1.5).margin(1e-3));

  Solver plain({.refine = false, .sleep_after = 0.0});
  last = plain.step(world, kFrame);  // levels decay, so the first step still has them
  for (int i = 0; i < 100; ++i) last = plain.step(world, kFrame);
  CHECK(last.groups == 1);
}

TEST_CASE("bodies: forces and impulses that add up to no number are refused and change nothing",
          "[pbd][fault]") {
  World world;
  const BodyId body = world.add_body(box_def(1e-3, kHalf, Vec3::Zero()));
  const Vec3 far(1e200, 0.0, 0.0);
  const Vec3 huge(0.0, 1e308, 0.0);
  const auto before = world.snapshot();
  CHECK(names(refusal([&] { world.apply_impulse(body, Vec3(0.0, 1e200, 0.0), far); }),
              "World::apply_impulse", "inf", "finite"));
  CHECK(names(refusal([&] { world.apply_impulse(body, huge, Vec3::Zero()); }),
              "World::apply_impulse", "inf", "finite"));
  CHECK(names(refusal([&] { world.apply_angular_impulse(body, huge); }),
              "World::apply_angular_impulse", "inf", "finite"));
  CHECK(names(refusal([&] { world.apply_force(body, Vec3(0.0, 1e200, 0.0), far); }),
              "World::apply_force", "inf", "finite"));
  CHECK(world.snapshot() == before);
  world.apply_force(body, huge);
  world.apply_torque(body, huge);
  const auto pushed = world.snapshot();
  CHECK(names(refusal([&] { world.apply_force(body, huge); }), "World::apply_force", "inf",
              "finite"));
  CHECK(names(refusal([&] { world.apply_torque(body, huge); }), "World::apply_torque", "inf",
              "finite"));
  CHECK(world.snapshot() == pushed);
}

TEST_CASE("bodies: a kinematic body that would leave the numbers stays, and is named",
          "[pbd][fault]") {
  World world;
  const BodyId other = world.add_body({.type = BodyType::Kinematic});
  const BodyId cart = world.add_body({.type = BodyType::Kinematic});
  world.set_twist(cart, {Vec3(1.0, 0.0, 0.0), Vec3(1e200, 0.0, 0.0)});
  Solver solver;
  const StepReport& report = solver.step(world, kFrame);
  CHECK(report.status == StepStatus::NonFinite);
  CHECK(report.first_bad_body == cart);
  CHECK(world.pose(cart).position.isZero(0.0));
  CHECK(world.pose(cart).orientation.coeffs().allFinite());
  CHECK(world.twist(cart).angular.isZero(0.0));
  CHECK(world.contains(other));
  CHECK(solver.step(world, kFrame).status == StepStatus::Ok);
}

TEST_CASE("bodies: mass and inertia without an inverse are refused", "[pbd][fault]") {
  World world;
  const auto refused = [&](double mass, const Mat3& inertia) {
    return refusal([&] { world.add_body({.mass = mass, .inertia = inertia}); });
  };
  CHECK(names(refused(1e-310, Mat3::Identity()), "mass", "1e-310", "inverse"));
  CHECK(names(refused(1.0, 1e-110 * Mat3::Identity()), "inertia", "1e-110", "inverse"));
  CHECK(names(refused(1.0, 1e110 * Mat3::Identity()), "inertia", "1e+110", "inverse"));
  CHECK(world.body_count() == 0);
  CHECK(refused(1e-90, 1e-90 * Mat3::Identity()).empty());
}

TEST_CASE("contacts: without their source they are over", "[pbd][unit]") {
  Resting scene;
  const bool asleep = GENERATE(false, true);
  if (asleep) {
    scene.sleep();
  } else {
    run(scene.world, scene.solver, 0.2);
  }
  scene.world.set_contact_source(nullptr);
  run(scene.world, scene.solver, 0.5);
  // It falls: 1.2 m in half a second.
  CHECK(scene.world.pose(scene.box).position.z() ==
        Approx(0.5 - 0.5 * kGravity * 0.25).margin(0.1));
  CHECK_FALSE(scene.world.in_contact(scene.box));
}

TEST_CASE("contacts: one that appears inside a sleeping body wakes it", "[pbd][unit]") {
  Resting scene;
  scene.sleep();
  // The floor is now 5 cm higher.
  scene.contacts.box_on_plane(scene.ground, Vec3::UnitZ(), 0.05, scene.box, kHalf, {});
  run(scene.world, scene.solver, 1.0);
  CHECK(scene.world.pose(scene.box).position.z() == Approx(0.55).margin(1e-3));
}

TEST_CASE("refinement: a fast joint gets its substeps whichever of its bodies moves",
          "[pbd][unit]") {
  int substeps[2] = {};
  for (const bool swapped : {false, true}) {
    World world(weightless());
    auto& joints = world.add_block<JointBlock>();
    const BodyId ground = add_ground(world);
    const BodyId wheel = world.add_body(box_def(1.0, kHalf, Vec3::Zero()));
    world.set_twist(wheel, {Vec3::Zero(), Vec3(0.0, 0.0, 60.0)});
    joints.add(world, hinge_joint_at(world, swapped ? wheel : ground, swapped ? ground : wheel,
                                     Vec3::Zero(), Vec3::UnitZ()));
    Solver solver;
    run(world, solver, 0.1);
    substeps[swapped ? 1 : 0] = solver.step(world, kFrame).substeps;
  }
  CHECK(substeps[0] > SolverOptions{}.substeps);
  CHECK(substeps[1] == substeps[0]);
}

}  // namespace body_control_test
