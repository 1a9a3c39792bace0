// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "view/mouse.h"

#include <algorithm>

namespace tandem::demos::view {

pbd::Vec3 held_at(const Scene& scene, std::size_t body, const pbd::Vec3& point) {
  const pbd::Vec3& half = scene.bodies[body].half_extents;
  return scene.pose(body).to_local(point).cwiseMax(-half).cwiseMin(half);
}

Mouse::Grip* Mouse::find(PageId page, std::uint32_t id) {
  const auto found = std::find_if(grips_.begin(), grips_.end(), [&](const Grip& grip) {
    return grip.page == page && grip.id == id && !grip.released;
  });
  return found == grips_.end() ? nullptr : &*found;
}

void Mouse::grab(PageId page, std::uint32_t id, std::size_t body, const pbd::Vec3& attachment_l) {
  Grip grip;
  grip.page = page;
  grip.id = id;
  grip.body = body;
  grip.attachment_l = attachment_l;
  grip.wanted_w = controls_.scene().pose(body).to_world(attachment_l);
  grip.hand = PointerHand(grip.wanted_w);
  grips_.push_back(grip);
}

void Mouse::move(PageId page, std::uint32_t id, const pbd::Vec3& point) {
  if (Grip* const grip = find(page, id)) grip->wanted_w = point;
}

void Mouse::release(PageId page, std::uint32_t id) {
  if (Grip* const grip = find(page, id)) grip->released = true;
}

void Mouse::leave(PageId page) {
  for (Grip& grip : grips_) grip.released = grip.released || grip.page == page;
}

void Mouse::update(consensus::SessionTime /*now*/) {
  for (Grip& grip : grips_) {
    if (grip.released) {
      if (grip.spring != 0) controls_.release(grip.spring);
      continue;
    }
    const pbd::Vec3 held_w = controls_.scene().pose(grip.body).to_world(grip.attachment_l);
    grip.hand.follow(grip.wanted_w, held_w, controls_.dt());
    if (grip.spring != 0) {
      controls_.move(grip.spring, grip.hand.anchor());
      continue;
    }
    consensus::GrabDef def = single_spring(controls_.scene().mass(grip.body));
    def.attachment_l = grip.attachment_l;
    def.anchor_w = grip.hand.anchor();
    grip.spring = controls_.grab(grip.body, def);
  }
  std::erase_if(grips_, [](const Grip& grip) { return grip.released; });
}

}  // namespace tandem::demos::view
