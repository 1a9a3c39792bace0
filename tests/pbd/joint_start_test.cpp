// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <random>

#include "joint_fixture.h"
#include "support/catch.h"
#include "tandem/pbd/distance_joint.h"
#include "tandem/pbd/math.h"

/// Joints that are violated before a step, by whatever is done between steps.
namespace joint_start_test {

using namespace tandem::pbd;
using namespace tandem::testing;

constexpr double kDegree = std::numbers::pi / 180.0;

class Draw {
 public:
  explicit Draw(unsigned seed) : random_(seed) {}
  double from(double low, double high) {
    return low + (high - low) * (static_cast<double>(random_()) / 4294967296.0);
  }
  int below(int count) { return static_cast<int>(from(0.0, count)); }
  Vec3 vector(double size) { return {from(-size, size), from(-size, size), from(-size, size)}; }
  Quat turn() { return exp_map(vector(2.0)); }

 private:
  std::mt19937 random_;
};

enum Kind { kHinge, kSlider, kBall, kSixDof, kFixed, kKinds };
enum Way { kAdded, kMoved, kLimited, kWays };

/// A joint of any kind and how it is violated.
struct Start {
  SixDofJointDef def;
  Pose frame;  ///< of frame b in frame a, at the start

  Start(Draw& draw, Kind kind) {
    const double lower = draw.from(-5.0, 5.0);
    const JointAxis turn = limit(lower, lower + draw.from(0.0, 4.0));
    const JointAxis slide = limit(-draw.from(0.0, 0.5), draw.from(0.0, 0.5));
    def.linear.fill({.freedom = Freedom::Locked});
    def.angular.fill({.freedom = Freedom::Locked});
    if (kind == kHinge) def.angular[0] = turn;
    if (kind == kSlider) def.linear[0] = slide;
    if (kind == kBall) {
      def.angular = {turn, JointAxis{}, JointAxis{}};
      def.cone = draw.from(0.1, 1.0);
    }
    if (kind == kSixDof) {
      def.linear.fill(slide);
      def.angular[0] = limit(-draw.from(0.0, 1.0), draw.from(0.0, 1.0));
      def.angular[1] = def.angular[2] = limit(-draw.from(0.1, 0.7), draw.from(0.1, 0.7));
    }
    const double twist = draw.from(-3.0, 3.0);
    Vec3 swing(0.0, draw.from(-1.0, 1.0), draw.from(-1.0, 1.0));
    frame.orientation = exp_map(swing) * exp_map(twist * Vec3::UnitX());
    frame.position = draw.vector(std::pow(10.0, draw.from(-3.0, 1.0)));
  }
};

struct Worst {
  double speed = 0.0;     ///< m/s, of velocities
  double spin = 0.0;      ///< rad/s
  double move = 0.0;      ///< m/s, of poses
  double turn = 0.0;      ///< rad/s
  double residual = 0.0;  ///< m or rad, at the end
};

Pose times(const Pose& l, const Pose& r) {
  return {l.position + l.orientation * r.position, l.orientation * r.orientation};
}
Pose inverse(const Pose& p) {
  const Quat q = p.orientation.conjugate();
  return {q * -p.position, q};
}

Worst close(Draw& draw, Kind kind, Way way) {
  Start start(draw, kind);
  const int kSubsteps[] = {1, 3, 10, 20};
  const double kSteps[] = {1.0 / 30.0, 1.0 / 60.0, 1.0 / 240.0};
  const double dt = kSteps[draw.below(3)];
  World world(weightless());
  Solver solver({.substeps = kSubsteps[draw.below(4)]});
  auto& joints = world.add_block<JointBlock>();
  const auto box = [&](const Vec3& at) {
    return world.add_body(box_def(std::pow(10.0, draw.from(-1.0, 1.0)), draw.from(0.3, 2.0) * kHalf,
                                  at, draw.turn()));
  };
  SixDofJointDef& def = start.def;
  def.b = box(draw.vector(1.0));
  if (draw.below(2) == 0) def.a = box(draw.vector(1.0));
  def.frame_a = {draw.vector(0.5), draw.turn()};
  def.frame_b = {draw.vector(0.5), draw.turn()};
  const Pose frame_a{def.frame_a.anchor, def.frame_a.basis};
  const Pose pose_a = def.a.valid() ? times(world.pose(def.a), frame_a) : frame_a;
  const Pose frame_b = inverse({def.frame_b.anchor, def.frame_b.basis});
  const auto put = [&](const Pose& frame) {
    world.set_pose(def.b, times(times(pose_a, frame), frame_b));
  };
  if (way == kAdded) {
    put(start.frame);
    joints.add(world, def);
  } else if (way == kMoved) {
    const double middle = def.angular[0].freedom == Freedom::Limited
                              ? 0.5 * (def.angular[0].lower + def.angular[0].upper)
                              : 0.0;
    put({Vec3::Zero(), exp_map(middle * Vec3::UnitX())});
    joints.add(world, def);
    for (int i = 0; i < 3; ++i) solver.step(world, dt);
    put(start.frame);
  } else {
    put(start.frame);
    SixDofJointDef free = def;
    free.linear.fill({});
    free.angular.fill({});
    free.cone = kUnlimited;
    const JointId id = joints.add(world, free);
    for (int i = 0; i < 3; ++i) solver.step(world, dt);
    joints.set(world, id, def);
  }
  Worst worst;
  for (double t = 0.0; t < 10.0 && (t < 1.0 || worst.residual > 1e-9); t += dt) {
    const Pose before[] = {world.pose(def.b), def.a.valid() ? world.pose(def.a) : Pose{}};
    REQUIRE(solver.step(world, dt).status == StepStatus::Ok);
    int i = 0;
    for (const BodyId id : {def.b, def.a}) {
      if (!id.valid()) continue;
      const Pose& was = before[i++];
      const Pose& is = world.pose(id);
      worst.speed = std::max(worst.speed, world.twist(id).linear.norm());
      worst.spin = std::max(worst.spin, world.twist(id).angular.norm());
      worst.move = std::max(worst.move, (is.position - was.position).norm() / dt);
      worst.turn =
          std::max(worst.turn, rotation_between(was.orientation, is.orientation).norm() / dt);
    }
    worst.residual = joints.at(joint_ids(joints)[0]).residual;
  }
  return worst;
}

TEST_CASE("joint start: a violation closes at a bounded speed and leaves no velocity",
          "[pbd][joint][property]") {
  for (int kind = 0; kind < kKinds; ++kind) {
    for (int way = 0; way < kWays; ++way) {
      for (unsigned seed = 0; seed < 12; ++seed) {
        Draw draw(100u * seed + 10u * static_cast<unsigned>(kind) + static_cast<unsigned>(way));
        const Worst worst = close(draw, static_cast<Kind>(kind), static_cast<Way>(way));
        INFO("kind " << kind << ", way " << way << ", seed " << seed);
        CHECK(worst.speed < 1e-5);
        CHECK(worst.spin < 1e-5);
        CHECK(worst.move < 5.0 + 1e-4);
        CHECK(worst.turn < 10.0 + 1e-4);
        CHECK(worst.residual < 1e-6);
      }
    }
  }
}

/// A hinge along y through the middle of the world, and an arm of 0.6 m at an angle from x.
struct Arm : Mounted {
  Arm(double lower, double upper, double angle, const WorldDef& def = {}, double start = 0.0)
      : Mounted(def) {
    const Quat turn = exp_map(angle * Vec3::UnitY());
    add_box(1.0, turn * Vec3(0.6, 0.0, 0.0), turn);
    HingeJointDef hinge;
    hinge.b = body;
    hinge.frame_a.basis = hinge.frame_b.basis = exp_map(0.5 * std::numbers::pi * Vec3::UnitZ());
    hinge.frame_b.anchor = Vec3(-0.6, 0.0, 0.0);
    hinge.axis = limit(lower, upper);
    hinge.start = start;
    add_joint(hinge);
  }
  double angle() const { return joints->hinge_angle(joint); }
};

TEST_CASE("joint start: a hinge takes the turn that lies within its limits", "[pbd][joint]") {
  struct Case {
    double lower, upper, at, is;  // degrees
  };
  const Case kCases[] = {{170, 190, 181, 181},    {170, 190, -179, 181}, {0, 270, 200, 200},
                         {-270, 0, 160, -200},    {-720, 720, 100, 100}, {-720, 720, 200, -160},
                         {700, 740, 10, 730},     {0, 270, 300, 270},    {0, 270, 330, 0},
                         {-190, -170, 179, -181}, {350, 1000, 355, 355}, {30, 330, 0, 30}};
  for (const Case& c : kCases) {
    INFO("[" << c.lower << ", " << c.upper << "] at " << c.at);
    Arm arm(c.lower * kDegree, c.upper * kDegree, c.at * kDegree, weightless());
    // Told as it is added: on the turn that it goes on with.
    const double told = arm.angle();
    CHECK(std::remainder(told - c.at * kDegree, 2.0 * std::numbers::pi) ==
          Approx(0.0).margin(1e-12));
    CHECK(std::abs(told - c.is * kDegree) < 60.1 * kDegree);
    arm.run(1.5, [&] { CHECK(arm.world.twist(arm.body).angular.norm() < 1e-6); });
    CHECK(arm.angle() == Approx(c.is * kDegree).margin(1e-6));
  }
}

TEST_CASE("joint start: of turns within its limits a hinge takes the one it is told",
          "[pbd][joint]") {
  struct Case {
    double lower, upper, at, start, is;  // degrees
  };
  const Case kCases[] = {{-720, 720, 400, 400, 400},    {-720, 720, 40, 400, 400},
                         {-720, 720, 40, -300, -320},   {-720, 720, 40, 700, 400},
                         {-720, 720, 181, 181, 181},    {170, 190, 181, 900, 181},
                         {-1e9, 1e9, 10, 36000, 36010}, {350, 1000, 355, 800, 715}};
  for (const Case& c : kCases) {
    INFO("[" << c.lower << ", " << c.upper << "] at " << c.at << ", told " << c.start);
    Arm arm(c.lower * kDegree, c.upper * kDegree, c.at * kDegree, weightless(), c.start * kDegree);
    CHECK(arm.angle() == Approx(c.is * kDegree).margin(1e-9));
    arm.run(0.5);
    CHECK(arm.angle() == Approx(c.is * kDegree).margin(1e-9));
    World other;
    const auto& joints = other.add_block<JointBlock>();
    other.restore(arm.world.snapshot());
    CHECK(joints.hinge_angle(joint_ids(joints)[0]) == arm.angle());
    CHECK(joints.def(joint_ids(joints)[0]).start == c.start * kDegree);
  }
}

TEST_CASE("joint start: a snapshot keeps the turn and the gap", "[pbd][joint]") {
  for (const double at : {200.0, 290.0, 320.0}) {
    for (const int steps : {0, 1, 5}) {
      INFO("at " << at << ", after " << steps << " steps");
      Arm arm(0.0, 270.0 * kDegree, at * kDegree);
      for (int i = 0; i < steps; ++i) arm.solver.step(arm.world, kFrame);
      World other;
      auto& joints = other.add_block<JointBlock>();
      other.restore(arm.world.snapshot());
      for (int i = 0; i < 30; ++i) {
        arm.solver.step(arm.world, kFrame);
        arm.solver.step(other, kFrame);
      }
      CHECK(other.hash() == arm.world.hash());
      CHECK(joints.hinge_angle(joint_ids(joints)[0]) == arm.angle());
    }
  }
}

TEST_CASE("joint start: a load on the limit comes back with it, and rests", "[pbd][joint]") {
  // Gravity pulls it further out; the limit lies 57 degrees above.
  for (const double out : {0.01, 0.1, 0.5, 1.0}) {
    INFO("by " << out);
    Arm arm(-3.0, 0.0, out);
    arm.run(0.5, [&] { CHECK(arm.world.twist(arm.body).angular.norm() < 1e-3); });
    CHECK(arm.angle() == Approx(0.0).margin(1e-6));
  }
}

TEST_CASE("joint start: a gap that has closed costs nothing more while its bodies move",
          "[pbd][joint]") {
  // A chain that tumbles, first open by 5 cm.
  World world(weightless());
  auto& joints = world.add_block<JointBlock>();
  BodyId before;
  for (int i = 0; i < 4; ++i) {
    BodyDef def = box_def(1.0, Vec3(0.2, 0.1, 0.1), Vec3(0.5 * i, 0.0, 0.0));
    def.twist.angular = Vec3(1.0, 2.0, 3.0 * i);
    const BodyId link = world.add_body(def);
    if (before.valid()) {
      BallJointDef ball;
      ball.a = before;
      ball.b = link;
      ball.frame_a.anchor = Vec3(0.25, 0.0, 0.0);
      ball.frame_b.anchor = Vec3(-0.25, 0.0, i == 1 ? 0.05 : 0.0);
      joints.add(world, ball);
    }
    before = link;
  }
  Solver solver({.sleep_after = 0.0});
  const auto displaced = [&] {
    return solver.step(world, kFrame).ran[static_cast<std::size_t>(Stage::Agree)];
  };
  CHECK(displaced());
  for (int i = 0; i < 60; ++i) displaced();
  for (int i = 0; i < 120; ++i) CHECK_FALSE(displaced());
}

TEST_CASE("joint start: a limit holds in steps in which nothing moves by the tolerance",
          "[pbd][joint]") {
  Arm arm(-3.0, 0.0, 0.0);
  Solver coarse({.substeps = 10, .joint_tolerance = 1e-3, .sleep_after = 0.0});
  for (int i = 0; i < 60; ++i) coarse.step(arm.world, kFrame);
  CHECK(arm.world.twist(arm.body).angular.norm() < 1e-3);
  CHECK(arm.angle() == Approx(0.0).margin(1e-5));
}

TEST_CASE("joint start: a limit that is met at speed stops the motion", "[pbd][joint]") {
  // Not by displacement: it has to stop within the step.
  Arm arm(-3.0, 0.5, -1.0);
  double beyond = 0.0;
  arm.run(2.0, [&] { beyond = std::max(beyond, arm.angle() - 0.5); });
  CHECK(beyond < 1e-5);
  CHECK(arm.angle() == Approx(0.5).margin(1e-5));
}

TEST_CASE("joint start: a rod with ends too far apart closes without velocity",
          "[pbd][joint][property]") {
  for (unsigned seed = 0; seed < 20; ++seed) {
    INFO("seed " << seed);
    Draw draw(seed);
    World world(weightless());
    Solver solver({.substeps = 1 + draw.below(10)});
    auto& rods = world.add_block<DistanceJoints>();
    DistanceJoint::Def def;
    const bool ranged = draw.below(2) == 0;
    def.elastic = !ranged;
    def.rest_length = draw.from(0.1, 1.0);
    if (ranged) def.max_length = def.rest_length;
    def.anchor_a_l = draw.vector(0.3);
    def.anchor_b_l = draw.vector(0.3);
    const Vec3 apart = draw.turn() * Vec3(std::pow(10.0, draw.from(0.3, 1.0)), 0.0, 0.0);
    def.b = world.add_body(box_def(draw.from(0.1, 10.0), kHalf, apart, draw.turn()));
    if (draw.below(2) == 0) def.a = world.add_body(box_def(1.0, kHalf, Vec3::Zero(), draw.turn()));
    const ConstraintId id = rods.add(world, def);
    for (int i = 0; i < 600; ++i) {
      const Pose before = world.pose(def.b);
      solver.step(world, kFrame);
      const Twist& twist = world.twist(def.b);
      REQUIRE(twist.linear.norm() + twist.angular.norm() < 1e-5);
      const Pose& after = world.pose(def.b);
      REQUIRE((after.position - before.position).norm() < 5.0 * kFrame + 1e-6);
      REQUIRE(rotation_between(before.orientation, after.orientation).norm() <
              10.0 * kFrame + 1e-6);
    }
    CHECK(rods.at(id).residual() < 1e-6);
  }
}

}  // namespace joint_start_test
