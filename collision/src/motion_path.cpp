// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "motion_path.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tandem/pbd/math.h"

namespace tandem::collision {
namespace {

constexpr int kMaxAdvances = 64;
/// rad: a smaller rotation has no axis.
constexpr double kNoTurn = 1e-6;
/// rad: after a whole turn the radius of the circle cannot be recovered.
constexpr double kMaxTurn = 6.0;

/// The rotation from one orientation to the other, of those that differ by whole turns the one
/// nearest to the rotation by the initial spin.
Vec3 turn_between(const pbd::Pose& from, const pbd::Pose& to, const Vec3& spun) {
  constexpr double kWhole = 2.0 * std::numbers::pi;
  Vec3 turn = pbd::rotation_between(from.orientation, to.orientation);
  const double angle = turn.norm();
  if (angle < kNoTurn) return turn;
  const Vec3 axis = turn / angle;
  return turn + kWhole * std::round((axis.dot(spun) - angle) / kWhole) * axis;
}

ConvexCore placed(const ConvexCore& core, const pbd::Pose& pose, const Vec3& origin) {
  ConvexCore out = core;
  const Mat3 turn = pose.orientation.toRotationMatrix();
  out.centre = pose.position - origin + turn * core.centre;
  out.axes = turn * core.axes;
  return out;
}

}  // namespace

MotionPath::MotionPath(const pbd::Pose& from, const pbd::Pose& to, const pbd::Twist& twist,
                       double dt)
    : from_(from),
      turn_(turn_between(from, to, dt * twist.angular)),
      go_(to.position - from.position) {
  const double angle = turn_.norm();
  if (angle < kNoTurn) return;
  const Vec3 axis = turn_ / angle;
  const Vec3 along = axis.dot(go_) * axis;
  const Vec3 across = go_ - along;
  const pbd::portable::SinCos half = pbd::portable::sin_cos(0.5 * angle);
  if (angle > kMaxTurn) return;
  const Vec3 arm = -0.5 * (across + half.cos / half.sin * axis.cross(across));
  const Vec3 sets_out = dt * twist.linear;
  if ((sets_out - along - turn_.cross(arm)).squaredNorm() >= (sets_out - go_).squaredNorm()) return;
  go_ = along;
  arm_ = arm;
}

pbd::Pose MotionPath::at(double t) const {
  const Vec3 turned = t * turn_;
  pbd::Pose pose{from_.position + t * go_, pbd::exp_map(turned) * from_.orientation};
  if (!arm_.isZero(0.0)) pose.position += pbd::exp_map(turned) * arm_ - arm_;
  pose.orientation.normalize();
  return pose;
}

double MotionPath::speed(const Vec3& n, double reach) const {
  return n.dot(go_) + turn_.norm() * (arm_.norm() + reach);
}

Aabb MotionPath::bounds(double reach) const {
  const Vec3 to = from_.position + go_;
  const Aabb straight{from_.position.cwiseMin(to), from_.position.cwiseMax(to)};
  // No point of a circular path is further from the start than its diameter, or its arc length.
  const double round = std::min(2.0, turn_.norm()) * arm_.norm();
  return straight.expanded(reach + round);
}

SweepHit sweep(const MovingCore& a, const MovingCore& b, double gap) {
  SweepHit hit;
  const double radii = a.core.radius + b.core.radius;
  const bool together = a.stop == b.stop;
  double t = 0.0;
  for (int i = 0; i < kMaxAdvances; ++i) {
    const pbd::Pose pose = a.path.at(std::min(t, a.stop));
    const CoreDistance d =
        core_distance(placed(a.core, pose, pose.position),
                      placed(b.core, b.path.at(std::min(t, b.stop)), pose.position));
    const double between = d.distance - radii;
    if (i == 0) {
      if (!d.apart || between <= 0.0) return {};
      hit.apart = between;
      gap = std::min(gap, 0.5 * between);
    }
    if (!d.apart) return hit;  // by rounding: keep the previous result
    hit.share = t;
    hit.normal = -d.normal;
    if (between <= gap) return hit;
    const double of_a = t < a.stop ? a.path.speed(d.normal, a.reach) : 0.0;
    const double of_b = t < b.stop ? b.path.speed(-d.normal, b.reach) : 0.0;
    // A stopped body no longer moves along with the other one.
    const double closing = together ? of_a + of_b : std::max(0.0, of_a) + std::max(0.0, of_b);
    if (closing > 0.0) t += std::max(d.least - radii - 0.5 * gap, 0.25 * gap) / closing;
    if (closing <= 0.0 || t >= std::max(a.stop, b.stop)) {
      hit.share = 1.0;
      return hit;
    }
  }
  return hit;
}

}  // namespace tandem::collision
