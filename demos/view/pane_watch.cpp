// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "view/pane_watch.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "tandem/pbd/contact.h"

namespace tandem::demos::view {

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t kMaxPeers = 64;       // peers whose shares are kept
constexpr std::size_t kMaxContacts = 1024;  // more than visible
constexpr double kAgeMemory = 0.9;          // weight of the old mean age per step

}  // namespace

PaneWatch::PaneWatch(const Scene& scene) {
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) index_.emplace_back(scene.bodies[i].id, i);
  std::sort(index_.begin(), index_.end());
}

std::size_t PaneWatch::index_of(const consensus::SharedId& id) const {
  const auto found =
      std::lower_bound(index_.begin(), index_.end(), id,
                       [](const auto& entry, const auto& key) { return entry.first < key; });
  return found == index_.end() || found->first != id ? SIZE_MAX : found->second;
}

void PaneWatch::turn(consensus::SessionTime now) {
  if (now == now_) return;
  now_ = now;
  targets_.clear();
  distances_.clear();
  if (age_count_ > 0.0) {
    const double mean = age_sum_ / age_count_;
    mean_age_ = heard_ ? kAgeMemory * mean_age_ + (1.0 - kAgeMemory) * mean : mean;
    heard_ = true;
  }
  age_sum_ = age_count_ = 0.0;
}

void PaneWatch::on_estimate(const consensus::EstimateEvent& event) {
  turn(event.context.now);
  const std::size_t index = index_of(event.update.id);
  if (index == SIZE_MAX) return;
  targets_.push_back({event.from, index, event.position});
  age_sum_ += event.age;
  age_count_ += 1.0;
  const auto known = shares_.find(event.from);
  if (known == shares_.end() && shares_.size() >= kMaxPeers) return;
  std::vector<float>& shares = known == shares_.end() ? shares_[event.from] : known->second;
  shares.resize(index_.size(), 0.0F);
  shares[index] = static_cast<float>(event.update.influence);
  const pbd::Vec3 own = event.own.at_time(event.update.stamp).pose.position;
  distances_.push_back((event.update.pose.position - own).norm());
}

double PaneWatch::mean_age() const { return heard_ ? mean_age_ : kNaN; }

double PaneWatch::share(consensus::PeerId peer, std::size_t body) const {
  const auto found = shares_.find(peer);
  return found == shares_.end() ? 0.0 : static_cast<double>(found->second[body]);
}

void PaneWatch::forget() {
  shares_.clear();
  targets_.clear();
  distances_.clear();
  age_sum_ = age_count_ = 0.0;
  heard_ = false;
}

void append_contacts(const pbd::World& world, const BodiesBySlot& shown,
                     std::span<const pbd::Pose> poses, std::vector<ContactMark>& out) {
  if (world.contacts() == nullptr) return;
  const auto pose_of = [&](const pbd::BodyId& id) {
    const std::uint32_t index = shown.index_of(id);
    return index == pbd::BodyId::kNone ? world.pose(id) : poses[index];
  };
  for (const pbd::Contact& contact : world.contacts()->contacts()) {
    const pbd::Manifold& manifold = contact.manifold;
    const pbd::BodyId a = world.body_at(manifold.body_a);
    const pbd::BodyId b = world.body_at(manifold.body_b);
    if (!a.valid() || !b.valid() || !contact.loaded()) continue;
    const std::uint32_t first = shown.index_of(a);
    const std::uint32_t body = first == pbd::BodyId::kNone ? shown.index_of(b) : first;
    const pbd::Pose pose_a = pose_of(a), pose_b = pose_of(b);
    for (int i = 0; i < manifold.count; ++i) {
      if (out.size() >= kMaxContacts) return;
      const auto k = static_cast<std::size_t>(i);
      if (!(contact.force[k] > 0.0)) continue;
      const pbd::Vec3 at_a = pose_a.to_world(manifold.points[k].anchor_a_l);
      const pbd::Vec3 at_b = pose_b.to_world(manifold.points[k].anchor_b_l);
      const double gap = manifold.normal.dot(at_b - at_a) - manifold.radius_a - manifold.radius_b;
      out.push_back({static_cast<std::uint16_t>(body), at_a + manifold.radius_a * manifold.normal,
                     manifold.normal, -gap});
    }
  }
}

void append_springs(const Scene& scene, std::span<const pbd::Pose> poses,
                    std::span<const pbd::Tether::Def> springs, std::uint8_t own,
                    const std::function<std::uint8_t(std::size_t, const pbd::Vec3&)>& holder,
                    std::vector<SpringMark>& out) {
  for (const pbd::Tether::Def& spring : springs) {
    const auto found =
        std::find_if(scene.bodies.begin(), scene.bodies.end(),
                     [&spring](const SceneBody& each) { return each.body == spring.body; });
    const auto body = static_cast<std::size_t>(found - scene.bodies.begin());
    SpringMark mark;
    mark.body = static_cast<std::uint16_t>(body);
    mark.anchor = spring.anchor_w;
    mark.attachment = poses[body].to_world(spring.anchor_l);
    mark.pane = holder(body, spring.anchor_l);
    mark.own = mark.pane == own;
    out.push_back(mark);
  }
}

void put_divergence(std::vector<double>& lengths_m, PaneFrame& out) {
  out.divergence_p50_mm = out.divergence_max_mm = kNaN;
  if (lengths_m.empty()) return;
  const auto middle = lengths_m.begin() + static_cast<std::ptrdiff_t>(lengths_m.size() / 2);
  std::nth_element(lengths_m.begin(), middle, lengths_m.end());
  out.divergence_p50_mm = 1e3 * *middle;
  out.divergence_max_mm = 1e3 * *std::max_element(lengths_m.begin(), lengths_m.end());
}

}  // namespace tandem::demos::view
