// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "scenes/user.h"

#include <cmath>
#include <numbers>
#include <utility>

namespace tandem::demos {

GripSpec GripSpec::for_load(double load, const pbd::Vec3& spread) {
  constexpr double kSag = 0.01;
  constexpr double kDampingRatio = 0.7;
  constexpr double kStrength = 4.0;
  const double weight = load * 9.81;
  const double hand_stiffness = weight / kSag;
  GripSpec spec;
  spec.stiffness = hand_stiffness / 3.0;
  spec.damping = 2.0 * kDampingRatio * std::sqrt(hand_stiffness * load) / 3.0;
  spec.max_force = kStrength * weight / 3.0;
  spec.spread = spread;
  return spec;
}

void Grip::close(std::size_t body, const pbd::Pose& hand, const GripSpec& spec) {
  const SceneBody& held = scene_.bodies[body];
  const pbd::Pose& pose = scene_.pose(held);
  for (std::size_t i = 0; i < kSprings; ++i) {
    const double angle = 2.0 * std::numbers::pi / 3.0 * static_cast<double>(i);
    anchors_l_[i] = pbd::Vec3(std::cos(angle), std::sin(angle), 0.0).cwiseProduct(spec.spread);
    const pbd::Vec3 anchor_w = hand.to_world(anchors_l_[i]);
    attachments_l_[i] = pose.to_local(anchor_w);
    consensus::GrabDef def;
    def.body = held.id;
    def.attachment_l = attachments_l_[i];
    def.anchor_w = anchor_w;
    def.stiffness = spec.stiffness;
    def.damping = spec.damping;
    def.max_force = spec.max_force;
    springs_[i] = peer_.grab(def);
  }
  body_ = body;
}

void Grip::move(const pbd::Pose& hand, consensus::SessionTime now) {
  for (std::size_t i = 0; i < kSprings; ++i) {
    peer_.move(springs_[i], hand.to_world(anchors_l_[i]), now);
  }
}

void Grip::open() {
  if (!body_) return;
  for (const consensus::GrabId spring : springs_) peer_.release(spring);
  body_.reset();
}

double Grip::stretch(const pbd::Pose& hand) const {
  if (!body_) return 0.0;
  const pbd::Pose& pose = scene_.pose(scene_.bodies[*body_]);
  double sum = 0.0;
  for (std::size_t i = 0; i < kSprings; ++i) {
    sum += (pose.to_world(attachments_l_[i]) - hand.to_world(anchors_l_[i])).norm();
  }
  return sum / static_cast<double>(kSprings);
}

ScriptedUser::ScriptedUser(const Scene& scene, consensus::Peer& peer, const UserOptions& options,
                           std::vector<HandTask> tasks)
    : options_(options),
      tasks_(std::move(tasks)),
      grip_(scene, peer),
      tremor_(options.seed, options.tremor) {}

void ScriptedUser::update(consensus::SessionTime now) {
  const double time = static_cast<double>(now - options_.epoch) * 1e-9;
  if (!grip_.closed()) start_task(time);
  if (grip_.closed()) follow(time, now);
}

void ScriptedUser::start_task(double time) {
  while (next_ < tasks_.size() && time >= tasks_[next_].start) {
    const HandTask& task = tasks_[next_++];
    if (time > task.start + kPatience) continue;
    plan_ = task.plan();
    if (!plan_) continue;
    task_start_ = task.start;
    pbd::Pose hand;
    hand.position = plan_->path.at(time - task_start_);
    grip_.close(plan_->body, hand, plan_->grip);
    return;
  }
}

void ScriptedUser::follow(double time, consensus::SessionTime now) {
  const double task_time = time - task_start_;
  pbd::Pose hand;
  hand.position = plan_->path.at(task_time);
  if (task_time >= plan_->path.end_time() || grip_.stretch(hand) > kMaxStretch) {
    grip_.open();
    return;
  }
  // The tremor fades in, so that the grip closes without a jerk.
  constexpr double kFadeIn = 0.2;
  hand.position += min_jerk(task_time / kFadeIn) * tremor_.at(time);
  grip_.move(hand, now);
}

}  // namespace tandem::demos
