// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "peer/fidget.h"

#include <algorithm>

namespace tandem::demos {

namespace {

constexpr double kSlip = 0.6;     // m: a body farther from the hand is released
constexpr double kHeaviest = 10;  // kg

}  // namespace

Fidget::Fidget(Controls& controls, std::uint64_t seed) : controls_(controls), random_(seed) {
  const Scene& scene = controls.scene();
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const SceneBody& body = scene.bodies[i];
    if (body.collides && !body.owner && scene.mass(i) <= kHeaviest) bodies_.push_back(i);
  }
  next_ = random_.uniform(0.5, 2.0);
}

void Fidget::update(consensus::SessionTime /*now*/) {
  const double time = controls_.time();
  if (!body_) {
    if (time >= next_ && !bodies_.empty()) grab(time);
    return;
  }
  const pbd::Vec3 hand = path_->at(time);
  if (time >= path_->end_time() ||
      (hand - controls_.scene().pose(*body_).position).norm() > kSlip) {
    let_go(time);
    return;
  }
  controls_.move(spring_, hand);
}

void Fidget::grab(double time) {
  const Scene& scene = controls_.scene();
  // The hand goes to some body's start, and grasps the nearest body there.
  const pbd::Vec3 place = scene.bodies[bodies_[random_.below(bodies_.size())]].start;
  const std::size_t body =
      *std::min_element(bodies_.begin(), bodies_.end(), [&](std::size_t a, std::size_t b) {
        return (scene.pose(a).position - place).squaredNorm() <
               (scene.pose(b).position - place).squaredNorm();
      });
  const pbd::Vec3 from = scene.pose(body).position;
  pbd::Vec3 to = scene.bodies[body].start;
  to.x() += random_.uniform(-kReach, kReach);
  to.y() += random_.uniform(-kReach, kReach);
  const double height = random_.uniform(0.1, 0.3);
  const pbd::Vec3 above(0.0, 0.0, height);
  // At a hand's pace: 0.6 m/s on average.
  const double travel = std::max(0.6, (to - from).norm() / 0.6);

  consensus::GrabDef def = single_spring(scene.mass(body));
  def.anchor_w = from;
  spring_ = controls_.grab(body, def);
  body_ = body;
  path_.emplace(time, from);
  path_->move_by(above, 0.6)
      .move_to(to + above, travel)
      .wait(random_.uniform(0.0, 1.0))
      .move_by(-0.8 * above, 0.6);
}

void Fidget::let_go(double time) {
  controls_.release(spring_);
  body_.reset();
  ++done_;
  next_ = time + random_.uniform(0.3, 2.0);
}

}  // namespace tandem::demos
