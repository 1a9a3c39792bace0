// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "scenes/controls.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "tandem/pbd/math.h"

namespace tandem::demos {

namespace {

void append(std::vector<double>& values, const pbd::Vec3& v) {
  values.insert(values.end(), {v.x(), v.y(), v.z()});
}
void append(std::vector<double>& values, const pbd::Pose& pose) {
  append(values, pose.position);
  const pbd::Quat& q = pose.orientation;
  values.insert(values.end(), {q.x(), q.y(), q.z(), q.w()});
}

}  // namespace

Controls::Controls(std::size_t user, Scene& scene, consensus::Peer& peer,
                   consensus::SessionTime epoch, SignalSink* signals)
    : user_(user), scene_(scene), peer_(peer), epoch_(epoch), signals_(signals), now_(epoch) {}

void Controls::begin(consensus::SessionTime now, double dt) {
  now_ = now;
  dt_ = dt;
  if (!keeps_log_) log_.clear();
}

Input& Controls::note(Input::Kind kind, std::uint32_t object, std::size_t body) {
  Input input;
  input.user = static_cast<std::uint32_t>(user_);
  input.time = now_ - epoch_;
  input.kind = kind;
  input.object = object;
  input.body = static_cast<std::uint32_t>(body);
  log_.push_back(std::move(input));
  return log_.back();
}

std::uint32_t Controls::add(Input::Kind kind, std::size_t body, const consensus::GrabDef& def,
                            std::optional<consensus::InputMode> mode) {
  consensus::GrabDef own = def;
  own.body = scene_.bodies[body].id;
  own.mode = mode;
  springs_[next_] = {.id = peer_.grab(own), .body = body, .def = own};
  Input& input = note(kind, next_, body);
  append(input.values, def.attachment_l);
  append(input.values, def.anchor_w);
  input.values.insert(input.values.end(), {def.stiffness, def.damping, def.max_force});
  return next_++;
}

std::uint32_t Controls::grab(std::size_t body, const consensus::GrabDef& def) {
  return add(Input::Kind::Grab, body, def, def.mode);
}

std::uint32_t Controls::hold(std::size_t body, const consensus::GrabDef& def) {
  return add(Input::Kind::Hold, body, def, consensus::InputMode::Asymmetric);
}

void Controls::move(std::uint32_t spring, const pbd::Vec3& anchor_w) {
  Spring& held = springs_.at(spring);
  held.def.anchor_w = anchor_w;
  append(note(Input::Kind::Move, spring, held.body).values, anchor_w);
  peer_.move(held.id, anchor_w, now_ + clock_ahead_);
}

void Controls::release(std::uint32_t spring) {
  const auto found = springs_.find(spring);
  if (found == springs_.end()) return;
  peer_.release(found->second.id);
  note(Input::Kind::Release, spring, found->second.body);
  springs_.erase(found);
}

void Controls::drive(std::size_t body, const pbd::Pose& pose) {
  append(note(Input::Kind::Drive, static_cast<std::uint32_t>(body), body).values, pose);
  const pbd::BodyId id = scene_.bodies[body].body;
  if (scene_.world->props(id).type != pbd::BodyType::Kinematic) return;
  // By a velocity, which is sent to the others; a pose target would send zero velocity.
  const pbd::Pose& from = scene_.world->pose(id);
  scene_.world->set_twist(id, {(pose.position - from.position) / dt_,
                               pbd::rotation_between(from.orientation, pose.orientation) / dt_});
}

void Controls::jump(std::size_t body, const pbd::Pose& pose) {
  append(note(Input::Kind::Jump, static_cast<std::uint32_t>(body), body).values, pose);
  const pbd::BodyId id = scene_.bodies[body].body;
  if (scene_.world->props(id).type != pbd::BodyType::Kinematic) return;
  scene_.world->set_pose(id, pose);
  scene_.world->set_twist(id, {});
}

void Controls::signal(std::uint32_t code, double delay) {
  note(Input::Kind::Signal, code, 0).values.push_back(delay);
  if (signals_ != nullptr) signals_->raise({code, now_ + std::llround(1e9 * delay)});
}

void Controls::append_stretches(std::vector<Stretch>& out) const {
  for (const auto& [number, spring] : springs_) {
    const pbd::Vec3 held = scene_.pose(spring.body).to_world(spring.def.attachment_l);
    out.push_back({spring.body, (spring.def.anchor_w - held).norm()});
  }
}

void Controls::hold_again() {
  for (auto& [number, spring] : springs_) spring.id = peer_.grab(spring.def);
}

bool Controls::holds(std::size_t body) const {
  return std::any_of(springs_.begin(), springs_.end(),
                     [body](const auto& entry) { return entry.second.body == body; });
}

bool Controls::holds(std::size_t body, const pbd::Vec3& attachment_l) const {
  return std::any_of(springs_.begin(), springs_.end(), [&](const auto& entry) {
    return entry.second.body == body && entry.second.def.attachment_l == attachment_l;
  });
}

}  // namespace tandem::demos
