// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/pbd/corrections.h"

#include "support/catch.h"
#include "support/gradient.h"

namespace corrections_test {

using namespace tandem::pbd;
using namespace tandem::testing;

namespace {

SolverBody some_body() {
  return solver_body({Vec3(0.3, -0.2, 1.0), turn(Vec3(0.4, 0.1, -0.7))}, 2.0,
                     box_inertia(2.0, Vec3(0.1, 0.3, 0.2)));
}

}  // namespace

TEST_CASE("corrections: a pair of opposite impulses keeps both momenta", "[pbd][unit]") {
  SolverBody a = some_body();
  SolverBody b = some_body();
  b.x = Vec3(1.0, 0.5, 0.8);
  b.inv_mass = 3.0;
  const Vec3 p(0.02, -0.01, 0.03);
  const Vec3 point(0.6, 0.1, 0.9);  // one point of both bodies
  const Vec3 r_a = point - a.x;
  const Vec3 r_b = point - b.x;
  const Vec3 x_a = a.x;
  const Vec3 x_b = b.x;
  apply_pair(a, b, p, r_a, r_b);
  const Vec3 p_a = a.dx / a.inv_mass;
  const Vec3 p_b = b.dx / b.inv_mass;
  CHECK((p_a + p).norm() < 1e-16);
  CHECK((p_b - p).norm() < 1e-16);
  const Vec3 l = x_a.cross(p_a) + a.inv_inertia_w.inverse() * a.dtheta + x_b.cross(p_b) +
                 b.inv_inertia_w.inverse() * b.dtheta;
  CHECK(l.norm() < 1e-16);
  CHECK((a.x - x_a - a.dx).norm() < 1e-16);
  CHECK(angle_between(a.q, turn(a.dtheta) * some_body().q) < 1e-15);
}

TEST_CASE("corrections: an immovable body takes none", "[pbd][unit]") {
  SolverBody wall = some_body();
  wall.inv_mass = 0.0;
  wall.inv_inertia_w.setZero();
  const SolverBody before = wall;
  apply_correction(wall, Vec3(1.0, 2.0, 3.0), Vec3(4.0, 5.0, 6.0));
  CHECK((wall.x == before.x && wall.dx.norm() == 0.0 && wall.dtheta.norm() == 0.0));
  CHECK(wall.q.coeffs() == before.q.coeffs());
  CHECK(inverse_mass(wall, Vec3(1.0, 0.0, 0.0), Vec3(0.0, 1.0, 0.0)) == 0.0);
}

TEST_CASE("corrections: generalised inverse masses are those of the point's motion",
          "[pbd][unit]") {
  // How far the point moves along n for a unit impulse along n, by applying one.
  SolverBody a = some_body();
  SolverBody b = some_body();
  b.inv_mass = 0.2;
  const Vec3 r_a(0.1, -0.2, 0.3);
  const Vec3 r_b(0.4, 0.0, -0.1);
  const Vec3 n = Vec3(1.0, 2.0, -0.5).normalized();
  const double w = inverse_mass(a, r_a, n) + inverse_mass(b, r_b, n);
  const Mat3 k = point_inverse_mass(a, b, r_a, r_b);
  apply_pair(a, b, n, r_a, r_b);
  const Vec3 opened = (b.dx + b.dtheta.cross(r_b)) - (a.dx + a.dtheta.cross(r_a));
  CHECK(std::abs(opened.dot(n) - w) < 1e-14);
  CHECK((k * n - opened).norm() < 1e-14);
}

TEST_CASE("corrections: a rigid multiplier closes C and a soft one meets Hooke's law",
          "[pbd][analytic]") {
  const double w = 0.8;
  const double c = 0.03;
  CHECK(row_multiplier(c, 0.0, w, {}, 0.0) * w == Approx(-c).epsilon(1e-14));
  // Any split into repeated solves ends where lambda = -C k h^2.
  const double h = 0.002;
  const double k = 700.0;
  const RowSoftness soft = RowSoftness::of(1.0 / k, 0.0, h);
  double lambda = 0.0;
  double left = c;
  for (int i = 0; i < 3; ++i) {
    const double change = row_multiplier(left, lambda, w, soft, 0.0);
    lambda += change;
    left += w * change;
    CHECK(lambda == Approx(-left * k * h * h).epsilon(1e-12));
  }
}

TEST_CASE("corrections: a damped multiplier meets the damper's law", "[pbd][analytic]") {
  const double w = 0.8;
  const double h = 0.002;
  const double k = 700.0;
  const double d = 13.0;
  const double c_start = 0.03;
  const double c = 0.028;  // predicted
  const double lambda = row_multiplier(c, 0.0, w, RowSoftness::of(1.0 / k, d, h), c - c_start);
  const double end = c + w * lambda;
  // Force = lambda / h^2 = -k C - d dC/dt, with both at the end of the substep.
  CHECK(lambda / (h * h) == Approx(-k * end - d * (end - c_start) / h).epsilon(1e-12));
}

TEST_CASE("corrections: a row without mobility asks for nothing", "[pbd][unit]") {
  CHECK(row_multiplier(0.1, 0.0, 0.0, {}, 0.0) == 0.0);
}

}  // namespace corrections_test
