// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include <random>

#include "joint_fixture.h"
#include "support/catch.h"
#include "tandem/pbd/math.h"

/// Friction, limits and cones take energy: what a joint has of them adds none, whatever it is
/// joined with.
namespace joint_energy_test {

using namespace tandem::pbd;
using namespace tandem::testing;

constexpr double kDegree = std::numbers::pi / 180.0;

class Draw {
 public:
  explicit Draw(unsigned seed) : random_(seed) {}
  double from(double low, double high) {
    return low + (high - low) * (static_cast<double>(random_()) / 4294967296.0);
  }
  double decades(double low, double high) { return std::exp(from(std::log(low), std::log(high))); }
  int below(int count) { return static_cast<int>(from(0.0, count)); }
  bool chance(double part) { return from(0.0, 1.0) < part; }
  Vec3 vector(double size) { return {from(-size, size), from(-size, size), from(-size, size)}; }

 private:
  std::mt19937 random_;
};

JointMotor friction(double torque) {
  return {.mode = MotorMode::Velocity, .target = 0.0, .max_force = torque};
}

/// Rods that are joined end to end or in a tree.
struct Assembly {
  World world;
  JointBlock* joints = nullptr;
  std::vector<BodyId> bodies;
  double length = 0.5;  ///< m, of a rod

  explicit Assembly(const WorldDef& def = {})
      : world(def), joints(&world.add_block<JointBlock>()) {}
  /// A rod of that mass that begins at `from`, along `along`, and turns about its beginning by w.
  void add_rod(double mass, const Vec3& from, const Vec3& along, const Vec3& w) {
    const double r = 0.12 * length;
    const double across = mass * (length * length / 12.0 + r * r / 4.0);
    const Quat q = Quat::FromTwoVectors(Vec3::UnitX(), along);
    const Vec3 middle = q * Vec3(0.5 * length, 0.0, 0.0);
    BodyDef def;
    def.mass = mass;
    def.inertia = Vec3(0.5 * mass * r * r, across, across).asDiagonal();
    def.pose = {from + middle, q};
    def.twist = {w.cross(middle), w};
    bodies.push_back(world.add_body(def));
  }
  Vec3 end_of(BodyId body) const { return world.pose(body).to_world(Vec3(0.5 * length, 0.0, 0.0)); }
  SixDofJointDef ball(BodyId a, BodyId b, const Vec3& at, const Vec3& axis) const {
    SixDofJointDef def = six_dof_joint_at(world, a, b, at, axis);
    for (JointAxis& linear : def.linear) linear = {.freedom = Freedom::Locked};
    return def;
  }
};

struct Gain {
  double energy = 0.0;  ///< J, above the start
  double range = 0.0;   ///< J, of the total energy, and of the kinetic energy
  bool ok = true;       ///< every step is
};

Gain energy_of(World& world, const SolverOptions& options, double dt, double seconds) {
  Solver solver(options);
  const double start = world.mechanical_energy();
  double most = start;
  double least = start;
  double most_kinetic = world.kinetic_energy();
  Gain gain;
  for (int i = 0; i < static_cast<int>(seconds / dt); ++i) {
    gain.ok = gain.ok && solver.step(world, dt).status == StepStatus::Ok;
    const double energy = world.mechanical_energy();
    most = std::max(most, energy);
    least = std::min(least, energy);
    most_kinetic = std::max(most_kinetic, world.kinetic_energy());
    if (most - start > 10.0 * (start - least + 1.0)) break;  // lost already
  }
  gain.energy = most - start;
  gain.range = std::max(most - least, most_kinetic);
  return gain;
}

TEST_CASE("joint: friction of ball joints only takes energy as it turns from stick to slip",
          "[pbd][joint][property]") {
  struct Case {
    int links;
    double torque;  // N m
    double cone;    // rad
    double twist;   // rad
  };
  const auto [links, torque, cone, twist] =
      GENERATE(Case{2, 2.0, kUnlimited, kUnlimited}, Case{2, 2.0, 25.0 * kDegree, 15.0 * kDegree},
               Case{2, 5.0, 25.0 * kDegree, 15.0 * kDegree},
               Case{3, 5.0, 25.0 * kDegree, kUnlimited}, Case{8, 5.0, kUnlimited, kUnlimited});
  const unsigned seed = GENERATE(range(1u, 9u));
  INFO(links << " links, " << torque << " N m, cone " << cone << ", seed " << seed);
  Draw draw(seed);
  Assembly chain;
  BodyId before;
  for (int i = 0; i < links; ++i) {
    const Vec3 anchor(0.0, 0.0, -chain.length * i);
    chain.add_rod(3.6, anchor, -Vec3::UnitZ(), draw.vector(30.0));
    SixDofJointDef def =
        chain.ball(before, chain.bodies.back(), anchor, draw.vector(1.0).normalized());
    for (JointAxis& axis : def.angular) axis.motor = friction(torque);
    def.cone = cone;
    if (twist < kUnlimited) {
      def.angular[0].freedom = Freedom::Limited;
      def.angular[0].lower = -twist;
      def.angular[0].upper = twist;
    }
    chain.joints->add(chain.world, def);
    before = chain.bodies.back();
  }
  const Gain gain = energy_of(chain.world, {.sleep_after = 0.0}, 1.0 / 60.0, 5.0);
  CHECK(gain.ok);
  CHECK(gain.energy < 1e-3 * gain.range);
}

/// A random chain or tree with friction, limits and cones.
Gain random_assembly(unsigned seed, bool brakes, bool limits, bool light) {
  Draw draw(seed);
  Assembly set;
  set.length = draw.decades(0.1, 1.0);
  const bool tree = draw.chance(0.4);
  const double torque = draw.decades(0.1, 1000.0);
  const double mass = draw.decades(0.1, 10.0);
  const double spin = draw.decades(0.5, 50.0);
  const int count = 2 + draw.below(7);
  const bool held = draw.chance(0.7);
  const auto brake = [&](JointAxis& axis) {
    if (brakes && draw.chance(0.8)) axis.motor = friction(torque * draw.from(0.2, 1.0));
  };
  const auto stop = [&](JointAxis& axis, double size) {
    if (limits && draw.chance(0.8)) {
      axis.freedom = Freedom::Limited;
      axis.lower = -draw.from(0.05, 1.0) * size;
      axis.upper = draw.from(0.05, 1.0) * size;
    }
  };
  for (int i = 0; i < count; ++i) {
    const BodyId parent =
        i == 0 ? BodyId{} : set.bodies[static_cast<std::size_t>(tree ? draw.below(i) : i - 1)];
    double own = mass * draw.decades(0.3, 3.0);
    if (light) own = i % 2 == 0 ? draw.decades(0.001, 0.1) : 10.0;
    const Vec3 from = i == 0 ? Vec3(Vec3::Zero()) : set.end_of(parent);
    const Vec3 w = draw.vector(0.6 * spin);
    set.add_rod(own, from, draw.vector(1.0).normalized(), w);
    if (i == 0 && !held) continue;
    SixDofJointDef def = set.ball(parent, set.bodies.back(), from, draw.vector(1.0).normalized());
    const int kind = draw.below(3);
    if (kind == 0) {
      for (JointAxis& axis : def.angular) brake(axis);
      if (limits) def.cone = draw.from(0.1, 1.2);
      stop(def.angular[0], 0.6);
    } else if (kind == 1) {
      def.angular[1] = def.angular[2] = {.freedom = Freedom::Locked};
      brake(def.angular[0]);
      stop(def.angular[0], 0.8);
    } else {
      def.angular.fill({.freedom = Freedom::Locked});
      def.linear[0] = {};
      brake(def.linear[0]);
      stop(def.linear[0], set.length);
    }
    set.joints->add(set.world, def);
  }
  constexpr std::array<int, 4> kSubsteps{2, 4, 8, 32};
  constexpr std::array<double, 4> kRates{30.0, 60.0, 120.0, 240.0};
  const SolverOptions options{.substeps = kSubsteps[static_cast<std::size_t>(draw.below(4))],
                              .sleep_after = 0.0};
  const double dt = 1.0 / kRates[static_cast<std::size_t>(draw.below(4))];
  return energy_of(set.world, options, dt, 2.0);
}

TEST_CASE("joint: chains and trees with friction, limits and cones only lose energy",
          "[pbd][joint][property]") {
  const bool brakes = GENERATE(false, true);
  const bool limits = GENERATE(false, true);
  const bool light = GENERATE(false, true);
  if (!brakes && !limits) return;
  for (unsigned seed = 1; seed <= 12; ++seed) {
    INFO("seed " << seed << ", friction " << brakes << ", limits " << limits << ", light "
                 << light);
    const Gain gain = random_assembly(seed, brakes, limits, light);
    CHECK(gain.ok);
    CHECK(gain.energy < 1e-3 * gain.range);  // of 200 other ones three gain more
  }
}

TEST_CASE("joint: two limits with a light link between them come to rest together",
          "[pbd][joint][property]") {
  WorldDef tilted;
  tilted.gravity = Vec3(4.0, 3.0, -8.0);
  Assembly waist(tilted);
  BodyDef link;
  link.mass = 0.09;
  link.inertia = Vec3::Constant(7e-6).asDiagonal();
  const BodyId yaw = waist.world.add_body(link);
  BodyDef torso;
  torso.mass = 8.0;
  torso.inertia = Vec3::Constant(0.08).asDiagonal();
  torso.pose.position = Vec3(0.1, 0.16, 0.43);
  const BodyId top = waist.world.add_body(torso);
  HingeJointDef first = hinge_joint_at(waist.world, {}, yaw, Vec3::Zero(), Vec3::UnitZ());
  first.axis = limit(-30.0 * kDegree, 30.0 * kDegree);
  HingeJointDef second =
      hinge_joint_at(waist.world, yaw, top, Vec3(0.0, 0.15, 0.25), Vec3::UnitX());
  second.axis = first.axis;
  waist.joints->add(waist.world, first);
  waist.joints->add(waist.world, second);
  const Gain gain = energy_of(waist.world, {.sleep_after = 0.0}, 1.0 / 240.0, 4.0);
  CHECK(gain.ok);
  CHECK(gain.energy < 1e-3 * gain.range);
}

TEST_CASE("joint: friction takes energy through half a turn of swing as well",
          "[pbd][joint][property]") {
  const double sideways = GENERATE(0.0, 0.01, 0.3);
  Assembly bar(weightless());
  bar.add_rod(1.0, Vec3::Zero(), Vec3::UnitX(), Vec3(sideways, 8.0, 0.0));
  SixDofJointDef def = bar.ball({}, bar.bodies[0], Vec3::Zero(), Vec3::UnitX());
  for (JointAxis& axis : def.angular) axis.motor = friction(0.2);
  bar.joints->add(bar.world, def);
  const Gain gain = energy_of(bar.world, {.sleep_after = 0.0}, 1.0 / 60.0, 5.0);
  CHECK(gain.ok);
  CHECK(gain.energy < 1e-3 * gain.range);
}

}  // namespace joint_energy_test
