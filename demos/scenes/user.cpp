// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "scenes/user.h"

#include <cmath>
#include <numbers>
#include <utility>

namespace tandem::demos {

GripSpec GripSpec::for_load(double load, const pbd::Vec3& spread) {
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

consensus::GrabDef single_spring(double load) {
  const GripSpec each = GripSpec::for_load(load, pbd::Vec3::Zero());
  consensus::GrabDef def;
  def.stiffness = 3.0 * each.stiffness;
  def.damping = 3.0 * each.damping;
  def.max_force = 3.0 * each.max_force;
  return def;
}

void Sight::look(double time) {
  Frame frame;
  if (!frames_.empty() && frames_.size() > 1 && frames_[1].time <= time - reaction_) {
    frame = std::move(frames_.front());  // reuses its memory
    frames_.pop_front();
  }
  frame.time = time;
  frame.states.clear();
  for (const std::size_t body : bodies_) {
    frame.states.push_back(scene_.world->state(scene_.bodies[body].body));
  }
  frames_.push_back(std::move(frame));
  while (frames_.size() > 1 && frames_[1].time <= time - reaction_) frames_.pop_front();
}

void Grip::close(std::size_t body, const pbd::Pose& hand, const GripSpec& spec) {
  const pbd::Pose& pose = controls_.scene().pose(body);
  for (std::size_t i = 0; i < kSprings; ++i) {
    Spring& spring = springs_[i];
    const double angle = 2.0 * std::numbers::pi / 3.0 * static_cast<double>(i);
    spring.anchor_l = pbd::Vec3(std::cos(angle), std::sin(angle), 0.0).cwiseProduct(spec.spread);
    const pbd::Vec3 anchor_w = hand.to_world(spring.anchor_l);
    spring.attachment_l = pose.to_local(anchor_w);
    consensus::GrabDef def;
    def.attachment_l = spring.attachment_l;
    def.anchor_w = anchor_w;
    def.stiffness = spec.stiffness;
    def.damping = spec.damping;
    def.max_force = spec.max_force;
    spring.id = controls_.grab(body, def);
  }
  body_ = body;
}

void Grip::move(const pbd::Pose& hand) {
  for (const Spring& spring : springs_) controls_.move(spring.id, hand.to_world(spring.anchor_l));
}

void Grip::open() {
  if (!body_) return;
  for (const Spring& spring : springs_) controls_.release(spring.id);
  body_.reset();
}

double Grip::stretch(const pbd::Pose& hand) const {
  if (!body_) return 0.0;
  const pbd::Pose& pose = controls_.scene().pose(*body_);
  double sum = 0.0;
  for (const Spring& spring : springs_) {
    sum += (pose.to_world(spring.attachment_l) - hand.to_world(spring.anchor_l)).norm();
  }
  return sum / static_cast<double>(kSprings);
}

ScriptedUser::ScriptedUser(Controls& controls, const UserOptions& options,
                           std::vector<HandTask> tasks)
    : tasks_(std::move(tasks)),
      controls_(controls),
      grip_(controls),
      tremor_(options.seed, options.tremor) {}

void ScriptedUser::update(consensus::SessionTime /*now*/) {
  const double time = controls_.time();
  if (!grip_.closed()) start_task(time);
  if (grip_.closed()) follow(time);
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

void ScriptedUser::follow(double time) {
  const double task_time = time - task_start_;
  pbd::Pose hand;
  hand.position = plan_->path.at(task_time);
  const bool at_end = task_time >= plan_->path.end_time();
  if (at_end || grip_.stretch(hand) > kMaxStretch) {
    if (at_end) done_ += 1.0;
    grip_.open();
    return;
  }
  // The tremor fades in, so that the grip closes without a jerk.
  constexpr double kFadeIn = 0.2;
  hand.position += min_jerk(task_time / kFadeIn) * tremor_.at(time);
  grip_.move(hand);
}

}  // namespace tandem::demos
