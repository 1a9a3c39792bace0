// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "body_def.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <vector>

#include "free_rotation.h"
#include "tandem/pbd/typed_block.h"
#include "tandem/pbd/validate.h"

namespace tandem::pbd {

void check_pose(const Pose& pose, std::string_view kind) {
  detail::require_finite(pose.position, kind, "pose.position");
  detail::require_unit(pose.orientation, kind, "pose.orientation");
}

void check_twist(const Twist& twist, std::string_view kind) {
  detail::require_finite(twist.linear, kind, "twist.linear");
  detail::require_finite(twist.angular, kind, "twist.angular");
}

void check_damping(double linear, double angular, std::string_view kind) {
  detail::require(linear >= 0.0 && std::isfinite(linear), kind, "linear_damping", linear,
                  "finite and >= 0");
  detail::require(angular >= 0.0 && std::isfinite(angular), kind, "angular_damping", angular,
                  "finite and >= 0");
}

void check_def(const BodyDef& def) {
  constexpr std::string_view kKind = "BodyDef";
  check_pose(def.pose, kKind);
  check_twist(def.twist, kKind);
  detail::require(std::isfinite(def.gravity_scale), kKind, "gravity_scale", def.gravity_scale,
                  "finite");
  check_damping(def.linear_damping, def.angular_damping, kKind);
  detail::require_finite(def.origin, kKind, "origin");
  detail::require_in(0.0, 1e6, kKind, "sleep_speed", def.sleep_speed.value_or(0.0), "m/s");
  detail::require_in(0.0, 1e6, kKind, "sleep_spin", def.sleep_spin.value_or(0.0), "rad/s");
  if (def.type != BodyType::Dynamic) return;
  detail::require(def.mass > 0.0 && std::isfinite(def.mass), kKind, "mass", def.mass,
                  "finite and > 0");
  detail::require(std::isfinite(1.0 / def.mass), kKind, "mass", def.mass,
                  "not too small for its inverse");
  detail::require(def.inertia.allFinite(), kKind, "inertia", def.inertia.sum(), "finite");
  const double asymmetry = (def.inertia - def.inertia.transpose()).cwiseAbs().maxCoeff();
  const double size = def.inertia.cwiseAbs().maxCoeff();
  detail::require(asymmetry <= 1e-9 * size, kKind, "inertia", asymmetry, "symmetric");
  const Eigen::SelfAdjointEigenSolver<Mat3> eigen(def.inertia, Eigen::EigenvaluesOnly);
  const Vec3& moments = eigen.eigenvalues();  // ascending
  detail::require(moments[0] > 0.0, kKind, "inertia", moments[0], "positive definite");
  const double off = (def.inertia.inverse() * def.inertia - Mat3::Identity()).norm();
  detail::require(off < 1e-3, kKind, "inertia", moments[0],
                  "neither too small nor too large for its inverse");
  detail::require(moments[0] + moments[1] >= moments[2] * (1.0 - 1e-6), kKind, "inertia",
                  moments[2], "such that its largest moment is at most the sum of the other two");
}

BodyProps make_props(const BodyDef& def) {
  BodyProps props;
  props.type = def.type;
  props.gravity_scale = def.gravity_scale;
  props.stable_id = def.stable_id;
  props.origin = def.origin;
  if (def.type == BodyType::Dynamic) {
    props.mass = def.mass;
    props.inverse_mass = 1.0 / def.mass;
    props.inertia = 0.5 * (def.inertia + def.inertia.transpose());
    props.inverse_inertia = props.inertia.inverse();
    props.principal = principal_axes(props.inertia);
    props.linear_damping = def.linear_damping;
    props.angular_damping = def.angular_damping;
    props.locks = def.locks;
    props.bullet = def.bullet;
    props.can_sleep = def.can_sleep;
    props.sleep_speed = def.sleep_speed;
    props.sleep_spin = def.sleep_spin;
  }
  return props;
}

namespace detail {

bool are_free_slots(std::span<const std::uint32_t> free, std::span<const std::uint8_t> alive) {
  std::vector<std::uint8_t> known(alive.begin(), alive.end());
  for (const std::uint32_t slot : free) {
    if (slot >= known.size() || known[slot] != 0) return false;
    known[slot] = 1;
  }
  return std::all_of(known.begin(), known.end(), [](std::uint8_t k) { return k != 0; });
}

}  // namespace detail

}  // namespace tandem::pbd
