// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "peer/fidget.h"

#include <algorithm>
#include <utility>

#include "scenes/user.h"

namespace tandem::demos {

namespace {

constexpr double kSlip = 0.6;     // m: what is so far from the hand is let go
constexpr double kHeaviest = 10;  // kg

}  // namespace

Fidget::Fidget(const Scene& scene, consensus::Peer& peer, std::uint64_t seed)
    : scene_(scene), peer_(peer), random_(seed) {
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const SceneBody& body = scene.bodies[i];
    if (body.collides && !body.owner && scene.mass(i) <= kHeaviest) bodies_.push_back(i);
  }
  next_ = random_.uniform(0.5, 2.0);
}

void Fidget::update(consensus::SessionTime now) {
  inputs_.clear();
  if (!start_) start_ = now;
  const double time = 1e-9 * static_cast<double>(now - *start_);
  if (!body_) {
    if (time >= next_ && !bodies_.empty()) grab(time);
    return;
  }
  const pbd::Vec3 hand = path_->at(time);
  if (time >= path_->end_time() || (hand - scene_.pose(*body_).position).norm() > kSlip) {
    let_go(time);
    return;
  }
  peer_.move(spring_, hand, now);
  note(Input::Kind::Move, {hand.x(), hand.y(), hand.z()});
}

void Fidget::grab(double time) {
  // The hand goes to where some body began, and takes what is nearest there.
  const pbd::Vec3 place = scene_.bodies[bodies_[random_.below(bodies_.size())]].start;
  const std::size_t body =
      *std::min_element(bodies_.begin(), bodies_.end(), [&](std::size_t a, std::size_t b) {
        return (scene_.pose(a).position - place).squaredNorm() <
               (scene_.pose(b).position - place).squaredNorm();
      });
  const pbd::Vec3 from = scene_.pose(body).position;
  pbd::Vec3 to = scene_.bodies[body].start;
  to.x() += random_.uniform(-kReach, kReach);
  to.y() += random_.uniform(-kReach, kReach);
  const double height = random_.uniform(0.1, 0.3);
  const pbd::Vec3 above(0.0, 0.0, height);
  // Slow enough for a hand: 0.6 m/s on the average.
  const double travel = std::max(0.6, (to - from).norm() / 0.6);

  consensus::GrabDef def = single_spring(scene_.mass(body));
  def.body = scene_.bodies[body].id;
  def.anchor_w = from;
  spring_ = peer_.grab(def);
  if (spring_ == consensus::GrabId{}) return;
  body_ = body;
  ++grabs_;
  note(Input::Kind::Grab,
       {0.0, 0.0, 0.0, from.x(), from.y(), from.z(), def.stiffness, def.damping, def.max_force});
  path_.emplace(time, from);
  path_->move_by(above, 0.6)
      .move_to(to + above, travel)
      .wait(random_.uniform(0.0, 1.0))
      .move_by(-0.8 * above, 0.6);
}

void Fidget::let_go(double time) {
  peer_.release(spring_);
  note(Input::Kind::Release, {});
  body_.reset();
  ++done_;
  next_ = time + random_.uniform(0.3, 2.0);
}

void Fidget::note(Input::Kind kind, std::vector<double> values) {
  Input input;
  input.user = kUser;
  input.kind = kind;
  input.object = grabs_;
  input.body = static_cast<std::uint32_t>(*body_);
  input.values = std::move(values);
  inputs_.push_back(std::move(input));
}

}  // namespace tandem::demos
