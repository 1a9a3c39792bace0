// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/pbd/contact.h"

#include "support/bodies.h"
#include "support/catch.h"
#include "support/toy_contacts.h"

namespace contact_test {

using namespace tandem::pbd;
using namespace tandem::testing;

namespace {

const Vec3 kHalf(0.5, 0.5, 0.5);

/// A box on a plane that is tilted about y; it may slide towards +x.
struct Slope {
  World world;
  ToyContacts contacts;
  BodyId ground, box;
  Vec3 normal, downhill, start;

  Slope(double tilt, double friction, bool swapped = false, const Vec3& half = kHalf,
        double mass = 1.0)
      : normal(std::sin(tilt), 0.0, std::cos(tilt)),
        downhill(std::cos(tilt), 0.0, -std::sin(tilt)) {
    world.set_contact_source(&contacts);
    ground = add_ground(world);
    start = half.z() * normal;
    box = world.add_body(box_def(mass, half, start, turn(Vec3(0.0, tilt, 0.0))));
    contacts.box_on_plane(ground, normal, 0.0, box, half,
                          {.friction = friction, .swapped = swapped});
  }
  double travelled() const { return downhill.dot(world.pose(box).position - start); }
  double height() const { return normal.dot(world.pose(box).position - start); }
  const Contact& contact() const { return world.contacts()->contacts()[0]; }
  /// Normal forces in the last substep, N.
  double load() const {
    double sum = 0.0;
    for (const double force : contact().force) sum += force;
    return sum;
  }
};

constexpr double kTwentyDegrees = 20.0 * kPi / 180.0;

}  // namespace

TEST_CASE("contact: a box on a plane rests, and its contact carries its weight",
          "[pbd][analytic]") {
  for (const bool swapped : {false, true}) {
    Slope scene(0.0, 0.5, swapped, Vec3(0.3, 0.5, 0.2), 2.0);
    Solver solver({.sleep_after = 0.0});
    run(scene.world, solver, 5.0);
    CHECK(std::abs(scene.height()) < 1e-5);
    CHECK(scene.world.twist(scene.box).linear.norm() < 1e-6);
    CHECK(scene.world.twist(scene.box).angular.norm() < 1e-6);
    CHECK(scene.load() == Approx(2.0 * kGravity).epsilon(1e-6));
    for (const double force : scene.contact().force) {
      CHECK(force == Approx(0.25 * 2.0 * kGravity).epsilon(1e-3));
    }
    CHECK(scene.world.in_contact(scene.box));
    CHECK(scene.world.in_contact(scene.ground));
  }
}

TEST_CASE("contact: a box slides down a slope as Coulomb says", "[pbd][analytic]") {
  for (const double friction : {0.0, 0.2, 0.35}) {
    for (const bool swapped : {false, true}) {
      Slope scene(kTwentyDegrees, friction, swapped);
      Solver solver({.sleep_after = 0.0});
      run(scene.world, solver, 5.0);
      const double acceleration =
          kGravity * (std::sin(kTwentyDegrees) - friction * std::cos(kTwentyDegrees));
      const double expected = 0.5 * acceleration * 25.0;
      INFO("mu " << friction << ": " << scene.travelled() << " m against " << expected << " m");
      CHECK(std::abs(scene.travelled() / expected - 1.0) < 0.02);
      CHECK(std::abs(scene.height()) < 1e-4);
    }
  }
}

TEST_CASE("contact: a box sticks on a slope where mu is above its tangent", "[pbd][analytic]") {
  REQUIRE(std::tan(kTwentyDegrees) < 0.38);
  for (const double friction : {0.38, 0.8}) {
    Slope scene(kTwentyDegrees, friction);
    Solver solver;
    run(scene.world, solver, 5.0);
    INFO("mu " << friction << ": " << scene.travelled() << " m");
    CHECK(std::abs(scene.travelled()) < 1e-4);
    CHECK_FALSE(scene.world.awake(scene.box));

    // Kept awake it does not creep: the friction that holds it is carried from step to step, so
    // that what the first steps lack dies out as 0.7^steps does.
    Slope awake(kTwentyDegrees, friction);
    Solver restless({.sleep_after = 0.0});
    run(awake.world, restless, 5.0);
    const double creep = awake.world.twist(awake.box).linear.norm();
    INFO("creeps at " << creep << " m/s, " << awake.travelled() << " m");
    CHECK(creep < 1e-12);
    CHECK(awake.contact().carried_friction.norm() ==
          Approx(kGravity * std::sin(kTwentyDegrees)).epsilon(1e-9));
    CHECK(std::abs(awake.travelled()) < 1e-5);
  }
}

TEST_CASE("contact: a thrown box is braked by mu g and then stands", "[pbd][analytic]") {
  for (const double friction : {0.1, 0.4}) {
    Slope scene(0.0, friction);
    scene.world.set_twist(scene.box, {Vec3(1.2, 1.6, 0.0), Vec3::Zero()});  // 2 m/s
    Solver solver({.sleep_after = 0.0});
    run(scene.world, solver, 0.25);
    CHECK(scene.world.twist(scene.box).linear.norm() ==
          Approx(2.0 - friction * kGravity * 0.25).epsilon(0.01));
    run(scene.world, solver, 3.0);
    const Vec3 travelled = scene.world.pose(scene.box).position - scene.start;
    CHECK(travelled.norm() == Approx(4.0 / (2.0 * friction * kGravity)).epsilon(0.02));
    CHECK((travelled.normalized() - Vec3(0.6, 0.8, 0.0)).norm() < 1e-3);  // straight on
    CHECK(scene.world.twist(scene.box).linear.norm() < 1e-6);
  }
}

TEST_CASE("contact: friction never exceeds mu times the normal force", "[pbd][unit]") {
  Slope scene(kTwentyDegrees, 0.3);
  scene.world.set_twist(scene.box, {Vec3(0.5, 1.0, 0.0), Vec3(0.0, 0.0, 2.0)});
  Solver solver({.sleep_after = 0.0});
  double largest = 0.0;
  run(scene.world, solver, 2.0, [&] {
    const double friction = scene.contact().friction_force.norm();
    REQUIRE(friction <= 0.3 * scene.load() * (1.0 + 1e-9));
    largest = std::max(largest, friction / scene.load());
  });
  CHECK(largest == Approx(0.3).epsilon(1e-6));  // the cone is reached
}

TEST_CASE("contact: a box that spins on a plane is braked by the twist of its four corners",
          "[pbd][analytic]") {
  const double friction = 0.3;
  Slope scene(0.0, friction);
  const double w0 = 4.0;
  scene.world.set_twist(scene.box, {Vec3::Zero(), Vec3(0.0, 0.0, w0)});
  Solver solver({.sleep_after = 0.0});
  // Coulomb: each corner carries m g / 4 at the distance r, so the moment is mu m g r.
  const double r = std::sqrt(0.5);
  const double braking = friction * 1.0 * kGravity * r / box_inertia(1.0, kHalf)(2, 2);
  run(scene.world, solver, 0.2);
  CHECK(scene.world.twist(scene.box).angular.z() == Approx(w0 - braking * 0.2).epsilon(0.01));
  run(scene.world, solver, 2.0);
  CHECK(scene.world.twist(scene.box).angular.norm() < 1e-6);
  CHECK(angle_between(scene.world.pose(scene.box).orientation, Quat::Identity()) ==
        Approx(w0 * w0 / (2.0 * braking)).epsilon(0.02));
}

TEST_CASE("contact: without friction a spinning, sliding box goes on", "[pbd][unit]") {
  Slope scene(0.0, 0.0);
  scene.world.set_twist(scene.box, {Vec3(1.0, 0.0, 0.0), Vec3(0.0, 0.0, 3.0)});
  Solver solver({.sleep_after = 0.0});
  run(scene.world, solver, 2.0);
  CHECK((scene.world.twist(scene.box).linear - Vec3(1.0, 0.0, 0.0)).norm() < 1e-6);
  CHECK((scene.world.twist(scene.box).angular - Vec3(0.0, 0.0, 3.0)).norm() < 1e-5);
}

TEST_CASE("contact: a ball on a rough plane ends up rolling at 5/7 of its speed",
          "[pbd][analytic]") {
  World world;
  ToyContacts contacts;
  world.set_contact_source(&contacts);
  const BodyId ground = add_ground(world);
  const double radius = 0.25;
  const BodyId ball = world.add_body(ball_def(1.0, radius, Vec3(0.0, 0.0, radius)));
  contacts.ball_on_plane(ground, Vec3::UnitZ(), 0.0, ball, radius, {.friction = 0.4});
  world.set_twist(ball, {Vec3(2.0, 0.0, 0.0), Vec3::Zero()});
  Solver solver({.sleep_after = 0.0});
  run(world, solver, 2.0);
  // Angular momentum about the contact line: m v r = (m r^2 + 2/5 m r^2) w.
  const double v = 2.0 * 5.0 / 7.0;
  CHECK(world.twist(ball).linear.x() == Approx(v).epsilon(2e-3));
  CHECK(world.twist(ball).angular.y() == Approx(v / radius).epsilon(2e-3));
  CHECK(std::abs(world.pose(ball).position.z() - radius) < 1e-5);
}

TEST_CASE("contact: a rolling ball rolls on, neither braked nor driven", "[pbd][analytic]") {
  for (const bool swapped : {false, true}) {
    World world;
    ToyContacts contacts;
    world.set_contact_source(&contacts);
    const BodyId ground = add_ground(world);
    const double radius = 0.25;
    const BodyId ball = world.add_body(ball_def(1.0, radius, Vec3(0.0, 0.0, radius)));
    contacts.ball_on_plane(ground, Vec3::UnitZ(), 0.0, ball, radius,
                           {.friction = 0.4, .swapped = swapped});
    world.set_twist(ball, {Vec3(2.0, 1.0, 0.0), Vec3(-4.0, 8.0, 0.0)});
    Solver solver({.sleep_after = 0.0});
    run(world, solver, 5.0);
    CHECK((world.twist(ball).linear - Vec3(2.0, 1.0, 0.0)).norm() < 1e-3);
    CHECK((world.twist(ball).angular - Vec3(-4.0, 8.0, 0.0)).norm() < 1e-2);
  }
}

TEST_CASE("contact: a box that spins fast hardly resists being pushed", "[pbd][analytic]") {
  // Coulomb at four corners: while the spin w r is far above the speed v of the centre, the
  // corners' friction nearly cancels, and the box is braked by much less than mu g.
  const double friction = 0.3;
  Slope scene(0.0, friction);
  scene.world.set_twist(scene.box, {Vec3(0.3, 0.0, 0.0), Vec3(0.0, 0.0, 12.0)});
  Solver solver({.sleep_after = 0.0});
  run(scene.world, solver, 0.1);
  const double braking = (0.3 - scene.world.twist(scene.box).linear.norm()) / 0.1;
  // Exact, four points at r, to first order in v / (w r): mu g v / (2 w r) = 0.052 m/s^2; the
  // ellipsoid that stands for them has twice that slope.
  const double slope = friction * kGravity * 0.3 / (12.0 * std::sqrt(0.5));
  CHECK(braking > 0.3 * slope);
  CHECK(braking < 1.3 * slope);
}

TEST_CASE("contact: a heavy box rests on a light one", "[pbd][regression]") {
  World world;
  ToyContacts contacts;
  world.set_contact_source(&contacts);
  const BodyId ground = add_ground(world);
  const BodyId light = world.add_body(box_def(1.0, kHalf, Vec3(0.0, 0.0, 0.5)));
  const BodyId heavy = world.add_body(box_def(100.0, kHalf, Vec3(0.0, 0.0, 1.5)));
  contacts.box_on_plane(ground, Vec3::UnitZ(), 0.0, light, kHalf, {});
  contacts.box_on_box(light, kHalf, heavy, kHalf, {});
  Solver solver({.sleep_after = 0.0});
  run(world, solver, 5.0);
  CHECK(std::abs(world.pose(light).position.z() - 0.5) < 1e-3);
  CHECK(std::abs(world.pose(heavy).position.z() - 1.5) < 1e-3);
  CHECK(world.twist(heavy).linear.norm() < 1e-3);
}

TEST_CASE("contact: a kinematic floor carries bodies along", "[pbd][unit]") {
  World world;
  ToyContacts contacts;
  world.set_contact_source(&contacts);
  const BodyId lift = world.add_body({.type = BodyType::Kinematic,
                                      .pose = {Vec3(0.0, 0.0, -0.5), Quat::Identity()},
                                      .twist = {Vec3(0.2, 0.0, 0.1), Vec3::Zero()}});
  const BodyId box = world.add_body(box_def(1.0, kHalf, Vec3(0.0, 0.0, 0.5)));
  contacts.box_on_box(lift, Vec3(5.0, 5.0, 0.5), box, kHalf, {});
  Solver solver({.sleep_after = 0.0});
  run(world, solver, 3.0);
  CHECK((world.twist(box).linear - Vec3(0.2, 0.0, 0.1)).norm() < 1e-3);
  CHECK(std::abs(world.pose(box).position.z() - 0.8) < 1e-3);
  CHECK((world.pose(lift).position - Vec3(0.6, 0.0, -0.2)).norm() < 1e-12);
}

}  // namespace contact_test
