// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cmath>
#include <numbers>
#include <vector>

#include "tandem/pbd/world.h"

/// Results of mechanics, without any of the solver's code: the expected values of the tests.
namespace tandem::testing {

using pbd::Mat3;
using pbd::Pose;
using pbd::Quat;
using pbd::Twist;
using pbd::Vec3;

inline constexpr double kPi = std::numbers::pi;
inline constexpr double kGravity = 9.81;      ///< m/s^2, World's default
inline constexpr double kFrame = 1.0 / 60.0;  ///< s

/// Inertia (kg m^2) of a full box with the half extents `half` (m).
inline Mat3 box_inertia(double mass, const Vec3& half) {
  const Vec3 s = half.cwiseProduct(half);
  return Vec3(s.y() + s.z(), s.x() + s.z(), s.x() + s.y()).asDiagonal() * Mat3::Identity() *
         (mass / 3.0);
}

/// Inertia (kg m^2) of a full sphere.
inline Mat3 sphere_inertia(double mass, double radius) {
  return Mat3::Identity() * (0.4 * mass * radius * radius);
}

/// Rotation by a rotation vector (rad), through Eigen's axis-angle.
inline Quat turn(const Vec3& rotation) {
  const double angle = rotation.norm();
  if (angle == 0.0) return Quat(1.0, 0.0, 0.0, 0.0);
  return Quat(Eigen::AngleAxisd(angle, rotation / angle));
}

/// Angle (rad) between two orientations.
inline double angle_between(const Quat& a, const Quat& b) {
  const Quat d = a * b.conjugate();
  return 2.0 * std::atan2(d.vec().norm(), std::abs(d.w()));
}

/// kg m/s, of all dynamic bodies.
inline Vec3 linear_momentum(const pbd::World& world) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 0; i < world.states().size(); ++i) {
    sum += world.all_props()[i].mass * world.states()[i].twist.linear;
  }
  return sum;
}

/// kg m^2/s about the world's origin, of all dynamic bodies.
inline Vec3 angular_momentum(const pbd::World& world) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 0; i < world.states().size(); ++i) {
    const pbd::BodyState& s = world.states()[i];
    const pbd::BodyProps& props = world.all_props()[i];
    const Mat3 r = s.pose.orientation.toRotationMatrix();
    sum += s.pose.position.cross(props.mass * s.twist.linear) +
           r * props.inertia * r.transpose() * s.twist.angular;
  }
  return sum;
}

/// Period (s) of a pendulum of any amplitude (rad), by the arithmetic-geometric mean:
/// T = 2 pi / (w0 agm(1, cos(amplitude / 2))).
/// @param w0  rad/s of small swings: sqrt(m g d / I about the pivot)
inline double pendulum_period(double w0, double amplitude) {
  double a = 1.0;
  double g = std::cos(0.5 * amplitude);
  for (int i = 0; i < 40 && a != g; ++i) {
    const double mean = 0.5 * (a + g);
    g = std::sqrt(a * g);
    a = mean;
  }
  return 2.0 * kPi / (w0 * a);
}

/// Implicit Euler for m x'' = -k x - c x' + f, closed form of one step: an XPBD row with compliance
/// 1/k is exactly that.
struct ImplicitSpring {
  double mass = 1.0;
  double stiffness = 0.0;
  double damping = 0.0;
  double force = 0.0;
  double x = 0.0;
  double v = 0.0;

  void step(double h) {
    v = (mass * v + h * (force - stiffness * x)) / (mass + h * damping + h * h * stiffness);
    x += h * v;
  }
};

/// Minimise 1/2 sum m_i |x_i - p_i|^2 subject to J x = b: dense Karush-Kuhn-Tucker system.
inline Eigen::VectorXd constrained_least_squares(const Eigen::MatrixXd& mass,
                                                 const Eigen::VectorXd& wanted,
                                                 const Eigen::MatrixXd& jacobian,
                                                 const Eigen::VectorXd& right) {
  const auto n = wanted.size();
  const auto m = right.size();
  Eigen::MatrixXd kkt = Eigen::MatrixXd::Zero(n + m, n + m);
  kkt.topLeftCorner(n, n) = mass;
  kkt.topRightCorner(n, m) = jacobian.transpose();
  kkt.bottomLeftCorner(m, n) = jacobian;
  Eigen::VectorXd known(n + m);
  known << mass * wanted, right;
  return Eigen::VectorXd(kkt.fullPivLu().solve(known)).head(n);
}

/// Mean time (s) between upward zero crossings, linearly interpolated; `samples` are `dt` apart.
inline double mean_period(const std::vector<double>& samples, double dt) {
  std::vector<double> crossings;
  for (std::size_t i = 1; i < samples.size(); ++i) {
    if (samples[i - 1] < 0.0 && samples[i] >= 0.0) {
      crossings.push_back(dt *
                          (static_cast<double>(i) - samples[i] / (samples[i] - samples[i - 1])));
    }
  }
  if (crossings.size() < 2) return 0.0;
  return (crossings.back() - crossings.front()) / static_cast<double>(crossings.size() - 1);
}

}  // namespace tandem::testing
