// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/pbd/math.h"

#include <limits>

#include "support/catch.h"
#include "support/oracles.h"

namespace math_test {

using namespace tandem::pbd;
using namespace tandem::testing;

namespace {

/// Directions all over the sphere, the poles included.
std::vector<Vec3> directions() {
  std::vector<Vec3> all{
      Vec3::UnitX(), -Vec3::UnitX(), Vec3::UnitY(),         -Vec3::UnitY(),
      Vec3::UnitZ(), -Vec3::UnitZ(), Vec3(0.0, -0.0, -1.0), Vec3(1e-9, -1e-9, -1.0).normalized()};
  for (int i = 0; i < 200; ++i) {  // Fibonacci sphere
    const double z = 1.0 - (2.0 * i + 1.0) / 200.0;
    const double turn_angle = i * kPi * (3.0 - std::sqrt(5.0));
    const double r = std::sqrt(1.0 - z * z);
    all.emplace_back(r * std::cos(turn_angle), r * std::sin(turn_angle), z);
  }
  return all;
}

}  // namespace

TEST_CASE("math: exp_map and log_map are inverse from tiny angles to half a turn",
          "[pbd][unit][analytic]") {
  for (const Vec3& axis : directions()) {
    for (const double angle : {0.0, 1e-300, 1e-15, 1e-12, 1e-9, 1e-6, 9.99e-4, 1.001e-3, 0.1, 1.0,
                               2.0, 3.0, kPi - 1e-3, kPi - 1e-9, kPi - 1e-13}) {
      const Vec3 r = angle * axis;
      const Quat q = exp_map(r);
      INFO("angle " << angle);
      REQUIRE(std::abs(q.norm() - 1.0) < 4e-16);
      REQUIRE((log_map(q) - r).norm() <= 4e-16 * angle + std::numeric_limits<double>::denorm_min());
    }
  }
}

TEST_CASE("math: exp_map is the rotation about an axis, on both sides of its series' limit",
          "[pbd][unit][analytic]") {
  for (const Vec3& axis : directions()) {
    for (const double angle : {1e-4, 9.9999e-4, 1.00001e-3, 0.3, 3.5, 7.0}) {
      const Quat expected(Eigen::AngleAxisd(angle, axis));
      REQUIRE((exp_map(angle * axis).coeffs() - expected.coeffs()).norm() < 1e-15);
    }
  }
}

TEST_CASE("math: log_map takes the shorter arc for either sign of the quaternion", "[pbd][unit]") {
  for (const Vec3& axis : directions()) {
    for (const double angle : {1e-11, 0.2, 2.0, kPi - 1e-9}) {
      const Quat q = exp_map(angle * axis);
      const Quat minus(-q.w(), -q.x(), -q.y(), -q.z());
      REQUIRE((log_map(minus) - angle * axis).norm() < 1e-15 * (1.0 + angle));
      // Beyond half a turn the other way round is shorter.
      const Vec3 back = log_map(exp_map((2.0 * kPi - angle) * axis));
      REQUIRE((back + angle * axis).norm() < 2e-15);
    }
  }
  CHECK(log_map(Quat::Identity()).norm() == 0.0);
  CHECK(log_map(exp_map(Vec3(0.0, kPi, 0.0))).norm() <= kPi * (1.0 + 1e-15));
}

TEST_CASE("math: rotation_between turns one orientation into the other in the world frame",
          "[pbd][unit]") {
  const Quat from = turn(Vec3(0.3, -1.1, 2.0));
  for (const Vec3& axis : directions()) {
    const Vec3 r = 1.3 * axis;
    CHECK((rotation_between(from, turn(r) * from) - r).norm() < 1e-14);
    CHECK(angle_between(rotated(from, r), turn(r) * from) < 1e-15);
  }
}

TEST_CASE("math: a hundred thousand turns leave a quaternion at unit length", "[pbd][unit]") {
  Quat q = Quat::Identity();
  for (int i = 0; i < 100000; ++i) q = rotated(q, Vec3(0.011, -0.007, 0.013));
  CHECK(std::abs(q.norm() - 1.0) < 1e-15);
  // All turns share one axis, so they add up: 100000 |r| modulo a full turn.
  const Quat once = turn(std::fmod(100000.0 * Vec3(0.011, -0.007, 0.013).norm(), 2.0 * kPi) *
                         Vec3(0.011, -0.007, 0.013).normalized());
  CHECK(angle_between(q, once) < 1e-9);
}

TEST_CASE("math: skew is the cross product and tensor_to_world turns a tensor", "[pbd][unit]") {
  const Vec3 a(0.4, -2.0, 1.7);
  const Vec3 b(-1.3, 0.2, 0.9);
  CHECK((skew(a) * b - a.cross(b)).norm() < 1e-15);
  const Mat3 tensor_l = Vec3(1.0, 2.0, 3.0).asDiagonal();
  const Quat q = turn(Vec3(0.0, 0.0, kPi / 2.0));  // x -> y, y -> -x
  const Mat3 expected = Vec3(2.0, 1.0, 3.0).asDiagonal();
  CHECK((tensor_to_world(q, tensor_l) - expected).norm() < 1e-14);
}

TEST_CASE("math: tangent_frame is a right-handed orthonormal frame for every normal",
          "[pbd][unit]") {
  for (const Vec3& n : directions()) {
    Vec3 t1, t2;
    tangent_frame(n, t1, t2);
    INFO("normal " << n.transpose());
    CHECK(std::abs(t1.norm() - 1.0) < 1e-14);
    CHECK(std::abs(t2.norm() - 1.0) < 1e-14);
    CHECK(std::abs(n.dot(t1)) < 1e-14);
    CHECK(std::abs(n.dot(t2)) < 1e-14);
    CHECK(std::abs(t1.dot(t2)) < 1e-14);
    CHECK((n.cross(t1) - t2).norm() < 1e-14);
  }
}

TEST_CASE("math: tangent_frame turns little where the normal turns little", "[pbd][unit]") {
  for (const Vec3& n : directions()) {
    if (n.z() < -0.9) continue;  // the one exception, see its docstring
    Vec3 t1, t2, u1, u2;
    tangent_frame(n, t1, t2);
    if (std::abs(n.z()) < 1e-3) continue;
    tangent_frame(turn(Vec3(1e-6, -2e-6, 1e-6)) * n, u1, u2);
    CHECK((u1 - t1).norm() < 1e-4);
    CHECK((u2 - t2).norm() < 1e-4);
  }
}

TEST_CASE("math: the inverse over free axes is that of the free block alone", "[pbd][analytic]") {
  Mat3 tensor;
  tensor << 4.0, 1.0, 0.5, 1.0, 3.0, 0.2, 0.5, 0.2, 2.0;
  CHECK(inverse_where_free(tensor) == Mat3(tensor.inverse()));
  for (int locked = 0; locked < 3; ++locked) {
    Mat3 held = tensor;
    held.row(locked).setZero();
    held.col(locked).setZero();
    const int i = locked == 0 ? 1 : 0;
    const int j = locked == 2 ? 1 : 2;
    // Cramer's rule for two unknowns.
    const double det = held(i, i) * held(j, j) - held(i, j) * held(i, j);
    Mat3 expected = Mat3::Zero();
    expected(i, i) = held(j, j) / det;
    expected(j, j) = held(i, i) / det;
    expected(i, j) = expected(j, i) = -held(i, j) / det;
    CHECK((inverse_where_free(held) - expected).norm() < 1e-15);
  }
  const Mat3 one_left = Vec3(0.0, 8.0, 0.0).asDiagonal();
  CHECK(inverse_where_free(one_left) == Mat3(Vec3(0.0, 0.125, 0.0).asDiagonal()));
  CHECK(inverse_where_free(Mat3::Zero()).isZero(0.0));
}

}  // namespace math_test
