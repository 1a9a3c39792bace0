// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Joints against closed forms: pendulum, spring, hanging rope.
#include <algorithm>
#include <numbers>

#include "numerics/case.h"
#include "numerics/track.h"

namespace tandem::bench {
namespace {

/// A rod of 1 m, hung up at its end.
void pendulum(Sheet& sheet, double degrees) {
  Scene scene;
  const double angle = degrees * std::numbers::pi / 180.0;
  const double length = 0.5;  // m, from the pivot to the centre
  const Quat q = pbd::exp_map(Vec3(0.0, -angle, 0.0));
  const int bob = scene.add(BoxShape{Vec3(0.02, 0.02, length)}, 1.0,
                            {.position = q * Vec3(0.0, 0.0, -length), .orientation = q});
  scene.add_ball(-1, bob, Vec3::Zero());
  const auto engine = sheet.make(scene);
  EnergyWatch energy(scene, *engine, -kGravity * length);
  std::vector<double> angles;
  run_scene(scene, *engine, [&](double) {
    energy.after_frame(*engine);
    const Vec3 p = engine->state(bob).pose.position;
    angles.push_back(std::atan2(p.x(), -p.z()));
  });
  // T = 4 K(sin(angle / 2)) sqrt(I / (m g L)), with I about the pivot.
  const double inertia = scene.bodies[0].inertia.y() + length * length;
  const double expected =
      4.0 * elliptic_k(std::sin(0.5 * angle)) * std::sqrt(inertia / (kGravity * length));
  sheet.relative("period, s", crossing_period(angles, scene.dt), expected, 1e-3,
                 "elliptic integral");
  sheet.at_most("energy growth", energy.growth(), 1e-3, "of the total", "passive");
}

struct SpringRun {
  std::vector<double> stretch;  ///< m, by frame
  double largest = 0.0;         ///< m
  double last_speed = 0.0;      ///< m/s, largest in the last second
  int substeps = 0;
};

SpringRun run_spring(const Sheet& sheet, double stiffness, double mass, double amplitude) {
  Scene scene;
  scene.gravity = Vec3::Zero();
  const int ball = scene.add(SphereShape{0.1}, mass, at(1.0 + amplitude, 0.0, 0.0));
  scene.joints.push_back({.kind = JointKind::Distance,
                          .a = -1,
                          .b = ball,
                          .compliance = 1.0 / stiffness,
                          .rest_length = 1.0});
  const auto engine = sheet.make(scene);
  SpringRun run;
  run_scene(scene, *engine, [&](double t) {
    const pbd::BodyState s = engine->state(ball);
    run.stretch.push_back(s.pose.position.x() - 1.0);
    run.largest = std::max(run.largest, std::abs(run.stretch.back()));
    if (!std::isfinite(run.stretch.back())) run.largest = HUGE_VAL;
    if (t > scene.seconds - 1.0) {
      run.last_speed = std::max(run.last_speed, s.twist.linear.norm());
    }
  });
  run.substeps = engine->stats().substeps;
  return run;
}

double period_of(const std::vector<double>& stretch, double dt, double guess) {
  return guess > 20.0 * dt ? crossing_period(stretch, dt) : sinusoid_period(stretch, dt);
}

/// Mass grows with stiffness: the period stays 0.63 s, and stiffness alone must not matter.
void spring_scaled(Sheet& sheet) {
  const double dt = Scene{}.dt;
  for (int e = 0; e <= 8; ++e) {
    const double stiffness = std::pow(10.0, e);
    const double expected = 2.0 * std::numbers::pi / 10.0;
    const SpringRun run = run_spring(sheet, stiffness, stiffness / 100.0, 0.1);
    sheet.relative("period, s, 1e" + std::to_string(e) + " N/m",
                   period_of(run.stretch, dt, expected), expected, 0.01, "2 pi sqrt(m/k)");
  }
}

/// One kilogram: the period falls below the step. Resolved = 40 substeps per period.
void spring_stiff(Sheet& sheet) {
  const double dt = Scene{}.dt;
  const double amplitude = 0.1;
  for (int e = 0; e <= 12; ++e) {
    const double stiffness = std::pow(10.0, e);
    const double expected = 2.0 * std::numbers::pi / std::sqrt(stiffness);
    const SpringRun run = run_spring(sheet, stiffness, 1.0, amplitude);
    const std::string which = ", 1e" + std::to_string(e) + " N/m";
    if (expected > 40.0 * dt / run.substeps && expected > 2.0 * dt) {
      sheet.relative("period, s" + which, period_of(run.stretch, dt, expected), expected, 0.01,
                     "2 pi sqrt(m/k)");
    } else {
      sheet.at_most("largest stretch" + which, run.largest / amplitude, 1.001, "of the first",
                    "passive");
      if (e > 8) {
        sheet.at_most("speed in the last second" + which, run.last_speed, 1e-3, "m/s", "quiet");
      }
    }
  }
}

/// Sag (m) of a catenary of this length over this span: y = a cosh(x / a).
double catenary_sag(double length, double span) {
  double low = 1e-3;
  double high = 1e3;
  for (int i = 0; i < 200; ++i) {
    const double a = 0.5 * (low + high);
    (2.0 * a * std::sinh(0.5 * span / a) > length ? low : high) = a;
  }
  return low * (std::cosh(0.5 * span / low) - 1.0);
}

/// Fifty links between two pivots, starting along an arc; the harness removes 3 % of all speed per
/// frame.
void rope(Sheet& sheet) {
  constexpr int kLinks = 50;
  constexpr double kLength = 0.1;
  constexpr double kSpan = 4.0;
  // Angle of one chord such that kLinks of them span kSpan: sin(n a / 2) / sin(a / 2) = span / len.
  double low = 1e-9;
  double high = 2.0 * std::numbers::pi / kLinks;
  for (int i = 0; i < 200; ++i) {
    const double a = 0.5 * (low + high);
    (std::sin(0.5 * kLinks * a) / std::sin(0.5 * a) > kSpan / kLength ? low : high) = a;
  }
  Scene scene;
  scene.seconds = 20.0;
  Vec3 end(-0.5 * kSpan, 0.0, 0.0);
  for (int i = 0; i < kLinks; ++i) {
    const double slope = (i - 0.5 * (kLinks - 1)) * low;
    const Vec3 along(std::cos(slope), 0.0, std::sin(slope));
    const int link = scene.add(
        BoxShape{Vec3(0.5 * kLength, 0.01, 0.01)}, 0.1,
        {.position = end + 0.5 * kLength * along, .orientation = pbd::exp_map({0.0, -slope, 0.0})});
    scene.add_ball(link - 1, link, end);
    end += kLength * along;
  }
  scene.add_ball(-1, kLinks - 1, Vec3(0.5 * kSpan, 0.0, 0.0));
  for (SceneBody& body : scene.bodies) body.collides = false;
  const auto engine = sheet.make(scene);
  run_scene(scene, *engine, [&](double) {
    for (int i = 0; i < kLinks; ++i) {
      Twist twist = engine->state(i).twist;
      twist.linear *= 0.97;
      twist.angular *= 0.97;
      engine->set_twist(i, twist);
    }
  });
  // The lowest joint: the middle one, at the end of link 24.
  const double sag =
      -engine->state(kLinks / 2 - 1).pose.to_world(Vec3(0.5 * kLength, 0.0, 0.0)).z();
  sheet.relative("sag, m", sag, catenary_sag(kLinks * kLength, kSpan), 5e-3, "catenary");
}

}  // namespace

std::vector<Case> analytic_joint_cases() {
  const std::string family = "analytic";
  return {
      {family, "pendulum, 10 degrees", [](Sheet& s) { pendulum(s, 10.0); }},
      {family, "pendulum, 170 degrees", [](Sheet& s) { pendulum(s, 170.0); }},
      {family, "spring of one period", spring_scaled},
      {family, "spring, 1 kg", spring_stiff},
      {family, "hanging rope, 50 links", rope},
  };
}

}  // namespace tandem::bench
