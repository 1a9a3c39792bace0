// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Contacts against closed forms: incline, rolling, bouncing, Newton's cradle.
#include <algorithm>
#include <numbers>

#include "numerics/case.h"
#include "numerics/track.h"

namespace tandem::bench {
namespace {

/// A plane through the origin with a gradient `slope` (tangent) down along +x.
struct Incline {
  explicit Incline(double slope)
      : angle(std::atan(slope)),
        turn(pbd::exp_map(Vec3(0.0, angle, 0.0))),
        normal(turn * Vec3::UnitZ()),
        down(turn * Vec3::UnitX()) {}
  double angle;
  Quat turn;
  Vec3 normal, down;
};

/// Acceleration (m/s^2) down the slope, from one second after the start to the end.
double acceleration(const Scene& scene, Engine& engine, int body, const Vec3& down) {
  double speed_1 = 0.0;
  run_scene(scene, engine, [&](double t) {
    if (t < 1.0 + 0.5 * scene.dt) speed_1 = engine.state(body).twist.linear.dot(down);
  });
  return (engine.state(body).twist.linear.dot(down) - speed_1) / (scene.seconds - 1.0);
}

Scene incline_scene(const Incline& incline, double friction) {
  Scene scene;
  scene.add_static(PlaneShape{incline.normal, 0.0});
  scene.add(cube(1.0), 10.0, {.position = 0.5 * incline.normal, .orientation = incline.turn});
  for (SceneBody& body : scene.bodies) body.friction = friction;
  return scene;
}

void incline(Sheet& sheet) {
  const Incline slope(0.5);
  const Scene sticking = incline_scene(slope, 0.5 * 1.02);
  auto engine = sheet.make(sticking);
  run_scene(sticking, *engine);
  const Vec3 moved = engine->state(1).pose.position - sticking.bodies[1].pose.position;
  sheet.at_most("way at mu + 2 %, 10 s", moved.norm(), 1e-3, "m", "sticks");

  const double mu = 0.5 * 0.98;
  const Scene sliding = incline_scene(slope, mu);
  engine = sheet.make(sliding);
  const double expected = kGravity * (std::sin(slope.angle) - mu * std::cos(slope.angle));
  sheet.relative("acceleration at mu - 2 %, m/s^2", acceleration(sliding, *engine, 1, slope.down),
                 expected, 0.01, "g (sin a - mu cos a)");
}

void rolling(Sheet& sheet) {
  const Incline slope(0.2);
  Scene scene;
  scene.add_static(PlaneShape{slope.normal, 0.0});
  const int ball = scene.add(SphereShape{0.5}, 2.0, {.position = 0.5 * slope.normal});
  auto engine = sheet.make(scene);
  sheet.relative("acceleration down a slope, m/s^2", acceleration(scene, *engine, ball, slope.down),
                 5.0 / 7.0 * kGravity * std::sin(slope.angle), 0.01, "5/7 g sin a");

  Scene flat;
  flat.add_static(PlaneShape{});
  flat.add(SphereShape{0.5}, 2.0, at(0.0, 0.0, 0.5));
  flat.bodies.back().twist.linear = Vec3(7.0, 0.0, 0.0);
  engine = sheet.make(flat);
  run_scene(flat, *engine);
  sheet.relative("speed once it rolls, from 7 m/s", engine->state(1).twist.linear.x(), 5.0, 0.01,
                 "5/7 v");
  sheet.relative("turns with its speed, m/s", 0.5 * engine->state(1).twist.angular.y(), 5.0, 0.01,
                 "v = w r");
}

void bounce(Sheet& sheet, double restitution) {
  constexpr double kRadius = 0.1;
  Scene scene;
  scene.add_static(PlaneShape{});
  const int ball = scene.add(SphereShape{kRadius}, 1.0, at(0.0, 0.0, 1.0 + kRadius));
  for (SceneBody& body : scene.bodies) body.restitution = restitution;
  const auto engine = sheet.make(scene);
  EnergyWatch energy(scene, *engine, energy_at_height(scene, kRadius));
  double peak = 0.0;
  bool touched = false;
  bool second = false;
  double last_speed = 0.0;
  run_scene(scene, *engine, [&](double) {
    energy.after_frame(*engine);
    const pbd::BodyState s = engine->state(ball);
    const double speed = s.twist.linear.z();
    if (touched && last_speed < 0.0 && speed > 0.0) second = true;
    touched |= last_speed < -1.0 && speed > last_speed + 1.0;
    // The apex is between frames: use the height that the energy corresponds to.
    if (touched && !second) {
      // Velocities belong to the end of a substep, half a substep later than positions.
      const double half_step = 0.5 * scene.dt / std::max(1, engine->stats().substeps);
      const double height = s.pose.position.z() - kRadius - half_step * speed;
      peak = std::max(peak, height + (speed > 0.0 ? 0.5 * speed * speed / kGravity : 0.0));
    }
    last_speed = speed;
  });
  const double expected = restitution * restitution;
  sheet.absolute("first height, m, from 1 m", peak, expected, 0.02 * std::max(expected, 0.09), "m",
                 "e^2 h");
  sheet.at_most("energy growth", energy.growth(), 1e-3, "of the total", "passive");
}

/// Equal balls on rods, side by side. As many leave at one end as are released from an angle at the
/// other.
struct Cradle {
  double radius = 0.1;  // m
  double rod = 1.0;     // m
  double gap = 0.0;     // m, between neighbours
  double angle = std::numbers::pi / 6.0;
  int lifted = 1;
  double seconds = 0.9;  // down in a quarter of a period and nearly up again
};

void cradle(Sheet& sheet, const Cradle& c) {
  constexpr int kBalls = 5;
  Scene scene;
  scene.seconds = c.seconds;
  for (int i = 0; i < kBalls; ++i) {
    const Vec3 nail((2.0 * c.radius + c.gap) * i, 0.0, c.rod);
    const Quat q = i < c.lifted ? pbd::exp_map(Vec3(0.0, c.angle, 0.0)) : Quat(Quat::Identity());
    const int ball = scene.add(SphereShape{c.radius}, 1.0,
                               {.position = nail + q * Vec3(0.0, 0.0, -c.rod), .orientation = q});
    scene.bodies.back().friction = 0.0;
    scene.bodies.back().restitution = 1.0;
    scene.add_ball(-1, ball, nail);
  }
  const auto engine = sheet.make(scene);
  EnergyWatch energy(scene, *engine, energy_at_height(scene, 0.0));
  double highest_last = 0.0;
  double highest_middle = 0.0;
  run_scene(scene, *engine, [&](double) {
    energy.after_frame(*engine);
    highest_last = std::max(highest_last, engine->state(kBalls - 1).pose.position.z());
    for (int i = c.lifted; i + c.lifted < kBalls; ++i) {
      highest_middle = std::max(highest_middle, engine->state(i).pose.position.z());
    }
  });
  // The run ends before the apex, so compare the last ball's energy.
  const pbd::BodyState last = engine->state(kBalls - 1);
  const double reached = last.pose.position.z() + 0.5 * last.twist.linear.squaredNorm() / kGravity;
  const double height = c.rod * (1.0 - std::cos(c.angle));
  sheet.relative("height of the last ball, m", std::max(reached, highest_last), height, 0.02,
                 "equal masses swap velocities");
  sheet.at_most("height of the middle ones", highest_middle / height, 0.02, "of the first",
                "stay at rest");
  sheet.at_most("energy growth", energy.growth(), 1e-3, "of the total", "passive");
}

/// A ball of 5 cm hits a row of four, each lighter than the one before: pairwise collisions.
void unequal_row(Sheet& sheet) {
  constexpr double kRadius = 0.05;
  constexpr double kMasses[] = {5.0, 4.0, 3.0, 2.0, 1.0};  // kg
  Scene scene;
  scene.seconds = 0.5;
  scene.add_static(PlaneShape{});
  double along = -0.3;
  for (const double mass : kMasses) {
    scene.add(SphereShape{kRadius}, mass, at(along, 0.0, kRadius));
    along = along < 0.0 ? 0.0 : along + 2.0 * kRadius;
  }
  for (SceneBody& body : scene.bodies) {
    body.friction = 0.0;
    body.restitution = 1.0;
  }
  scene.bodies[1].twist.linear = Vec3(2.0, 0.0, 0.0);
  const auto engine = sheet.make(scene);
  const double start = mechanical_energy(scene, *engine);
  run_scene(scene, *engine);
  double speed = 2.0;
  double worst = 0.0;
  for (int i = 0; i < 5; ++i) {
    // The heavier one keeps (m - n) / (m + n) of the arriving velocity.
    const double mass = kMasses[i];
    const double next = i < 4 ? kMasses[i + 1] : 0.0;
    const double kept = i < 4 ? speed * (mass - next) / (mass + next) : speed;
    worst = std::max(worst, std::abs(engine->state(i + 1).twist.linear.x() - kept));
    speed *= 2.0 * mass / (mass + next);
  }
  sheet.at_most("velocities off, from 2 m/s", worst, 0.02, "m/s", "pairwise collisions");
  const double growth = (mechanical_energy(scene, *engine) - start) / start;
  sheet.at_most("energy growth", growth, 1e-3, "of the total", "passive");
}

}  // namespace

std::vector<Case> analytic_contact_cases() {
  const std::string family = "analytic";
  std::vector<Case> cases{{family, "incline of slope 0.5", incline},
                          {family, "rolling ball", rolling}};
  for (const char* const restitution : {"0", "0.3", "0.5", "0.8", "1"}) {
    const double e = std::stod(restitution);
    cases.push_back({family, std::string("bounce, restitution ") + restitution,
                     [e](Sheet& s) { bounce(s, e); }});
  }
  cases.push_back({family, "Newton's cradle", [](Sheet& s) { cradle(s, {}); }});
  cases.push_back({family, "Newton's cradle, two balls, gaps of 0.1 mm", [](Sheet& s) {
                     cradle(s, {.radius = 0.05,
                                .rod = 0.5,
                                .gap = 1e-4,
                                .angle = std::numbers::pi / 3.0,
                                .lifted = 2,
                                .seconds = 0.7});
                   }});
  cases.push_back({family, "blow through a row of unequal balls", unequal_row});
  return cases;
}

}  // namespace tandem::bench
