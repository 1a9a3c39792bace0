// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// E4: a long thin body in fast spin gains no energy, and precesses correctly.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "everyday/any_world.h"
#include "everyday/ground.h"
#include "everyday/group.h"

namespace tandem::everyday {
namespace {

/// A cylinder or capsule that starts with its axis along x.
struct Rod {
  bool capsule = false;
  double radius = 0.005;  ///< m
  double length = 0.6;    ///< m, caps included
};

collision::Shape shape_of(const Rod& rod) {
  if (rod.capsule) return Capsule{rod.radius, 0.5 * rod.length - rod.radius};
  return Cylinder{rod.radius, 0.5 * rod.length};
}

const Quat kAlongX(Eigen::AngleAxisd(std::numbers::pi / 2.0, Vec3::UnitY()));

struct Motion {
  double most_kinetic = 0.0;  ///< J
  double gain = 0.0;          ///< J, over the start
};

Motion run(const bench::MakeEngine& peer, const Rod& rod, Ground ground, const Pose& pose,
           const pbd::Twist& twist, double seconds) {
  const auto world = make_world(peer);
  AnyWorld& scene = *world;
  add_ground(scene, ground, 0.5, 100.0);
  scene.add(shape_of(rod), {.pose = pose, .twist = twist});
  const double start = scene.mechanical_energy();
  Motion motion{.most_kinetic = scene.kinetic_energy()};
  for (double t = 0.0; t < seconds; t += kFrame) {
    scene.step(kFrame);
    // Kinetic energy may itself be wrong later, so it is bounded by the initial energy.
    motion.gain = std::max(motion.gain, scene.mechanical_energy() - start);
    motion.most_kinetic = std::max(motion.most_kinetic, std::min(scene.kinetic_energy(), start));
    if (!std::isfinite(motion.gain)) return {1.0, HUGE_VAL};
  }
  return motion;
}

void note(Tally& tally, const Motion& motion, const std::string& which) {
  tally.at_most("energy gained", 100.0 * motion.gain / motion.most_kinetic, 1.0, "%", which);
}

std::vector<double> phases_of(Extent extent, int count) {
  std::vector<double> phases;
  const int few = extent == Extent::Full ? count : 4;
  for (int i = 0; i < few; ++i) phases.push_back(static_cast<double>(i) / few);
  return phases;
}

/// Rolls along y with some yaw; length over radius from 2 to 200.
void rolling(Tally& tally, Extent extent, const bench::MakeEngine& peer, Ground ground) {
  std::vector<Rod> rods = {{false, 0.005, 0.6}};
  if (extent == Extent::Full) {
    rods = {{false, 0.005, 0.6}, {false, 0.0035, 0.18}, {false, 0.0125, 1.5}, {false, 0.02, 1.2},
            {false, 0.1, 0.6},   {false, 0.1, 0.2},     {false, 0.005, 1.0},  {true, 0.005, 0.6},
            {true, 0.1, 0.3},    {true, 0.02, 1.2}};
  }
  for (const Rod& rod : rods) {
    for (const double speed :
         extent == Extent::Full ? std::vector{0.3, 1.0, 3.0, 10.0} : std::vector{1.0}) {
      for (const double yaw :
           extent == Extent::Full ? std::vector{0.0, 0.5, 5.0} : std::vector{0.5}) {
        for (const double phase : phases_of(extent, 4)) {
          const Pose pose{.position = Vec3(0.0, speed * kFrame * phase, rod.radius),
                          .orientation = Quat(Eigen::AngleAxisd(phase, Vec3::UnitZ())) * kAlongX};
          const Vec3 across = Quat(Eigen::AngleAxisd(phase, Vec3::UnitZ())) * Vec3::UnitY();
          const Vec3 along = Quat(Eigen::AngleAxisd(phase, Vec3::UnitZ())) * Vec3::UnitX();
          const pbd::Twist twist{.linear = speed * across,
                                 .angular = -speed / rod.radius * along + yaw * Vec3::UnitZ()};
          note(tally, run(peer, rod, ground, pose, twist, 3.0),
               told({{"radius", rod.radius},
                     {"length", rod.length},
                     {"speed", speed},
                     {"yaw", yaw},
                     {"phase", phase}}));
        }
      }
    }
  }
}

/// Thrown at 3 m/s, tumbling end over end and about an oblique axis.
void thrown(Tally& tally, Extent extent, const bench::MakeEngine& peer, Ground ground) {
  const std::vector<double> spins =
      extent == Extent::Full ? std::vector{10.0, 40.0, 80.0, 150.0} : std::vector{40.0};
  for (const double spin : spins) {
    for (const double phase : phases_of(extent, 60)) {
      const double turn = 2.0 * std::numbers::pi * phase;
      const Pose pose{
          .position = Vec3(0.0, 0.0, 1.0 + 0.05 * phase),
          .orientation = Quat(Eigen::AngleAxisd(turn, Vec3(0.3, 1.0, 0.2).normalized())) * kAlongX};
      const Vec3 axis = Vec3(std::cos(turn), std::sin(turn), 0.5).normalized();
      const pbd::Twist twist{.linear = Vec3(3.0, 0.0, 0.0), .angular = spin * axis};
      note(tally, run(peer, {false, 0.02, 1.2}, ground, pose, twist, 3.0),
           told({{"spin", spin}, {"phase", phase}}));
    }
  }
}

/// A roller of 20 x 60 cm dropped while it spins about its own axis.
void dropped(Tally& tally, Extent extent, const bench::MakeEngine& peer, Ground ground) {
  for (const double phase : phases_of(extent, 60)) {
    const Quat tilt(Eigen::AngleAxisd(0.6 * (phase - 0.5), Vec3::UnitY()));
    const Pose pose{.position = Vec3(0.0, 0.0, 0.4 + 0.05 * phase), .orientation = tilt * kAlongX};
    const pbd::Twist twist{.angular = 200.0 * (tilt * Vec3::UnitX())};
    note(tally, run(peer, {false, 0.1, 0.6}, ground, pose, twist, 3.0), told({{"phase", phase}}));
  }
}

/// Speed left of 1 m/s after 5 s.
void dowel(Tally& tally, Extent extent, const bench::MakeEngine& peer, Ground ground) {
  for (const double phase : phases_of(extent, 12)) {
    const auto world = make_world(peer);
    AnyWorld& scene = *world;
    add_ground(scene, ground, 0.5, 100.0);
    SolidDef def{.pose = {.position = Vec3(0.0, phase * kFrame, 0.005), .orientation = kAlongX}};
    def.twist = {.linear = Vec3(0.0, 1.0, 0.0), .angular = Vec3(-200.0, 0.0, 0.5)};
    const BodyId body = scene.add(Cylinder{0.005, 0.3}, def);
    for (int i = 0; i < 300; ++i) scene.step(kFrame);
    tally.at_most("speed changed in 5 s", 100.0 * std::abs(1.0 - scene.twist(body).linear.norm()),
                  3.0, "%", told({{"phase", phase}}));
  }
}

/// Torque-free: the axis precesses about the angular momentum at |L| / I_across.
void precession(Tally& tally, const bench::MakeEngine& peer) {
  for (const double spin : {20.0, 60.0, 200.0}) {
    const auto world = make_world(peer, {.gravity = Vec3::Zero()});
    AnyWorld& scene = *world;
    SolidDef def{.pose = {.orientation = kAlongX}};
    const Vec3 axis = Vec3::UnitX();
    def.twist.angular = spin * axis + 0.5 * Vec3::UnitY();
    const BodyId body = scene.add(Cylinder{0.02, 0.3}, def);
    const collision::MassProperties mass = mass_properties(Cylinder{0.02, 0.3}, def.density);
    const Vec3 momentum(mass.inertia(2, 2) * spin, mass.inertia(0, 0) * 0.5, 0.0);
    double off = 0.0;
    for (int i = 1; i <= 60; ++i) {
      scene.step(kFrame);
      const double turn = momentum.norm() / mass.inertia(0, 0) * i * kFrame;
      const Vec3 right = Eigen::AngleAxisd(turn, momentum.normalized()) * axis;
      off = std::max(off, 0.3 * (scene.pose(body).orientation * Vec3::UnitZ() - right).norm());
    }
    tally.at_most("tip off within 1 s", 1e3 * off, 1.0, "mm", told({{"spin", spin}}));
  }
}

}  // namespace

std::vector<Group> spin_groups(const bench::MakeEngine& peer) {
  std::vector<Group> groups;
  const auto add = [&](const char* name, auto run) {
    for (const Ground ground : kGrounds) {
      groups.push_back({"E4", name, name_of(ground),
                        [=](Tally& tally, Extent extent) { run(tally, extent, peer, ground); },
                        ground == Ground::Box || ground == Ground::Mesh});
    }
  };
  add("rods and pencils roll", rolling);
  add("thrown rods", thrown);
  add("rollers dropped at 200 rad/s", dropped);
  add("dowel rolls at 1 m/s", dowel);
  groups.push_back({"E4", "rod in free precession", "none",
                    [=](Tally& tally, Extent) { precession(tally, peer); }, true});
  return groups;
}

}  // namespace tandem::everyday
