// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Slow is not at rest: what is driven, out of balance or drifting stays awake; all else sleeps.
#include "joint_fixture.h"
#include "support/catch.h"
#include "support/toy_contacts.h"
#include "tandem/pbd/contact.h"
#include "tandem/pbd/distance_joint.h"
#include "tandem/pbd/tether.h"

namespace sleep_test {

using namespace tandem::pbd;
using namespace tandem::testing;

namespace {

const SolverOptions kDefaults;

}  // namespace

TEST_CASE("sleep: a slow motor runs on", "[pbd][sleep][analytic]") {
  Mounted hinge(weightless(), kDefaults);
  hinge.add_box(2.0, Vec3::Zero());
  HingeJointDef turning = hinge_joint_at(hinge.world, {}, hinge.body, Vec3::Zero(), Vec3::UnitZ());
  turning.axis.motor = {.mode = MotorMode::Velocity, .target = 0.01};
  hinge.add_joint(turning);
  hinge.run(5.0);
  CHECK(hinge.state().position[3] == Approx(0.05).epsilon(1e-3));

  Mounted slider(weightless(), kDefaults);
  slider.add_box(2.0, Vec3::Zero());
  SliderJointDef sliding =
      slider_joint_at(slider.world, {}, slider.body, Vec3::Zero(), Vec3::UnitX());
  sliding.axis.motor = {.mode = MotorMode::Position, .target = 0.02, .max_speed = 0.005};
  slider.add_joint(sliding);
  slider.run(3.0);
  CHECK(slider.state().position[0] == Approx(0.015).epsilon(1e-3));
  slider.run(3.0);
  CHECK(slider.state().position[0] == Approx(0.02).margin(2e-6));
  CHECK_FALSE(slider.world.awake(slider.body));  // it has arrived
}

TEST_CASE("sleep: the speed and the spin below which bodies rest are the application's",
          "[pbd][sleep]") {
  // Without friction a slider and a hinge never stop, each at five times the threshold of rest.
  for (const double factor : {1.0, 10.0}) {
    SolverOptions options;
    const double speed = 5.0 * options.sleep_speed;
    const double spin = 5.0 * options.sleep_spin;
    options.sleep_speed *= factor;
    options.sleep_spin *= factor;
    Mounted slider(weightless(), options);
    slider.add_box(2.0, Vec3::Zero());
    slider.add_joint(slider_joint_at(slider.world, {}, slider.body, Vec3::Zero(), Vec3::UnitX()));
    slider.world.set_twist(slider.body, {Vec3(speed, 0.0, 0.0), Vec3::Zero()});
    slider.run(2.0);
    CHECK(slider.world.awake(slider.body) == (factor == 1.0));
    Mounted hinge(weightless(), options);
    hinge.add_box(2.0, Vec3::Zero());
    hinge.add_joint(hinge_joint_at(hinge.world, {}, hinge.body, Vec3::Zero(), Vec3::UnitZ()));
    hinge.world.set_twist(hinge.body, {Vec3::Zero(), Vec3(0.0, 0.0, spin)});
    hinge.run(2.0);
    CHECK(hinge.world.awake(hinge.body) == (factor == 1.0));
  }
}

TEST_CASE("sleep: a body trembling about a place rests, and a creeping one does not",
          "[pbd][sleep]") {
  // On a rod of 1 cm, 0.2 mm to both sides at 31 rad/s: 6 mm/s at most.
  World world;
  auto& rods = world.add_block<DistanceJoints>();
  const BodyId bob = world.add_body(ball_def(1.0, 0.005, Vec3(0.0, 0.0, -0.01)));
  rods.add(world, {.b = bob, .rest_length = 0.01});
  world.set_twist(bob, {Vec3(0.006, 0.0, 0.0), Vec3::Zero()});
  Solver solver;
  run(world, solver, 0.25);
  CHECK(world.mechanical_energy() > -9.81 * 0.01 + 1e-5);  // of 1.8e-5 J: nothing brakes it
  run(world, solver, 0.5);
  CHECK_FALSE(world.awake(bob));

  // Without friction, at 1.5 mm/s.
  Mounted slider(weightless(), kDefaults);
  slider.add_box(2.0, Vec3::Zero());
  slider.add_joint(slider_joint_at(slider.world, {}, slider.body, Vec3::Zero(), Vec3::UnitX()));
  slider.world.set_twist(slider.body, {Vec3(0.0015, 0.0, 0.0), Vec3::Zero()});
  slider.run(10.0);
  CHECK(slider.state().position[0] == Approx(0.015).epsilon(1e-6));
}

TEST_CASE("sleep: two bodies of an island that creep rest, whichever began first", "[pbd][sleep]") {
  // Without friction, at 0.8 of the speed of rest: every 0.625 s each has gone as far as that speed
  // goes in 0.5 s, the second one 0.3 s after the first.
  Mounted m(weightless(), kDefaults);
  const double speed = 0.8 * kDefaults.sleep_speed;
  const auto slider = [&](double x) {
    m.add_box(2.0, Vec3(x, 0.0, 0.0));
    m.add_joint(slider_joint_at(m.world, {}, m.body, Vec3(x, 0.0, 0.0), Vec3::UnitX()));
    m.world.set_twist(m.body, {Vec3(speed, 0.0, 0.0), Vec3::Zero()});
    return m.body;
  };
  const BodyId first = slider(0.0);
  const BodyId second = slider(2.0);
  auto& ropes = m.world.add_block<DistanceJoints>();
  ropes.add(m.world, {.a = first, .b = second, .elastic = false, .max_length = 10.0});
  m.run(0.3);
  m.world.set_twist(second, {Vec3(speed, 0.0, 0.0), Vec3::Zero()});
  m.run(5.0);
  CHECK_FALSE(m.world.awake(first));
  CHECK_FALSE(m.world.awake(second));
}

TEST_CASE("sleep: a motor that a limit or its load stops lets its body sleep", "[pbd][sleep]") {
  for (const bool at_limit : {true, false}) {
    Mounted m(WorldDef{}, kDefaults);
    m.add_box(2.0, Vec3::Zero());
    SliderJointDef def = slider_joint_at(m.world, {}, m.body, Vec3::Zero(), Vec3::UnitZ());
    def.axis = limit(-0.01, 0.01);
    def.axis.motor = {.mode = MotorMode::Velocity, .target = 0.5};
    if (!at_limit) def.axis.motor.max_force = 5.0;  // its weight is 20 N: it lies on the lower stop
    m.add_joint(def);
    m.run(3.0);
    CHECK(m.state().position[0] == Approx(at_limit ? 0.01 : -0.01).margin(1e-6));
    CHECK_FALSE(m.world.awake(m.body));
  }
}

TEST_CASE("sleep: a body may have a speed and a spin of its own below which it rests",
          "[pbd][sleep]") {
  // Without friction a slider never stops, at five times the threshold of rest, or a fifth.
  const SolverOptions options;
  for (const double factor : {1.0, 10.0}) {
    for (const bool own : {false, true}) {
      INFO("factor " << factor << ", own " << own);
      Mounted m(weightless(), options);
      BodyDef def = box_def(2.0, kHalf, Vec3::Zero());
      if (own) def.sleep_speed = factor * options.sleep_speed;
      m.body = m.world.add_body(def);
      m.add_joint(slider_joint_at(m.world, {}, m.body, Vec3::Zero(), Vec3::UnitX()));
      m.world.set_twist(m.body, {Vec3(5.0 * options.sleep_speed, 0.0, 0.0), Vec3::Zero()});
      m.run(0.2);
      m.world.restore(m.world.snapshot());
      m.run(2.0);
      CHECK(m.world.awake(m.body) == !(own && factor == 10.0));
    }
  }
  Mounted hinge(weightless(), options);
  BodyDef def = box_def(2.0, kHalf, Vec3::Zero());
  def.sleep_spin = 0.0002;
  hinge.body = hinge.world.add_body(def);
  hinge.add_joint(hinge_joint_at(hinge.world, {}, hinge.body, Vec3::Zero(), Vec3::UnitZ()));
  hinge.world.set_twist(hinge.body, {Vec3::Zero(), Vec3(0.0, 0.0, 0.2 * options.sleep_spin)});
  hinge.run(3.0);
  CHECK(hinge.world.awake(hinge.body));

  def.sleep_speed = -1.0;
  CHECK(names(refusal([&] { hinge.world.add_body(def); }), "BodyDef: sleep_speed", "-1",
              "from 0 to"));
  def.sleep_speed = 0.0;
  def.sleep_spin = NAN;
  CHECK(names(refusal([&] { hinge.world.add_body(def); }), "BodyDef: sleep_spin", "nan",
              "from 0 to"));
}

TEST_CASE("sleep: the anchor of a tether that moves slowly coasts on", "[pbd][sleep][analytic]") {
  World world(weightless());
  auto& tethers = world.add_block<Tethers>();
  const BodyId body = world.add_body(box_def(1.0, kHalf, Vec3::Zero()));
  const ConstraintId id = tethers.add(world, {.body = body,
                                              .anchor_velocity = Vec3(0.005, 0.0, 0.0),
                                              .stiffness = 400.0,
                                              .damping = 40.0});
  Solver solver;
  run(world, solver, 5.0);
  CHECK(tethers.def(id).anchor_w.x() == Approx(0.025).epsilon(1e-9));
  CHECK(world.pose(body).position.x() == Approx(0.025).epsilon(1e-3));
  Tether::Def still = tethers.def(id);
  still.anchor_velocity.setZero();
  tethers.set(world, id, still);
  run(world, solver, 3.0);
  CHECK_FALSE(world.awake(body));
}

TEST_CASE("sleep: a heavy body that a weak spring pulls sets off", "[pbd][sleep][analytic]") {
  // x = cos(t sqrt(k / m)): 10 N on 10 t. In half a second it has 0.5 mm/s.
  const double rate = std::sqrt(10.0 / 1e4);
  Mounted slider(weightless(), kDefaults);
  slider.add_box(1e4, Vec3::Zero());
  SliderJointDef def = slider_joint_at(slider.world, {}, slider.body, Vec3::Zero(), Vec3::UnitX());
  def.axis.spring = {.stiffness = 10.0, .rest = 1.0};
  slider.add_joint(def);
  slider.run(10.0);
  CHECK(slider.state().position[0] == Approx(1.0 - std::cos(10.0 * rate)).epsilon(0.02));

  World world(weightless());
  auto& rods = world.add_block<DistanceJoints>();
  const BodyId body = world.add_body(ball_def(1e4, 0.5, Vec3(2.0, 0.0, 0.0)));
  rods.add(world, {.b = body, .rest_length = 1.0, .compliance = 0.1});
  Solver solver;
  run(world, solver, 10.0);
  CHECK(2.0 - world.pose(body).position.x() == Approx(1.0 - std::cos(10.0 * rate)).epsilon(0.02));
}

TEST_CASE("sleep: a body that drifts towards a wall gets there", "[pbd][sleep][analytic]") {
  World world(weightless());
  ToyContacts contacts;
  world.set_contact_source(&contacts);
  const BodyId wall = add_ground(world);
  BodyDef def = ball_def(1.0, 0.5, Vec3(0.0, 0.0, 0.515));
  def.twist.linear = Vec3(0.0, 0.0, -0.005);
  const BodyId ball = world.add_body(def);
  contacts.ball_on_plane(wall, Vec3::UnitZ(), 0.0, ball, 0.5, {});
  Solver solver;
  run(world, solver, 2.0);
  REQUIRE_FALSE(world.contacts()->empty());  // it is near enough to be seen
  CHECK(world.pose(ball).position.z() == Approx(0.505).epsilon(1e-9));
  run(world, solver, 2.0);
  CHECK(world.pose(ball).position.z() == Approx(0.5).margin(1e-4));
}

TEST_CASE("sleep: bodies that a block held wake and fall when it is removed",
          "[pbd][sleep][analytic]") {
  // Its rows name the body, or did so since the last step.
  const bool emptied = GENERATE(false, true);
  CAPTURE(emptied);
  World world;
  auto& rods = world.add_block<DistanceJoints>();
  auto& balls = world.add_block<JointBlock>();
  const auto hang = [&](double x) {
    return world.add_body(box_def(1.0, kHalf, Vec3(x, 0.0, 0.0)));
  };
  const BodyId held = hang(0.0);
  const BodyId joined = hang(1.0);
  const BodyId apart = hang(5.0);
  const JointId joint = balls.add(world, fixed_joint_at(world, {}, held, Vec3::Zero()));
  rods.add(world, {.a = held, .b = joined, .rest_length = 1.0});
  auto& more = world.add_block<JointBlock>();
  more.add(world, fixed_joint_at(world, {}, joined, Vec3(1.0, 0.0, 0.0)));
  more.add(world, fixed_joint_at(world, {}, apart, Vec3(5.0, 0.0, 0.0)));
  Solver solver;
  run(world, solver, 3.0);
  for (const BodyId id : {held, joined, apart}) REQUIRE_FALSE(world.awake(id));
  const Vec3 start = world.pose(held).position;

  if (emptied) balls.remove(joint);
  world.remove_block(balls);
  CHECK(world.awake(held));
  CHECK_FALSE(world.awake(apart));
  solver.step(world, kFrame);
  CHECK(world.awake(joined));  // what the others join to it wakes with it
  CHECK_FALSE(world.awake(apart));
  run(world, solver, 0.2);
  CHECK(world.pose(held).position.z() < start.z() - 0.1);
  CHECK(world.pose(apart).position.z() == Approx(0.0).margin(1e-5));
}

}  // namespace sleep_test
