// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "session/geometry.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <variant>

namespace tandem::demos {

namespace {

/// Half width of a box projected on the unit direction `axis`, m.
double reach(const pbd::Mat3& axes, const pbd::Vec3& half, const pbd::Vec3& axis) {
  return (axes.transpose() * axis).cwiseAbs().dot(half);
}

struct Solid {
  double low = 0.0, high = 0.0;
  std::size_t body = 0;  ///< index in the scene; beyond: fixed
  pbd::Pose pose;
  const collision::Box* box = nullptr;
  const collision::Sphere* ball = nullptr;
};

double overlap(const Solid& a, const Solid& b) {
  if (a.box != nullptr && b.box != nullptr) {
    return box_overlap(a.pose, a.box->half_extents, b.pose, b.box->half_extents);
  }
  if (a.box != nullptr) {
    return ball_box_overlap(b.pose.position, b.ball->radius, a.pose, a.box->half_extents);
  }
  if (b.box != nullptr) return overlap(b, a);
  const double apart = (a.pose.position - b.pose.position).norm();
  return std::max(0.0, a.ball->radius + b.ball->radius - apart);
}

void add_solid(const collision::Shape& shape, const pbd::Pose& pose, std::size_t body,
               std::vector<Solid>& out) {
  Solid solid;
  solid.body = body;
  solid.pose = pose;
  solid.box = std::get_if<collision::Box>(&shape);
  solid.ball = std::get_if<collision::Sphere>(&shape);
  if (solid.box == nullptr && solid.ball == nullptr) return;
  const double r = solid.ball != nullptr ? solid.ball->radius
                                         : reach(pose.orientation.toRotationMatrix(),
                                                 solid.box->half_extents, pbd::Vec3::UnitX());
  solid.low = pose.position.x() - r;
  solid.high = pose.position.x() + r;
  out.push_back(solid);
}

/// All boxes and balls with contacts, and whether there is a ground.
bool collect_solids(const Scene& scene, std::vector<Solid>& out) {
  bool ground = false;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const SceneBody& body = scene.bodies[i];
    if (!body.collides) continue;
    const pbd::Pose& pose = scene.pose(body);
    for (const ScenePart& part : body.parts) {
      add_solid(part.shape,
                {pose.to_world(part.local.position), pose.orientation * part.local.orientation}, i,
                out);
    }
  }
  for (const FixedPart& fixed : scene.fixed) {
    const auto* half_space = std::get_if<collision::HalfSpace>(&fixed.shape);
    ground = ground || (half_space != nullptr && half_space->normal.z() == 1.0);
    add_solid(fixed.shape, fixed.pose, scene.bodies.size(), out);
  }
  return ground;
}

}  // namespace

double box_overlap(const pbd::Pose& a, const pbd::Vec3& half_a, const pbd::Pose& b,
                   const pbd::Vec3& half_b) {
  const pbd::Mat3 axes_a = a.orientation.toRotationMatrix();
  const pbd::Mat3 axes_b = b.orientation.toRotationMatrix();
  const pbd::Vec3 between = b.position - a.position;
  double least = std::numeric_limits<double>::max();
  const auto try_axis = [&](const pbd::Vec3& axis) {
    const double depth =
        reach(axes_a, half_a, axis) + reach(axes_b, half_b, axis) - std::abs(axis.dot(between));
    least = std::min(least, depth);
    return depth > 0.0;
  };
  for (int i = 0; i < 3; ++i) {
    if (!try_axis(axes_a.col(i)) || !try_axis(axes_b.col(i))) return 0.0;
  }
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const pbd::Vec3 cross = axes_a.col(i).cross(axes_b.col(j));
      const double norm = cross.norm();
      if (norm < 1e-6) continue;  // parallel edges: the face axes decide
      if (!try_axis(cross / norm)) return 0.0;
    }
  }
  return least;
}

double ground_overlap(const pbd::Pose& pose, const pbd::Vec3& half) {
  const pbd::Mat3 axes = pose.orientation.toRotationMatrix();
  return std::max(0.0, reach(axes, half, pbd::Vec3::UnitZ()) - pose.position.z());
}

double ball_box_overlap(const pbd::Vec3& centre, double radius, const pbd::Pose& box,
                        const pbd::Vec3& half) {
  const pbd::Vec3 local = box.to_local(centre);
  const pbd::Vec3 nearest = local.cwiseMax(-half).cwiseMin(half);
  const double apart = (local - nearest).norm();
  if (apart > 0.0) return std::max(0.0, radius - apart);
  return radius + (half - local.cwiseAbs()).minCoeff();
}

void append_penetrations(const Scene& scene, std::vector<double>& out) {
  std::vector<Solid> solids;
  if (collect_solids(scene, solids)) {
    for (const Solid& solid : solids) {
      if (solid.body == scene.bodies.size()) continue;
      const double below = solid.box != nullptr
                               ? ground_overlap(solid.pose, solid.box->half_extents)
                               : std::max(0.0, solid.ball->radius - solid.pose.position.z());
      if (below > 0.0) out.push_back(below);
    }
  }
  std::stable_sort(solids.begin(), solids.end(),
                   [](const Solid& a, const Solid& b) { return a.low < b.low; });
  for (std::size_t i = 0; i < solids.size(); ++i) {
    for (std::size_t j = i + 1; j < solids.size() && solids[j].low < solids[i].high; ++j) {
      if (solids[i].body == solids[j].body) continue;
      const double depth = overlap(solids[i], solids[j]);
      if (depth > 0.0) out.push_back(depth);
    }
  }
}

std::string out_of_bounds(const Scene& scene, const Bounds& bounds) {
  // Written so that NaN is out of bounds.
  for (const SceneBody& body : scene.bodies) {
    const pbd::BodyState& state = scene.world->state(body.body);
    if (!(state.pose.position.norm() < bounds.max_distance)) return body.name + " is too far away";
    if (state.pose.position.z() < bounds.lowest) return body.name + " fell through the ground";
    if (!(state.twist.linear.norm() < bounds.max_speed)) return body.name + " is too fast";
  }
  return {};
}

}  // namespace tandem::demos
