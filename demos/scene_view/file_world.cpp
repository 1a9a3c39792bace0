// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "scene_view/file_world.h"

#include <algorithm>
#include <chrono>
#include <limits>
#include <map>
#include <string>
#include <utility>
#include <variant>

#include "scene_view/extent.h"
#include "scenes/user.h"
#include "view/pane_watch.h"

namespace tandem::demos {

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

pbd::Pose placed(const pbd::Pose& body, const pbd::Pose& local) {
  return {body.to_world(local.position), body.orientation * local.orientation};
}

/// All colliders that are shown, as (body, definition), in the order of their slots.
template <class Visit>
void each_collider(const tandem::Scene& scene, const Visit& visit) {
  const collision::CollisionScene& shapes = scene.shapes();
  for (std::uint32_t slot = 0; slot < shapes.slot_count(); ++slot) {
    const collision::ColliderId id = shapes.collider_at(slot);
    if (!shapes.contains(id)) continue;
    const collision::ColliderDef& def = shapes.collider(id);
    if (!def.sensor) visit(def);
  }
}

}  // namespace

FileWorld::FileWorld(SceneFile file, bool ground) : file_(std::move(file)) {
  if (ground) add_ground();
  springs_ = &file_.scene.world().add_block<pbd::Tethers>();
  describe();
  start_ = file_.scene.world().snapshot();
}

void FileWorld::add_ground() {
  double lowest = std::numeric_limits<double>::infinity();
  bool is_there = false;
  each_collider(file_.scene, [&](const collision::ColliderDef& def) {
    is_there = is_there || std::holds_alternative<collision::HalfSpace>(def.shape);
    const pbd::Pose pose = placed(file_.scene.world().pose(def.body), def.local);
    lowest = std::min(lowest, extent(def.shape, pose).min.z());
  });
  if (is_there || lowest == std::numeric_limits<double>::infinity()) return;
  file_.scene.add(HalfSpace{},
                  {.type = BodyType::Static, .pose = {.position = {0.0, 0.0, lowest}}});
}

void FileWorld::describe() {
  const pbd::World& world = file_.scene.world();
  std::map<std::uint32_t, SceneBody> moving;  // by slot
  each_collider(file_.scene, [&](const collision::ColliderDef& def) {
    const pbd::Pose pose = world.pose(def.body);
    const collision::Aabb box = extent(def.shape, placed(pose, def.local));
    if (world.props(def.body).type == BodyType::Static) {
      description_.fixed.push_back({def.shape, placed(pose, def.local)});
      return;
    }
    if (!is_empty(box)) {
      reach_ = std::max({reach_, box.min.cwiseAbs().maxCoeff(), box.max.cwiseAbs().maxCoeff()});
    }
    SceneBody& body = moving[def.body.index];
    body.body = def.body;
    body.parts.push_back({def.shape, def.local});
    const collision::Aabb own = extent(def.shape, def.local);
    if (is_empty(own)) return;
    body.half_extents = body.half_extents.cwiseMax(own.min.cwiseAbs()).cwiseMax(own.max.cwiseAbs());
  });
  for (const SceneFile::Body& named : file_.bodies) {
    const auto found = moving.find(named.body.index);
    if (found != moving.end() && found->second.name.empty()) found->second.name = named.name;
  }
  for (auto& [slot, body] : moving) {
    if (body.name.empty()) body.name = "body " + std::to_string(slot);
    description_.bodies.push_back(std::move(body));
  }
  shown_ = BodiesBySlot(world, description_.bodies);
}

void FileWorld::step(double dt) {
  pbd::World& world = file_.scene.world();
  for (Grip& grip : grips_) {
    pbd::Tether::Def def = springs_->def(grip.spring);
    grip.hand.follow(grip.wanted_w, world.pose(def.body).to_world(def.anchor_l), dt);
    def.anchor_velocity = (grip.hand.anchor() - def.anchor_w) / dt;
    springs_->set(world, grip.spring, def);
    world.wake(def.body);
  }
  const auto begin = std::chrono::steady_clock::now();
  file_.scene.step(dt);
  step_s_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  time_ += dt;
}

void FileWorld::restart() {
  for (const Grip& grip : grips_) springs_->remove(grip.spring);
  grips_.clear();
  file_.scene.world().restore(start_);
  time_ = 0.0;
}

void FileWorld::show(view::PaneFrame& out, bool overlays) const {
  const pbd::World& world = file_.scene.world();
  out.step_ms = 1e3 * step_s_;
  out.latency_ms = out.divergence_p50_mm = out.divergence_max_mm = kNaN;
  out.poses.resize(description_.bodies.size());
  for (std::size_t i = 0; i < out.poses.size(); ++i) {
    out.poses[i] = world.pose(description_.bodies[i].body);
  }
  show_springs(out);
  out.contacts.clear();
  out.targets.clear();
  out.influence.clear();
  if (!overlays) return;
  out.influence.assign(out.poses.size(), 0);
  view::append_contacts(world, shown_, out.poses, out.contacts);
}

void FileWorld::show_springs(view::PaneFrame& out) const {
  out.springs.clear();
  for (const Grip& grip : grips_) {
    const pbd::Tether::Def& def = springs_->def(grip.spring);
    view::SpringMark mark;
    mark.body = static_cast<std::uint16_t>(grip.body);
    mark.anchor = def.anchor_w;
    mark.attachment = out.poses[grip.body].to_world(def.anchor_l);
    mark.pane = 0;
    mark.own = true;
    out.springs.push_back(mark);
  }
}

FileWorld::Grip* FileWorld::find(view::PageId page, std::uint32_t id) {
  const auto found = std::ranges::find_if(
      grips_, [&](const Grip& grip) { return grip.page == page && grip.id == id; });
  return found == grips_.end() ? nullptr : &*found;
}

void FileWorld::grab(view::PageId page, const view::Grab& grab) {
  const pbd::World& world = file_.scene.world();
  const SceneBody& body = description_.bodies[grab.body];
  const pbd::Pose& pose = world.pose(body.body);
  const consensus::GrabDef spring = single_spring(world.props(body.body).mass);
  pbd::Tether::Def def;
  def.body = body.body;
  def.anchor_l = pose.to_local(grab.point).cwiseMax(-body.half_extents).cwiseMin(body.half_extents);
  def.anchor_w = pose.to_world(def.anchor_l);
  def.stiffness = spring.stiffness;
  def.damping = spring.damping;
  def.max_force = spring.max_force;
  Grip grip;
  grip.page = page;
  grip.id = grab.id;
  grip.body = grab.body;
  grip.spring = springs_->add(world, def);
  grip.wanted_w = def.anchor_w;
  grip.hand = PointerHand(def.anchor_w);
  grips_.push_back(grip);
}

void FileWorld::move(view::PageId page, const view::Move& move) {
  if (Grip* const grip = find(page, move.id)) grip->wanted_w = move.point;
}

void FileWorld::release(view::PageId page, std::uint32_t id) {
  Grip* const grip = find(page, id);
  if (grip == nullptr) return;
  springs_->remove(grip->spring);
  grips_.erase(grips_.begin() + (grip - grips_.data()));
}

void FileWorld::leave(view::PageId page) {
  for (const Grip& grip : grips_) {
    if (grip.page == page) springs_->remove(grip.spring);
  }
  std::erase_if(grips_, [page](const Grip& grip) { return grip.page == page; });
}

}  // namespace tandem::demos
