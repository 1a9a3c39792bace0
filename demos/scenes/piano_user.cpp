// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "scenes/piano_user.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tandem::demos {

namespace {

using pbd::Vec3;

/// A point of the piano with its velocity, for the device loop.
HapticPoint point_of(const pbd::BodyState& state, const Vec3& local) {
  const Vec3 arm = state.pose.orientation * local;
  return {state.pose.position + arm, state.twist.linear + state.twist.angular.cross(arm)};
}

}  // namespace

PianoUser::PianoUser(std::size_t user, const PianoOptions& piano, Controls& controls,
                     const UserOptions& options)
    : user_(user),
      piano_(piano),
      controls_(controls),
      body_(controls.scene().index_of("piano")),
      sight_(controls.scene(), {body_}, options.reaction),
      tremor_(options.seed, options.tremor),
      home_(path_.handle(user, 0.0, 0.2)),
      device_(piano.device, home_) {
  energy_.name = "energy_J";
  force_.name = "force_N";
}

void PianoUser::update(consensus::SessionTime /*now*/) {
  const double time = controls_.time();
  sight_.look(time);
  const Vec3 hand = meant(time) + min_jerk(time) * tremor_.at(time);
  const double passed = last_ < 0.0 ? 0.0 : time - last_;
  last_ = time;
  const bool mouse = piano_.mouse && user_ == 1;
  // Since the last frame the device has run on that frame's proxy.
  if (!mouse) {
    device_.run(passed, hand, proxy_);
    energy_.times.push_back(time);
    energy_.values.push_back(device_.energy());
    force_.times.push_back(time);
    force_.values.push_back(device_.force());
  }
  const Vec3 end = mouse ? hand : device_.pen().position;

  if (!spring_ && time >= kGraspAt && done_at_ < 0.0) take_hold();
  if (spring_) {
    controls_.move(*spring_, end);
    const pbd::BodyId body = controls_.scene().bodies[body_].body;
    proxy_ = point_of(controls_.scene().world->state(body), piano_handle(user_));
    if (!piano_.tug && seen_progress_ > path_.duration() - 0.1 && progress_ >= path_.duration()) {
      if (done_at_ < 0.0) done_at_ = time;
      if (time > done_at_ + 1.0) {
        controls_.release(*spring_);
        spring_.reset();
        proxy_.reset();
      }
    }
  }
}

void PianoUser::take_hold() {
  const pbd::Pose& pose = controls_.scene().pose(body_);
  consensus::GrabDef def;
  def.attachment_l = piano_handle(user_);
  // The pen is within a millimetre or two of the handle.
  const bool mouse = piano_.mouse && user_ == 1;
  def.anchor_w = mouse ? pose.to_world(def.attachment_l) : device_.pen().position;
  def.stiffness = piano_.device.coupling_stiffness;
  def.damping = piano_.device.coupling_damping;
  def.max_force = piano_.device.force_limit;
  spring_ = piano_.soft ? controls_.grab(body_, def) : controls_.hold(body_, def);
}

void PianoUser::follow_progress(double time) {
  if (time < kGoAt) return;
  // The seen piano's progress on the path, searched near its last value.
  const pbd::Pose& seen = sight_.seen(0).pose;
  const auto distance = [&](double s) {
    double sum = 0.0;
    for (std::size_t end = 0; end < 2; ++end) {
      const Vec3 handle = seen.to_world(piano_handle(end));
      sum += (handle - path_.handle(end, s, handle.z())).squaredNorm();
    }
    return sum;
  };
  double best = seen_progress_;
  for (double s = seen_progress_; s <= seen_progress_ + 1.0; s += 0.02) {
    if (distance(s) <= distance(best)) best = s;
  }
  seen_progress_ = std::min(best, path_.duration());
  const double next = std::min(progress_ + controls_.dt(), seen_progress_ + kLead);
  progress_ = std::clamp(next, progress_, path_.duration());
}

Vec3 PianoUser::meant(double time) {
  const pbd::Pose& start = controls_.scene().pose(body_);
  if (time < kGraspAt) {
    const Vec3 handle = start.to_world(piano_handle(user_));
    return home_ + min_jerk((time - 0.3) / (kGraspAt - 0.5)) * (handle - home_);
  }
  follow_progress(time);
  const double height = controls_.scene().bodies[body_].start.z() + piano_handle(user_).z();
  Vec3 hand = path_.handle(user_, progress_, height);
  if (piano_.tug) {
    // Apart and together again by 5 cm, until the session ends.
    hand = path_.handle(user_, 0.0, height);
    const double phase = std::sin(std::max(0.0, time - kGoAt) * 2.0 * std::numbers::pi / 4.0);
    hand.y() += (user_ == 0 ? -0.05 : 0.05) * phase;
  }
  return hand;
}

Outcome PianoUser::outcome() const {
  Outcome result{{"progress", seen_progress_ / path_.duration()}};
  if (piano_.mouse && user_ == 1) return result;
  result.emplace_back("force_max_N", device_.largest_force());
  result.emplace_back("force_wanted_N", device_.largest_wanted());
  result.emplace_back("energy_min_J", device_.least_energy());
  result.emplace_back("energy_J", device_.energy());
  result.emplace_back("energy_taken_out_J", device_.taken_out());
  result.emplace_back("pen_fastest_m_s", device_.fastest());
  return result;
}

}  // namespace tandem::demos
