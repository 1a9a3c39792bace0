// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "scenes/recorded_hand.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace tandem::demos {

namespace {

std::vector<std::size_t> held_bodies(const HandRecord& record, const Scene& scene,
                                     const std::vector<std::size_t>& holdable, std::size_t user,
                                     std::size_t users) {
  std::vector<std::string> names;  // distinct names in order of appearance
  std::vector<std::size_t> result;
  for (const HandRecord::Hold& hold : record.holds) {
    const auto same = std::find_if(holdable.begin(), holdable.end(), [&](std::size_t body) {
      return scene.bodies[body].name == hold.body;
    });
    if (same != holdable.end()) {
      result.push_back(*same);
      continue;
    }
    auto name = std::find(names.begin(), names.end(), hold.body);
    if (name == names.end()) name = names.insert(name, hold.body);
    const auto n = static_cast<std::size_t>(name - names.begin());
    result.push_back(holdable[(n * users + user) % holdable.size()]);
  }
  return result;
}

}  // namespace

RecordedHand::RecordedHand(std::size_t user, const Scenario& scenario, Controls& controls,
                           HandRecord record)
    : controls_(controls), record_(std::move(record)), scale_(scenario.hand_scale()) {
  const std::vector<std::size_t> holdable = scenario.holdable(controls.scene());
  if (holdable.empty()) {
    pbd::detail::refuse(scenario.name() + ": bodies that recorded hands may hold", "at least one",
                        "0");
  }
  bodies_ = held_bodies(record_, controls.scene(), holdable, user, scenario.user_count());
}

void RecordedHand::update(consensus::SessionTime /*now*/) {
  const double time = controls_.time();
  while (next_ < record_.holds.size() && time >= record_.holds[next_].start()) {
    const HandRecord::Hold& hold = record_.holds[next_];
    const bool late = !closed_ && time > hold.start() + kPatience;
    if (time < hold.end && !late) {
      if (!closed_) close(bodies_[next_], hold);
      follow(hold, time);
      return;
    }
    open();
    ++next_;
  }
}

void RecordedHand::close(std::size_t body, const HandRecord::Hold& hold) {
  const Scene& scene = controls_.scene();
  const pbd::Vec3& half = scene.bodies[body].half_extents;
  attachment_l_ = hold.attachment_l.cwiseMax(-half).cwiseMin(half);
  grabbed_w_ = scene.pose(body).to_world(attachment_l_);
  hand_ = PointerHand(grabbed_w_);
  closed_ = true;
}

void RecordedHand::follow(const HandRecord::Hold& hold, double time) {
  const std::size_t body = bodies_[next_];
  const pbd::Vec3 moved = hold.wanted(time) - hold.way.front().wanted;
  pbd::Vec3 wanted = grabbed_w_ + moved.cwiseProduct(scale_);
  wanted.z() = std::max(wanted.z(), std::min(kLowest, grabbed_w_.z()));
  const pbd::Vec3 held = controls_.scene().pose(body).to_world(attachment_l_);
  hand_.follow(wanted, held, controls_.dt());
  if (spring_) {
    controls_.move(*spring_, hand_.anchor());
    return;
  }
  const double mass = controls_.scene().mass(body);
  consensus::GrabDef def;
  def.attachment_l = attachment_l_;
  def.anchor_w = hand_.anchor();
  def.max_force = kStrength * mass;
  def.stiffness = def.max_force / kFullAt;
  def.damping = 2.0 * kDampingRatio * std::sqrt(def.stiffness * mass);
  spring_ = controls_.grab(body, def);
}

void RecordedHand::open() {
  if (!closed_) return;
  controls_.release(*spring_);
  spring_.reset();
  closed_ = false;
  ++done_;
}

Outcome RecordedHand::outcome() const { return {{"holds_done", static_cast<double>(done_)}}; }

}  // namespace tandem::demos
