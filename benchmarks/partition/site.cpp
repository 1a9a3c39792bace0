// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "site.h"

#include <string>
#include <utility>

#include "benchmarks/measure/clock.h"
#include "demos/scenes/cliff_geometry.h"
#include "scenes/cliff.h"

namespace tandem::partition_bench {
namespace {

using pbd::Vec3;

/// Stacks of five, 0.1 m cubes, 0.3 m from middle to middle, on a square.
demos::Scene field_of_stacks(int stacks) {
  constexpr double kEdge = 0.1;
  constexpr double kSpacing = 0.3;
  constexpr int kHeight = 5;
  demos::SceneBuilder builder;
  int side = 1;
  while (side * side < stacks) ++side;
  const double half = 0.5 * kSpacing * (side - 1);
  for (int s = 0; s < stacks; ++s) {
    const double x = kSpacing * (s % side) - half;
    const double y = kSpacing * (s / side) - half;
    for (int level = 0; level < kHeight; ++level) {
      builder.box("cube/" + std::to_string(s) + "/" + std::to_string(level), Vec3::Constant(kEdge),
                  0.3, Vec3(x, y, kEdge * (level + 0.5)));
    }
  }
  demos::BodySpec ball;
  ball.name = "ball";
  ball.parts.push_back({collision::Sphere{0.2}, {}});
  ball.mass = 10.0;
  ball.pose.position = Vec3(-half - 1.0, 0.0, 0.2);
  builder.add(std::move(ball));
  demos::Scene scene = builder.build({}, 0.5);
  pbd::Twist twist;
  twist.linear = Vec3(6.0, 0.5, 0.0);
  scene.world->set_twist(scene.body("ball").body, twist);
  return scene;
}

demos::Scene cliff(int balls) {
  demos::Scene scene = demos::CliffScenario(balls).build({});
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) demos::let_fall(scene, i, 0.0);
  return scene;
}

}  // namespace

demos::Scene build_scene(Which which, int size) {
  return which == Which::Cliff ? cliff(size) : field_of_stacks(size);
}

Site::Site(demos::Scene scene, consensus::Transport& transport,
           const std::vector<PartitionCell>& cells, const PartitionOptions& options)
    : scene_(std::move(scene)), self_(transport.self()) {
  colliders_.resize(scene_.bodies.size());
  std::vector<std::size_t> by_slot(scene_.world->slot_count(), scene_.bodies.size());
  for (std::size_t i = 0; i < scene_.bodies.size(); ++i) {
    const demos::SceneBody& body = scene_.bodies[i];
    by_slot[body.body.index] = i;
    const pbd::BodyProps& props = scene_.world->props(body.body);
    Plan plan{.index = i, .def = {}, .colliders = {}};
    plan.def.mass = props.mass;
    plan.def.inertia = props.inertia_l;
    plans_.emplace(body.id, std::move(plan));
  }
  for (std::uint32_t c = 0; c < scene_.contacts->slot_count(); ++c) {
    const collision::ColliderId id = scene_.contacts->collider_at(c);
    if (!id.valid()) continue;
    const collision::ColliderDef& def = scene_.contacts->collider(id);
    const std::size_t body = by_slot[def.body.index];
    if (body >= scene_.bodies.size()) continue;
    colliders_[body].push_back(id);
    plans_.at(scene_.bodies[body].id).colliders.push_back(def);
  }
  if (cells.empty()) return;
  peer_ = std::make_unique<consensus::Peer>(*scene_.world, transport,
                                            consensus::PeerOptions{.authority_ramp = 0.0});
  PartitionBodies& bodies = *this;
  partition_ = std::make_unique<Partition>(*scene_.world, *peer_, bodies, self_, cells, options);
  for (const demos::SceneBody& body : scene_.bodies) partition_->add(body.id, body.body);
}

double Site::step(consensus::SessionTime from, consensus::SessionTime to) {
  const double begin = bench::thread_seconds();
  if (peer_ != nullptr) peer_->before_step(from);
  solver_.step(*scene_.world, 1e-9 * static_cast<double>(to - from));
  if (peer_ != nullptr) {
    partition_->update(to);
    peer_->after_step(to);
  }
  return bench::thread_seconds() - begin;
}

bool Site::decides(std::size_t body) const {
  return partition_ == nullptr || partition_->peer_at(pose(body).position) == self_;
}

std::vector<pbd::Vec3> Site::decided() const {
  std::vector<pbd::Vec3> places;
  for (std::size_t i = 0; i < scene_.bodies.size(); ++i) {
    if (has(i) && decides(i)) places.push_back(pose(i).position);
  }
  return places;
}

PartitionStats Site::members() const {
  return partition_ != nullptr ? partition_->stats() : PartitionStats{};
}

pbd::BodyId Site::appear(const consensus::SharedId& id, const pbd::Pose& pose,
                         const pbd::Twist& twist) {
  const auto found = plans_.find(id);
  if (found == plans_.end()) return {};
  const Plan& plan = found->second;
  pbd::BodyDef def = plan.def;
  def.pose = pose;
  def.twist = twist;
  demos::SceneBody& body = scene_.bodies[plan.index];
  body.body = scene_.world->add_body(def);
  for (collision::ColliderDef collider : plan.colliders) {
    collider.body = body.body;
    colliders_[plan.index].push_back(scene_.contacts->add(*scene_.world, collider));
  }
  return body.body;
}

void Site::vanish(const consensus::SharedId& id, pbd::BodyId body) {
  auto& colliders = colliders_[plans_.at(id).index];
  for (const collision::ColliderId collider : colliders) scene_.contacts->remove(collider);
  colliders.clear();
  scene_.world->remove_body(body);
}

}  // namespace tandem::partition_bench
