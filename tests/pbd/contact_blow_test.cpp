// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Blows that pass from contact to contact.
#include <algorithm>
#include <vector>

#include "support/bodies.h"
#include "support/catch.h"
#include "support/toy_contacts.h"
#include "tandem/pbd/contact.h"
#include "tandem/pbd/joint.h"

namespace contact_blow_test {

using namespace tandem::pbd;
using namespace tandem::testing;

namespace {

constexpr double kRadius = 0.05;

/// Balls on rods, side by side; the first few are lifted.
struct Cradle {
  static constexpr int kBalls = 5;
  static constexpr double kRod = 0.5;  ///< m
  World world;
  ToyContacts contacts;
  std::vector<BodyId> balls;

  Cradle(int lifted, double angle, double gap) {
    world.set_contact_source(&contacts);
    auto& joints = world.add_block<JointBlock>();
    for (int i = 0; i < kBalls; ++i) {
      const Vec3 nail((2.0 * kRadius + gap) * i, 0.0, 0.0);
      const Quat q = turn(Vec3(0.0, i < lifted ? angle : 0.0, 0.0));
      BodyDef def = ball_def(0.5, kRadius, nail + q * Vec3(0.0, 0.0, -kRod));
      def.pose.orientation = q;
      balls.push_back(world.add_body(def));
      joints.add(world, ball_joint_at(world, {}, balls.back(), nail));
      if (i == 0) continue;
      contacts.ball_on_ball(balls[static_cast<std::size_t>(i) - 1], kRadius, balls.back(), kRadius,
                            {.friction = 0.0, .restitution = 1.0});
    }
  }
  double height(int i) const {
    return world.pose(balls[static_cast<std::size_t>(i)]).position.z() + kRod;
  }
};

/// Velocities after pairwise collisions, the fastest approach first, of balls in a row of which the
/// first one moves with 1 m/s.
std::vector<double> collided(const std::vector<double>& mass, double restitution) {
  std::vector<double> v(mass.size(), 0.0);
  v[0] = 1.0;
  for (;;) {
    std::size_t at = 0;
    for (std::size_t i = 0; i + 1 < v.size(); ++i) {
      if (v[i] - v[i + 1] > v[at] - v[at + 1]) at = i;
    }
    const double approach = v[at] - v[at + 1];
    if (!(approach > 1e-9)) return v;
    const double impulse = (1.0 + restitution) * approach / (1.0 / mass[at] + 1.0 / mass[at + 1]);
    v[at] -= impulse / mass[at];
    v[at + 1] += impulse / mass[at + 1];
  }
}

/// A ball that comes along and hits a row of others.
struct Row {
  World world;
  ToyContacts contacts;
  std::vector<BodyId> balls;

  Row(const std::vector<double>& mass, double gap, double restitution, bool on_plane)
      : world(on_plane ? WorldDef{} : weightless()) {
    world.set_contact_source(&contacts);
    const BodyId ground = add_ground(world);
    const ToyContacts::Surface surface{.friction = 0.0, .restitution = restitution};
    for (std::size_t i = 0; i < mass.size(); ++i) {
      const double x = i == 0 ? -0.3 : (2.0 * kRadius + gap) * static_cast<double>(i - 1);
      balls.push_back(world.add_body(ball_def(mass[i], kRadius, Vec3(x, 0.0, kRadius))));
      if (on_plane) {
        contacts.ball_on_plane(ground, Vec3::UnitZ(), 0.0, balls[i], kRadius, surface);
      }
      if (i > 0) contacts.ball_on_ball(balls[i - 1], kRadius, balls[i], kRadius, surface);
    }
    world.set_twist(balls[0], {Vec3(1.0, 0.0, 0.0), Vec3::Zero()});
  }
};

/// A ball that flies into a cube of 27, with a hit that is not central.
struct Break {
  World world{weightless()};
  ToyContacts contacts;

  explicit Break(double restitution) {
    world.set_contact_source(&contacts);
    std::vector<BodyId> balls;
    for (int i = 0; i < 27; ++i) {
      const Vec3 place(i % 3, i / 3 % 3, i / 9);
      balls.push_back(world.add_body(ball_def(1.0, kRadius, 2.0 * kRadius * place)));
    }
    balls.push_back(world.add_body(ball_def(2.0, kRadius, Vec3(-0.4, 0.13, 0.06))));
    world.set_twist(balls.back(), {Vec3(8.0, 0.5, 0.0), Vec3::Zero()});
    for (std::size_t i = 0; i < balls.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        contacts.ball_on_ball(balls[j], kRadius, balls[i], kRadius,
                              {.friction = 0.0, .restitution = restitution});
      }
    }
  }
};

}  // namespace

TEST_CASE("blow: as many balls leave Newton's cradle as come", "[pbd][analytic]") {
  for (const int substeps : {2, SolverOptions{}.substeps, 8, 32}) {
    for (const double angle : {kPi / 6.0, kPi / 3.0}) {
      for (const double gap : {0.0, 1e-4}) {
        for (const int lifted : {1, 2}) {
          CAPTURE(substeps, angle, gap, lifted);
          Cradle cradle(lifted, angle, gap);
          Solver solver({.substeps = substeps});
          const double lift = cradle.height(0);
          const double start = cradle.world.mechanical_energy();
          double last = 0.0, middle = 0.0, end = 0.0;
          run(cradle.world, solver, 1.25, [&] {
            middle = std::max(middle, cradle.height(2));
            const double height = cradle.height(Cradle::kBalls - 1);
            if (height > last) end = cradle.world.mechanical_energy();
            last = std::max(last, height);
          });
          // A ball that a rod holds turns with it, which a blow through its centre does not know:
          // 2/5 (r / l)^2 of the speed is lost at either end.
          CHECK(last > 0.985 * lift);
          CHECK(last < 1.005 * lift);
          CHECK(middle < 1e-3 * lift);
          // At the top, as velocities stand half a substep behind poses.
          CHECK(end - start < 5e-3 * lifted * 0.5 * kGravity * lift);
        }
      }
    }
  }
}

TEST_CASE("blow: it passes through a row as pairwise collisions", "[pbd][analytic]") {
  const std::vector<std::vector<double>> rows{{1.0, 1.0, 1.0, 1.0, 1.0},
                                              {1.0, 2.0, 3.0, 4.0, 5.0},
                                              {5.0, 4.0, 3.0, 2.0, 1.0},
                                              {3.0, 1.0, 1.0, 1.0, 0.5},
                                              std::vector<double>(20, 1.0)};
  for (const auto& mass : rows) {
    for (const double restitution : {0.5, 1.0}) {
      // Twenty that lose half each time end as a swarm, whose blows are slower than what bounces.
      if (mass.size() > 5 && restitution < 1.0) continue;
      for (const bool on_plane : {false, true}) {
        for (const int substeps : {2, 4, 32}) {
          CAPTURE(mass, restitution, on_plane, substeps);
          const std::vector<double> expected = collided(mass, restitution);
          Row row(mass, 0.0, restitution, on_plane);
          // Slower blows than this do not pass on.
          Solver solver({.substeps = substeps, .contact = {.restitution_threshold = 0.1}});
          run(row.world, solver, 0.5);
          for (std::size_t i = 0; i < mass.size(); ++i) {
            CHECK(row.world.twist(row.balls[i]).linear.x() == Approx(expected[i]).margin(0.01));
            CHECK(std::abs(row.world.pose(row.balls[i]).position.z() - kRadius) < 1e-4);
          }
        }
      }
    }
  }
}

TEST_CASE("blow: contacts that are hit at once share it alike", "[pbd][analytic]") {
  for (const double degrees : {20.0, 30.0, 45.0}) {
    CAPTURE(degrees);
    const double angle = degrees * kPi / 180.0;
    World world(weightless());
    ToyContacts contacts;
    world.set_contact_source(&contacts);
    const BodyId hit = world.add_body(ball_def(1.0, kRadius, Vec3::Zero()));
    std::vector<BodyId> balls;
    for (const double side : {-1.0, 1.0}) {
      const Vec3 touch(-std::cos(angle), side * std::sin(angle), 0.0);
      balls.push_back(
          world.add_body(ball_def(1.0, kRadius, 2.0 * kRadius * touch - 0.2 * Vec3::UnitX())));
      world.set_twist(balls.back(), {2.0 * Vec3::UnitX(), Vec3::Zero()});
      contacts.ball_on_ball(balls.back(), kRadius, hit, kRadius,
                            {.friction = 0.0, .restitution = 1.0});
    }
    const double energy = world.kinetic_energy();
    Solver solver;
    run(world, solver, 0.5);
    CHECK(world.twist(hit).linear.x() > 1.9);
    CHECK(std::abs(world.twist(hit).linear.y()) < 1e-5);
    const Vec3 one = world.twist(balls[0]).linear, other = world.twist(balls[1]).linear;
    CHECK((one - Vec3(other.x(), -other.y(), 0.0)).norm() < 1e-5);
    CHECK(world.kinetic_energy() == Approx(energy).epsilon(1e-5));
  }
}

TEST_CASE("blow: a cluster that is hit gains no energy and keeps its momentum", "[pbd][analytic]") {
  for (const double restitution : {0.0, 0.3, 0.7, 1.0}) {
    CAPTURE(restitution);
    Break scene(restitution);
    const double energy = scene.world.kinetic_energy();
    const Vec3 momentum = linear_momentum(scene.world);
    Solver solver({.sleep_after = 0.0});
    run(scene.world, solver, 1.0, [&] {
      REQUIRE(scene.world.kinetic_energy() < (1.0 + 1e-4) * energy);
      REQUIRE((linear_momentum(scene.world) - momentum).norm() < 1e-10);
    });
    if (restitution == 1.0) CHECK(scene.world.kinetic_energy() > 0.99 * energy);
  }
}

TEST_CASE("blow: the same bits for any number of lanes and threads", "[pbd][golden]") {
  Break one(0.7), two(0.7);
  Solver narrow({.contact = {.lanes = 2}});
  Solver wide({.contact = {.lanes = 4}, .threads = 3});
  for (int i = 0; i < 60; ++i) {
    narrow.step(one.world, kFrame);
    wide.step(two.world, kFrame);
    REQUIRE(one.world.hash() == two.world.hash());
  }
}

TEST_CASE("blow: a body that falls on a stack bounces off it, and the stack stays",
          "[pbd][contact]") {
  const Vec3 half(0.25, 0.25, 0.25);
  World world;
  ToyContacts contacts;
  world.set_contact_source(&contacts);
  const ToyContacts::Surface surface{.restitution = 0.8};
  const BodyId ground = add_ground(world);
  std::vector<BodyId> boxes;
  for (const double height : {0.25, 0.75, 2.0}) {
    boxes.push_back(world.add_body(box_def(1.0, half, Vec3(0.0, 0.0, height))));
    if (boxes.size() == 1) {
      contacts.box_on_plane(ground, Vec3::UnitZ(), 0.0, boxes[0], half, surface);
    } else {
      contacts.box_on_box(boxes[boxes.size() - 2], half, boxes.back(), half, surface);
    }
  }
  Solver solver({.sleep_after = 0.0});
  double highest = 0.0;
  double time = 0.0;
  run(world, solver, 6.0, [&] {
    time += kFrame;
    // It falls for 0.39 s by 0.75 m.
    if (time < 0.38) {
      REQUIRE(std::abs(world.pose(boxes[1]).position.z() - 0.75) < 1e-6);
    } else if (time > 0.41) {
      highest = std::max(highest, world.pose(boxes[2]).position.z() - 1.25);
    }
  });
  // Pairwise collisions down to the ground and back give it 0.507 of its speed.
  CHECK(highest == Approx(0.507 * 0.507 * 0.75).epsilon(0.1));
  for (const BodyId box : boxes) CHECK(world.twist(box).linear.norm() < 1e-3);
  CHECK(world.pose(boxes[2]).position.z() == Approx(1.25).margin(1e-3));
}

}  // namespace contact_blow_test
