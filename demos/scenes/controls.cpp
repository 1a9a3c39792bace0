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

void Controls::log_spring(Input::Kind kind, std::size_t body, const consensus::GrabDef& def) {
  Input& input = note(kind, next_, body);
  append(input.values, def.attachment_l);
  append(input.values, def.anchor_w);
  input.values.insert(input.values.end(), {def.stiffness, def.damping, def.max_force});
}

std::uint32_t Controls::grab(std::size_t body, const consensus::GrabDef& def) {
  consensus::GrabDef own = def;
  own.body = scene_.bodies[body].id;
  Hold& hold = springs_[next_];
  hold.id = peer_.grab(own);
  hold.body = body;
  log_spring(Input::Kind::Grab, body, def);
  return next_++;
}

pbd::Tethers& Controls::tethers() {
  if (tethers_ == nullptr) tethers_ = &scene_.world->add_block<pbd::Tethers>();
  return *tethers_;
}

std::uint32_t Controls::hold(std::size_t body, const consensus::GrabDef& def) {
  Hold& hold = springs_[next_];
  hold.tether = tethers().add(*scene_.world, {.body = scene_.bodies[body].body,
                                              .anchor_l = def.attachment_l,
                                              .anchor_w = def.anchor_w,
                                              .stiffness = def.stiffness,
                                              .damping = def.damping,
                                              .max_force = def.max_force});
  hold.alone = true;
  hold.body = body;
  hold.moved = now_;
  hold.anchor = def.anchor_w;
  log_spring(Input::Kind::Hold, body, def);
  return next_++;
}

void Controls::move(std::uint32_t spring, const pbd::Vec3& anchor_w) {
  Hold& hold = springs_.at(spring);
  append(note(Input::Kind::Move, spring, hold.body).values, anchor_w);
  if (!hold.alone) {
    peer_.move(hold.id, anchor_w, now_);
    return;
  }
  pbd::Tether::Def def = tethers().def(hold.tether);
  const double dt = 1e-9 * static_cast<double>(now_ - hold.moved);
  // From the last move: the solver has carried its own anchor on since.
  if (dt > 0.0) def.anchor_velocity = (anchor_w - hold.anchor) / dt;
  def.anchor_w = anchor_w;
  hold.moved = now_;
  hold.anchor = anchor_w;
  tethers().set(*scene_.world, hold.tether, def);
}

void Controls::release(std::uint32_t spring) {
  const auto found = springs_.find(spring);
  if (found == springs_.end()) return;
  const Hold& hold = found->second;
  if (hold.alone) {
    tethers().remove(hold.tether);
  } else {
    peer_.release(hold.id);
  }
  note(Input::Kind::Release, spring, hold.body);
  springs_.erase(found);
}

void Controls::drive(std::size_t body, const pbd::Pose& pose) {
  append(note(Input::Kind::Drive, static_cast<std::uint32_t>(body), body).values, pose);
  const pbd::BodyId id = scene_.bodies[body].body;
  if (scene_.world->props(id).type != pbd::BodyType::Kinematic) return;
  // By its velocity, which the others hear, not by a target, after which it would stand still.
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

bool Controls::holds(std::size_t body) const {
  return std::any_of(springs_.begin(), springs_.end(),
                     [body](const auto& entry) { return entry.second.body == body; });
}

}  // namespace tandem::demos
