// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "rollback/view.h"

#include <cmath>

#include "session/geometry.h"
#include "session/participant.h"

namespace tandem::rollback_bench {

View::View(const demos::Scenario& scenario, const demos::DemoOptions& options, std::size_t number,
           double smoothing)
    : scenario_(scenario),
      bounds_(scenario.bounds()),
      smoothing_(smoothing),
      scene_(scenario.build({})),
      peer_(*scene_.world, nobody_.transport(1)),
      offsets_(scene_.bodies.size()),
      referee_(scenario.make_referee(scene_)) {
  record_.id = number + 1;
  record_.step_hz = kFrameHz;
  record_.epoch = frame_time(0);
  record_.tracks.resize(scene_.bodies.size());
  for (const demos::SceneBody& body : scene_.bodies) {
    peer_.share({.id = body.id, .body = body.body});
    record_.owners.push_back(body.owner ? demos::seat_of(options, *body.owner) + 1 : 0);
  }
  for (std::size_t user = 0; user < scenario.user_count(); ++user) {
    if (demos::seat_of(options, user) != number) continue;
    Seat& seat = seats_.emplace_back();
    seat.controls = std::make_unique<demos::Controls>(user, scene_, peer_, frame_time(0));
    seat.controls->keep_no_log();
    seat.user =
        scenario.make_user(user, *seat.controls, demos::user_options(options, user, frame_time(0)));
  }
}

int View::holding(std::size_t body) const {
  int count = 0;
  for (const Seat& seat : seats_) count += seat.controls->holds(body) ? 1 : 0;
  return count;
}

void View::before_correction(const demos::Scene& world) {
  if (smoothing_ <= 0.0) return;
  before_.clear();
  for (std::size_t i = 0; i < offsets_.size(); ++i) before_.push_back(world.pose(i));
}

void View::after_correction(const demos::Scene& world) {
  if (smoothing_ <= 0.0) return;
  constexpr double kFar = 1.0;  // m: larger corrections are shown at once
  for (std::size_t i = 0; i < before_.size(); ++i) {
    const pbd::Pose& before = before_[i];
    const pbd::Pose& after = world.pose(i);
    pbd::Pose& offset = offsets_[i];
    offset.position += before.position - after.position;
    offset.orientation = offset.orientation * before.orientation * after.orientation.conjugate();
    if (offset.position.norm() > kFar) offset = {};
  }
}

void View::smooth() {
  if (smoothing_ <= 0.0) return;
  const double kept = std::exp(-1.0 / (kFrameHz * smoothing_));
  for (pbd::Pose& offset : offsets_) {
    offset.position *= kept;
    offset.orientation = pbd::Quat::Identity().slerp(kept, offset.orientation);
  }
}

pbd::BodyState View::shown(const demos::Scene& world, std::size_t body) const {
  pbd::BodyState state = world.world->state(world.bodies[body].body);
  if (smoothing_ <= 0.0) return state;
  state.pose.position += offsets_[body].position;
  state.pose.orientation = (offsets_[body].orientation * state.pose.orientation).normalized();
  return state;
}

Inputs View::inputs(const demos::Scene& world, consensus::SessionTime now, double dt) {
  for (std::size_t i = 0; i < offsets_.size(); ++i) {
    const pbd::BodyState state = shown(world, i);
    scene_.world->set_pose(scene_.bodies[i].body, state.pose);
    scene_.world->set_twist(scene_.bodies[i].body, state.twist);
  }
  Inputs result;
  std::vector<demos::Controls::Stretch> springs;
  for (Seat& seat : seats_) {
    seat.controls->begin(now, dt);
    seat.user->update(now);
    const std::vector<demos::Input>& log = seat.controls->log();
    result.insert(result.end(), log.begin(), log.end());
    seat.controls->append_stretches(springs);
  }
  for (const demos::Controls::Stretch& spring : springs) {
    const auto body = static_cast<std::uint32_t>(spring.body);
    record_.stretches.push_back({now, body, holding(spring.body), spring.distance});
  }
  return result;
}

void View::keep(const demos::Scene& world, consensus::SessionTime end) {
  for (std::size_t i = 0; i < offsets_.size(); ++i) {
    const pbd::BodyState state = shown(world, i);
    demos::TrackSample sample;
    sample.time = end;
    sample.position = state.pose.position;
    sample.orientation = state.pose.orientation;
    sample.velocity = state.twist.linear;
    sample.speed = state.twist.linear.norm();
    sample.contact = world.world->in_contact(world.bodies[i].body);
    sample.users = holding(i);
    record_.tracks[i].push(sample);
  }
  record_.seconds += 1.0 / kFrameHz;
  const double at = 1e-9 * static_cast<double>(end - frame_time(0));
  record_.note_fault(at, demos::out_of_bounds(world, bounds_));
  if (frames_++ % demos::kLookEvery == 0) record_.note_fault(at, scenario_.fault(world));
  if (!referee_) return;
  referee_->watch(world, at);
  record_.outcome = referee_->outcome(world);
}

}  // namespace tandem::rollback_bench
