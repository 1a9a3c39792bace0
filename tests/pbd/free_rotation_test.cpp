// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Bodies that nothing acts on, against Euler's equations.
#include <random>

#include "support/catch.h"
#include "support/oracles.h"
#include "tandem/pbd/solver.h"

namespace free_rotation_test {

using namespace tandem::pbd;
using namespace tandem::testing;

namespace {

struct Random {
  std::mt19937 bits;
  double number(double low, double high) {
    return low + (high - low) * static_cast<double>(bits()) / 4294967296.0;
  }
  Vec3 direction() {
    Vec3 v;
    do {
      v = Vec3(number(-1, 1), number(-1, 1), number(-1, 1));
    } while (v.norm() < 0.1 || v.norm() > 1.0);
    return v.normalized();
  }
  Quat orientation() { return turn(number(0, kPi) * direction()); }
};

/// A body whose moments are those of `moments` about axes that are not those of its frame.
struct Case {
  Mat3 inertia;
  Quat axes;  ///< to the body frame
  Quat q;
  Vec3 w;  ///< rad/s, world

  Case(Random& random, const Vec3& moments, double spin)
      : axes(random.orientation()), q(random.orientation()), w(spin * random.direction()) {
    const Mat3 r = axes.toRotationMatrix();
    const Mat3 tensor = r * moments.asDiagonal() * r.transpose();
    inertia = 0.5 * (tensor + tensor.transpose());
  }
  Vec3 momentum(const Quat& at, const Vec3& spin) const {
    const Mat3 r = at.toRotationMatrix();
    return r * (inertia * (r.transpose() * spin));
  }
};

struct Free {
  World world;
  BodyId body;
  Solver solver;

  explicit Free(const Case& start)
      : world({.gravity = Vec3::Zero()}),
        body(world.add_body({.pose = {.orientation = start.q},
                             .twist = {.angular = start.w},
                             .inertia = start.inertia})),
        solver({.sleep_after = 0.0}) {}
  Quat q() const { return world.pose(body).orientation; }
  Vec3 w() const { return world.twist(body).angular; }
};

/// Euler's equations by Runge and Kutta's method, in steps short enough to be exact to 1e-9.
Quat exact(const Case& start, double time, int steps) {
  struct State {
    Eigen::Vector4d q;
    Vec3 momentum_l;
  };
  const Mat3 inverse = start.inertia.inverse();
  const auto rate = [&](const State& s) {
    const Vec3 w = inverse * s.momentum_l;
    const Quat dq = Quat(s.q) * Quat(0.0, w.x(), w.y(), w.z());
    return State{0.5 * dq.coeffs(), s.momentum_l.cross(w)};
  };
  const auto moved = [](const State& s, double h, const State& by) {
    return State{s.q + h * by.q, s.momentum_l + h * by.momentum_l};
  };
  State s{start.q.coeffs(), start.inertia * (start.q.conjugate() * start.w)};
  const double h = time / steps;
  for (int i = 0; i < steps; ++i) {
    const State a = rate(s), b = rate(moved(s, 0.5 * h, a)), c = rate(moved(s, 0.5 * h, b)),
                d = rate(moved(s, h, c));
    s = moved(moved(moved(moved(s, h / 6.0, a), h / 3.0, b), h / 3.0, c), h / 6.0, d);
  }
  return Quat(s.q).normalized();
}

TEST_CASE("free rotation: a body with two equal moments precesses as its closed form says",
          "[pbd][analytic]") {
  Random random{.bits = std::mt19937(4)};
  for (int run = 0; run < 60; ++run) {
    const double across = random.number(0.1, 1.0);
    const double along = random.number(0.001, 1.99) * across;
    const double spin = std::exp(random.number(0.0, std::log(2000.0)));
    const Case start(random, Vec3(across, across, along), spin);
    Free free(start);
    double time = 0.0;
    for (int i = 0; i < 40; ++i) {
      const double dt = random.number(0.001, 0.05);
      REQUIRE(free.solver.step(free.world, dt).status == StepStatus::Ok);
      time += dt;
    }
    // The axis goes round the angular momentum at |L| / across.
    const Vec3 momentum = start.momentum(start.q, start.w);
    const Vec3 axis_l = start.axes * Vec3::UnitZ();
    const Vec3 axis = turn(time / across * momentum) * (start.q * axis_l);
    INFO("run " << run << ", " << spin << " rad/s, moments " << across << " and " << along);
    CHECK((free.q() * axis_l - axis).norm() < 1e-9 * std::max(1.0, spin));
    const double about = along * start.w.dot(start.q * axis_l);  // kg m^2/s, stays
    const Vec3 w = momentum / across + (about / along - about / across) * axis;
    CHECK((free.w() - w).norm() < 1e-9 * spin * std::max(1.0, spin));
  }
}

TEST_CASE("free rotation: three different moments, as Euler's equations", "[pbd][analytic]") {
  Random random{.bits = std::mt19937(5)};
  for (int run = 0; run < 12; ++run) {
    const double a = random.number(0.2, 1.0), b = random.number(0.2, 1.0);
    const double c = random.number(std::abs(a - b) + 0.02, a + b);
    const double spin = random.number(2.0, 40.0);
    const Case start(random, Vec3(a, b, c), spin);
    const Quat last = exact(start, 1.0, 20000);
    const auto error = [&](int steps) {
      Free free(start);
      for (int i = 0; i < steps; ++i) free.solver.step(free.world, 1.0 / steps);
      return angle_between(free.q(), last);
    };
    INFO("run " << run << ", " << spin << " rad/s, moments " << a << ", " << b << ", " << c);
    const double of_60 = error(60);
    CHECK(of_60 < 1e-3);
    CHECK(error(120) < 0.2 * of_60 + 1e-8);  // second order would do with a quarter
  }
}

TEST_CASE("free rotation: momentum and energy stay at any spin", "[pbd][analytic]") {
  Random random{.bits = std::mt19937(6)};
  for (int run = 0; run < 40; ++run) {
    const double a = random.number(0.2, 1.0), b = random.number(0.5, 1.0);
    const double c = run % 2 == 0 ? b : random.number(std::abs(a - b) + 1e-3, a + b);
    const Case start(random, Vec3(a, b, c), std::exp(random.number(0.0, std::log(1e5))));
    const Vec3 momentum = start.momentum(start.q, start.w);
    const double energy = start.w.dot(momentum);
    Free free(start);
    for (int i = 0; i < 60; ++i) free.solver.step(free.world, kFrame);
    const Vec3 now = start.momentum(free.q(), free.w());
    INFO("run " << run << ", " << start.w.norm() << " rad/s");
    CHECK((now - momentum).norm() < 1e-9 * momentum.norm());
    CHECK(std::abs(free.w().dot(now) / energy - 1.0) < 1e-9);
  }
}

}  // namespace
}  // namespace free_rotation_test
