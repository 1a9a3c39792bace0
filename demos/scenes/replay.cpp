// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "scenes/replay.h"

#include <cmath>
#include <stdexcept>
#include <string>

#include "tandem/pbd/validate.h"

namespace tandem::demos {

namespace {

pbd::Vec3 vec3(const std::vector<double>& v, std::size_t at) {
  return {v[at], v[at + 1], v[at + 2]};
}

pbd::Pose pose(const std::vector<double>& v) {
  pbd::Pose result;
  result.position = vec3(v, 0);
  result.orientation = pbd::Quat(v[6], v[3], v[4], v[5]);
  return result;
}

}  // namespace

ReplayUser::ReplayUser(std::size_t user, std::span<const Input> inputs, Controls& controls)
    : controls_(controls), hands_(controls) {
  for (const Input& input : inputs) {
    if (input.user != user) continue;
    const bool of_body = input.kind != Input::Kind::Signal;
    if (of_body && input.body >= controls.scene().bodies.size()) {
      pbd::detail::refuse("inputs: body", "one of the scene's", input.body);
    }
    inputs_.push_back(input);
  }
}

void ReplayUser::update(consensus::SessionTime /*now*/) {
  const auto due = static_cast<consensus::SessionTime>(std::llround(controls_.time() * 1e9));
  while (next_ < inputs_.size() && inputs_[next_].time <= due) hands_.play(inputs_[next_++]);
}

void InputPlayer::play(const Input& input) {
  const std::vector<double>& v = input.values;
  switch (input.kind) {
    case Input::Kind::Grab:
    case Input::Kind::Hold: {
      consensus::GrabDef def;
      def.attachment_l = vec3(v, 0);
      def.anchor_w = vec3(v, 3);
      def.stiffness = v[6];
      def.damping = v[7];
      def.max_force = v[8];
      springs_[input.object] = input.kind == Input::Kind::Hold ? controls_.hold(input.body, def)
                                                               : controls_.grab(input.body, def);
      return;
    }
    case Input::Kind::Move:
      if (springs_.contains(input.object)) controls_.move(springs_[input.object], vec3(v, 0));
      return;
    case Input::Kind::Release:
      if (springs_.contains(input.object)) controls_.release(springs_[input.object]);
      springs_.erase(input.object);
      return;
    case Input::Kind::Drive:
      controls_.drive(input.body, pose(v));
      return;
    case Input::Kind::Jump:
      controls_.jump(input.body, pose(v));
      return;
    case Input::Kind::Signal:
      controls_.signal(input.object, v[0]);
      return;
  }
}

}  // namespace tandem::demos
