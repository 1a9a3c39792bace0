// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "measure/penetration.h"

#include <algorithm>
#include <cmath>

namespace tandem::bench {
namespace {

constexpr double kTouching = 5e-3;  // m

const BoxShape* box_of(const SceneBody& body) { return std::get_if<BoxShape>(&body.shape); }
const SphereShape* sphere_of(const SceneBody& body) {
  return std::get_if<SphereShape>(&body.shape);
}

}  // namespace

PenetrationProbe::PenetrationProbe(const Scene& scene)
    : scene_(scene), poses_(scene.bodies.size()), reaches_(scene.bodies.size()) {
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const SceneBody& body = scene.bodies[i];
    if (!body.collides) continue;
    if (body.type == BodyType::Static) {
      if (const auto* mesh = std::get_if<MeshShape>(&body.shape)) {
        surface_ = std::make_unique<HeightSurface>(**mesh);
      } else if (box_of(body) != nullptr) {
        fixed_.push_back(i);
      }
    } else if (box_of(body) != nullptr) {
      reaches_[i] = box_of(body)->half_extents.norm();
      moving_.push_back(i);
    } else if (sphere_of(body) != nullptr) {
      reaches_[i] = sphere_of(body)->radius;
      moving_.push_back(i);
    }
  }
  order_ = moving_;
}

double PenetrationProbe::pair_gap(std::size_t a, std::size_t b) const {
  const SceneBody& body_a = scene_.bodies[a];
  const SceneBody& body_b = scene_.bodies[b];
  const SphereShape* sphere_a = sphere_of(body_a);
  const SphereShape* sphere_b = sphere_of(body_b);
  if (sphere_a != nullptr && sphere_b != nullptr) {
    return (poses_[a].position - poses_[b].position).norm() - sphere_a->radius - sphere_b->radius;
  }
  if (sphere_a != nullptr) {
    return sphere_box_gap(sphere_a->radius, poses_[a].position, box_of(body_b)->half_extents,
                          poses_[b]);
  }
  if (sphere_b != nullptr) {
    return sphere_box_gap(sphere_b->radius, poses_[b].position, box_of(body_a)->half_extents,
                          poses_[a]);
  }
  return box_box_gap(box_of(body_a)->half_extents, poses_[a], box_of(body_b)->half_extents,
                     poses_[b]);
}

Penetration PenetrationProbe::measure(const Engine& engine) {
  for (std::size_t i = 0; i < poses_.size(); ++i) {
    poses_[i] = engine.state(static_cast<int>(i)).pose;
  }
  Penetration result;
  double sum = 0.0;
  const auto count = [&](double gap) {
    if (gap >= kTouching) return;
    const double depth = std::max(0.0, -gap);
    ++result.pairs;
    sum += depth;
    result.max = std::max(result.max, depth);
  };
  // Moving pairs: sorted along x, then swept.
  const auto low = [&](std::size_t i) { return poses_[i].position.x() - reaches_[i]; };
  std::sort(order_.begin(), order_.end(),
            [&](std::size_t a, std::size_t b) { return low(a) < low(b); });
  for (std::size_t i = 0; i < order_.size(); ++i) {
    const std::size_t a = order_[i];
    const double end = poses_[a].position.x() + reaches_[a] + kTouching;
    for (std::size_t j = i + 1; j < order_.size() && low(order_[j]) < end; ++j) {
      const std::size_t b = order_[j];
      const double reach = reaches_[a] + reaches_[b] + kTouching;
      if ((poses_[a].position - poses_[b].position).squaredNorm() < reach * reach) {
        count(pair_gap(a, b));
      }
    }
  }
  for (const std::size_t i : moving_) {
    const SceneBody& body = scene_.bodies[i];
    for (const std::size_t wall : fixed_) {
      const Vec3& half = box_of(scene_.bodies[wall])->half_extents;
      count(box_of(body) != nullptr
                ? box_wall_gap(box_of(body)->half_extents, poses_[i], half, poses_[wall])
                : sphere_box_gap(sphere_of(body)->radius, poses_[i].position, half, poses_[wall]));
    }
    if (surface_ != nullptr && sphere_of(body) != nullptr) {
      // A ball farther below has tunnelled, which is counted elsewhere.
      const double radius = sphere_of(body)->radius;
      const auto distance = surface_->distance(poses_[i].position);
      if (distance && *distance > -radius) count(*distance - radius);
    }
  }
  if (result.pairs > 0) result.mean = sum / result.pairs;
  return result;
}

}  // namespace tandem::bench
