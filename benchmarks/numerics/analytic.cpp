// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Bodies without contacts: falling, flying, spinning.
#include "numerics/case.h"
#include "numerics/track.h"

namespace tandem::bench {
namespace {

/// Position after `steps` steps of v += h g, x += h v.
Vec3 discrete_fall(const Pose& start, const Vec3& velocity, double h, int steps) {
  const double n = steps;
  return start.position + n * h * velocity + Vec3(0.0, 0.0, -kGravity * h * h * n * (n + 1) / 2.0);
}

void fall(Sheet& sheet, const Vec3& velocity) {
  Scene scene;
  const int ball = scene.add(SphereShape{0.1}, 1.0, at(0.0, 0.0, 1000.0));
  scene.bodies.back().twist.linear = velocity;
  const auto engine = sheet.make(scene);
  run_scene(scene, *engine);
  const int substeps = engine->stats().substeps;
  const Vec3 expected =
      discrete_fall(scene.bodies[0].pose, velocity, scene.dt / substeps, scene.frames() * substeps);
  const Vec3 moved = engine->state(ball).pose.position - scene.bodies[0].pose.position;
  const Vec3 way = expected - scene.bodies[0].pose.position;
  sheet.relative("way after 10 s", moved.norm(), way.norm(), 1e-9, "difference equation");
  sheet.at_most("off the way, of its length", (moved - way).norm() / way.norm(), 1e-9, "",
                "difference equation");
}

void fall_order(Sheet& sheet) {
  Scene scene;
  scene.seconds = 1.0;
  const int ball = scene.add(SphereShape{0.1}, 1.0, at(0.0, 0.0, 0.0));
  const auto error = [&](int substeps) {
    const auto engine = sheet.make(scene, {.substeps = substeps});
    run_scene(scene, *engine);
    return std::abs(engine->state(ball).pose.position.z() + 0.5 * kGravity);
  };
  const double order = std::log2(error(2) / error(16)) / 3.0;
  sheet.at_least("order in the step, 2 to 16 substeps", order, 0.99, "", "gt^2/2");
}

struct Spin {
  double energy_drift = 0.0;
  double energy_growth = 0.0;
  double momentum_drift = 0.0;
  int flips = 0;
};

Spin spin(const Sheet& sheet, const Vec3& half_extents, const Vec3& velocity) {
  Scene scene;
  scene.gravity = Vec3::Zero();
  const int box = scene.add(BoxShape{half_extents}, 1.0, {});
  scene.bodies.back().twist.angular = velocity;
  const auto engine = sheet.make(scene);
  const Vec3 momentum = spin_momentum(scene, *engine, box);
  EnergyWatch energy(scene, *engine, 0.0);
  int axis = 0;
  velocity.cwiseAbs().maxCoeff(&axis);
  Spin result;
  double last = 1.0;
  run_scene(scene, *engine, [&](double) {
    energy.after_frame(*engine);
    const double drift = (spin_momentum(scene, *engine, box) - momentum).norm() / momentum.norm();
    result.momentum_drift = std::isnan(drift) ? drift : std::max(result.momentum_drift, drift);
    const double along =
        engine->state(box).pose.orientation.toRotationMatrix().col(axis).dot(momentum);
    if (along * last < 0.0) ++result.flips;
    last = along;
  });
  result.energy_drift = energy.drift();
  result.energy_growth = energy.growth();
  return result;
}

const char* const kConserved = "conserved";

void dzhanibekov(Sheet& sheet) {
  const Spin s = spin(sheet, Vec3(0.1, 0.2, 0.3), Vec3(0.0, 20.0, 0.02));
  sheet.at_most("energy drift", s.energy_drift, 1e-3, "", kConserved);
  sheet.at_most("angular momentum drift", s.momentum_drift, 1e-6, "", kConserved);
  sheet.at_least("flips", s.flips, 2, "", "unstable about the middle axis");
}

void fast_spin(Sheet& sheet, double speed) {
  const Spin s = spin(sheet, Vec3(0.1, 0.2, 0.3), Vec3(speed, 1e-3 * speed, 1e-3 * speed));
  sheet.at_most("energy drift", s.energy_drift, 1e-3, "", kConserved);
}

/// A symmetric top on a ball joint at its tip.
void heavy_top(Sheet& sheet) {
  Scene scene;
  // Fast: (I3 w)^2 is 5 times 4 I1 m g h, so that it precesses without falling over.
  const double tilt = 0.5;
  const double height = 0.3;
  const Quat q = pbd::exp_map(Vec3(tilt, 0.0, 0.0));
  const int top = scene.add(BoxShape{Vec3(0.5, 0.5, 0.05)}, 1.0,
                            {.position = q * Vec3(0.0, 0.0, height), .orientation = q});
  scene.bodies.back().twist.angular = q * Vec3(0.0, 0.0, 20.0);
  scene.add_ball(-1, top, Vec3::Zero());
  const auto engine = sheet.make(scene);
  const double mass = scene.bodies[0].mass;
  // About the tip: gravity's moment has no component along the vertical, nor along the axis.
  const auto momentum = [&](double& vertical, double& axial) {
    const pbd::BodyState s = engine->state(top);
    const Vec3 own = spin_momentum(scene, *engine, top);
    vertical = (own + mass * s.pose.position.cross(s.twist.linear)).z();
    axial = own.dot(s.pose.orientation * Vec3::UnitZ());
  };
  double vertical_0 = 0.0;
  double axial_0 = 0.0;
  momentum(vertical_0, axial_0);
  EnergyWatch energy(scene, *engine, -mass * kGravity * height);
  double vertical_drift = 0.0;
  double axial_drift = 0.0;
  run_scene(scene, *engine, [&](double) {
    energy.after_frame(*engine);
    double vertical = 0.0;
    double axial = 0.0;
    momentum(vertical, axial);
    vertical_drift = std::max(vertical_drift, std::abs(vertical / vertical_0 - 1.0));
    axial_drift = std::max(axial_drift, std::abs(axial / axial_0 - 1.0));
  });
  sheet.at_most("energy drift", energy.drift(), 1e-3, "", kConserved);
  sheet.at_most("vertical angular momentum drift", vertical_drift, 1e-6, "", kConserved);
  sheet.at_most("axial angular momentum drift", axial_drift, 1e-6, "", kConserved);
}

}  // namespace

std::vector<Case> analytic_cases() {
  const std::string family = "analytic";
  return {
      {family, "free fall", [](Sheet& s) { fall(s, Vec3::Zero()); }},
      {family, "projectile", [](Sheet& s) { fall(s, Vec3(30.0, 10.0, 40.0)); }},
      {family, "free fall, order", fall_order},
      {family, "Dzhanibekov flip, 20 rad/s", dzhanibekov},
      {family, "heavy top, 20 rad/s", heavy_top},
      {family, "free spin, 1000 rad/s", [](Sheet& s) { fast_spin(s, 1000.0); }},
  };
}

}  // namespace tandem::bench
