// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// A translation unit of its own: programs that draw nothing do not link it.
#include "tandem/pbd/smooth_poses.h"

#include <algorithm>
#include <cmath>

#include "tandem/pbd/math.h"
#include "tandem/pbd/portable.h"
#include "tandem/pbd/validate.h"
#include "tandem/pbd/world.h"

namespace tandem::pbd {
namespace {

/// m and rad in a step, beyond the motion by speed: contacts that push bodies apart
/// (ContactOptions::push_speed) stay below it.
constexpr double kJump = 0.02;

struct Change {
  Vec3 moved = Vec3::Zero();   ///< m
  Vec3 turned = Vec3::Zero();  ///< rad, world
};

/// The part of the change of state that is no motion: agreement, and jumps.
Change jump_of(const BodyState& from, const BodyState& to, const Correction& agreed, double dt) {
  Change change{agreed.translation, agreed.rotation};
  const Vec3 way = to.pose.position - from.pose.position;
  const Vec3 turn = rotation_between(from.pose.orientation, to.pose.orientation);
  const double speed = std::max(from.twist.linear.norm(), to.twist.linear.norm());
  const double spin = std::max(from.twist.angular.norm(), to.twist.angular.norm());
  if ((way - change.moved).norm() > speed * dt + kJump) change.moved = way - dt * to.twist.linear;
  if ((turn - change.turned).norm() > spin * dt + kJump) {
    change.turned = turn - dt * to.twist.angular;
  }
  return change;
}

}  // namespace

SmoothPoses::SmoothPoses(const SmoothPosesOptions& options) : options_(options) {
  detail::require(options.blend >= 0.0 && std::isfinite(options.blend), "SmoothPosesOptions",
                  "blend", options.blend, "finite and >= 0");
  detail::require(options.snap > 0.0, "SmoothPosesOptions", "snap", options.snap, "> 0");
}

void SmoothPoses::after_step(const World& world, double dt) {
  detail::require(dt > 0.0 && std::isfinite(dt), "SmoothPoses::after_step", "dt", dt,
                  "finite and > 0");
  if (shown_.size() < world.slot_count()) shown_.resize(world.slot_count());
  const double keeps = options_.blend > 0.0 ? portable::exp(-dt / options_.blend) : 0.0;
  for (std::uint32_t i = 0; i < shown_.size(); ++i) {
    const BodyId body = world.body_at(i);
    const bool known = shown_[i].body == body;
    shown_[i].body = body;
    if (!body.valid()) continue;
    if (known) {
      take(shown_[i], world, dt, keeps);
    } else {
      const BodyState& state = world.state(body);
      shown_[i] = {.body = body, .world = state, .before = state.pose, .now = state.pose};
    }
  }
}

void SmoothPoses::take(Shown& shown, const World& world, double dt, double keeps) const {
  const BodyState& state = world.state(shown.body);
  const Change jump = jump_of(shown.world, state, world.correction(shown.body), dt);
  shown.before = shown.now;
  shown.behind = keeps * (shown.behind + jump.moved);
  shown.behind_turn = exp_map(keeps * log_map(exp_map(jump.turned) * shown.behind_turn));
  shown.world = state;
  if (jump.moved.norm() > options_.snap) {
    shown.behind.setZero();
    shown.behind_turn.setIdentity();
    shown.before = state.pose;
  }
  shown.now = {state.pose.position - shown.behind, state.pose.orientation};
  if (shown.behind_turn.vec().isZero(0.0)) return;  // the world's own pose, to the last bit
  shown.now.orientation = (shown.behind_turn.conjugate() * state.pose.orientation).normalized();
}

Pose SmoothPoses::at(BodyId body, double alpha) const {
  if (body.index >= shown_.size() || shown_[body.index].body != body) {
    detail::refuse("SmoothPoses::at: body", "one that the last after_step() saw",
                   static_cast<double>(body.index));
  }
  const Shown& shown = shown_[body.index];
  if (!(alpha < 1.0)) return shown.now;
  const double t = std::max(0.0, alpha);
  const Vec3 turn = rotation_between(shown.before.orientation, shown.now.orientation);
  return {shown.before.position + t * (shown.now.position - shown.before.position),
          rotated(shown.before.orientation, t * turn)};
}

}  // namespace tandem::pbd
