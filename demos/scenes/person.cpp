// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "scenes/person.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace tandem::demos {

namespace {

using pbd::Vec3;

std::vector<std::size_t> everything(const Scene& scene) {
  std::vector<std::size_t> bodies(scene.bodies.size());
  std::iota(bodies.begin(), bodies.end(), std::size_t{0});
  return bodies;
}

}  // namespace

Person::Person(std::size_t user, Controls& controls, const UserOptions& options)
    : user_(user),
      controls_(controls),
      sight_(controls.scene(), everything(controls.scene()), options.reaction),
      random_(derived_seed(options.seed, 20)),
      head_(controls.scene().index_of("head/" + std::to_string(user))) {
  head_pose_.position = controls.scene().bodies[head_].start;
  for (int which = 0; which < 2; ++which) {
    const std::string name = "hand/" + std::to_string(user) + "/" + std::to_string(which);
    const std::size_t avatar = controls.scene().index_of(name);
    hands_.push_back({MinJerkMove(controls.scene().bodies[avatar].start), Grip(controls),
                      Tremor(derived_seed(options.seed, 21 + index(which)), options.tremor), 0.0,
                      avatar});
  }
}

void Person::update(consensus::SessionTime /*now*/) {
  sight_.look(time());
  act();
  const double end = time() + controls_.dt();
  head_pose_.orientation = pbd::Quat::Identity();
  controls_.drive(head_, head_pose_);
  for (Hand& hand : hands_) {
    follow(hand);
    pbd::Pose pose;
    pose.position = hand.move.at(end).position + hand.tremor.at(end);
    controls_.drive(hand.avatar, pose);
  }
}

void Person::act() {
  while (next_ < script_.size()) {
    const bool done = script_[next_].act(*this);
    const bool tired = acting() > script_[next_].patience;
    if (!done && !tired) return;
    if (!done) add_score("given_up", 1.0);
    ++next_;
    act_start_ = time();
  }
}

void Person::follow(Hand& hand) {
  if (!hand.grip.closed()) return;
  pbd::Pose pose;
  pose.position = hand.move.at(time()).position;
  if (hand.grip.stretch(pose) > kMaxStretch) {
    hand.grip.open();
    add_score("torn_away", 1.0);
    return;
  }
  // The tremor fades in, so that the grip closes without a jerk.
  constexpr double kFadeIn = 0.2;
  pose.position += min_jerk((time() - hand.grasped) / kFadeIn) * hand.tremor.at(time());
  hand.grip.move(pose);
}

void Person::reach(int which, const Vec3& to, double duration) {
  const double way = (to - hand(which)).norm();
  const double calm = std::max(kMinJerkPeak * way / kMaxSpeed,
                               std::sqrt(kMinJerkPeakAcceleration * way / kMaxAcceleration));
  swing(which, to, Vec3::Zero(), std::max(duration, calm));
}

void Person::swing(int which, const Vec3& to, const Vec3& velocity, double duration) {
  Hand& hand = hands_[index(which)];
  MinJerkMove::State end;
  end.position = to;
  end.velocity = velocity;
  hand.move = MinJerkMove(time(), hand.move.at(time()), time() + duration, end);
}

void Person::grasp(int which, std::size_t body, double load, const Vec3& spread) {
  Hand& hand = hands_[index(which)];
  hand.grip.open();
  pbd::Pose pose;
  pose.position = hand.move.at(time()).position;
  hand.grip.close(body, pose, GripSpec::for_load(load, spread));
  hand.grasped = time();
}

void Person::teleport(const Vec3& feet) {
  const Vec3 offset(feet.x() - head_pose_.position.x(), feet.y() - head_pose_.position.y(), 0.0);
  head_pose_.position += offset;
  controls_.jump(head_, head_pose_);
  for (Hand& hand : hands_) {
    hand.grip.open();
    hand.move = MinJerkMove(hand.move.at(time()).position + offset);
    pbd::Pose pose;
    pose.position = hand.move.at(time()).position + hand.tremor.at(time());
    controls_.jump(hand.avatar, pose);
  }
  add_score("teleports", 1.0);
}

void Person::add_score(const std::string& name, double value) {
  for (auto& [known, sum] : score_) {
    if (known != name) continue;
    sum += value;
    return;
  }
  score_.emplace_back(name, value);
}

}  // namespace tandem::demos
