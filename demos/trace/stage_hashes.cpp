// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "trace/stage_hashes.h"

#include <algorithm>
#include <bit>

#include "tandem/pbd/bytes.h"

namespace tandem::demos {

namespace {

/// A word at a time, since worlds of a thousand bodies are hashed twice per step. Each operation is
/// a bijection of hash and word, so that a single differing bit is never lost.
void mix(std::uint64_t& hash, std::uint64_t word) {
  hash = (hash ^ word) * 0x9e3779b97f4a7c15ull;
  hash ^= hash >> 29;
}
void mix(std::uint64_t& hash, double value) { mix(hash, std::bit_cast<std::uint64_t>(value)); }
void mix(std::uint64_t& hash, const pbd::Vec3& v) {
  for (int i = 0; i < 3; ++i) mix(hash, v[i]);
}
void mix(std::uint64_t& hash, const pbd::Quat& q) {
  for (int i = 0; i < 4; ++i) mix(hash, q.coeffs()[i]);
}
void mix(std::uint64_t& hash, const pbd::Pose& pose) {
  mix(hash, pose.position);
  mix(hash, pose.orientation);
}
void mix(std::uint64_t& hash, const pbd::Twist& twist) {
  mix(hash, twist.linear);
  mix(hash, twist.angular);
}
void mix(std::uint64_t& hash, const pbd::Tether::Def& spring) {
  mix(hash, spring.anchor_l);
  mix(hash, spring.anchor_w);
  mix(hash, spring.anchor_velocity);
  mix(hash, spring.stiffness);
  mix(hash, spring.damping);
  mix(hash, spring.max_force);
}
void mix(std::uint64_t& hash, const pbd::PoseTarget& target) {
  mix(hash, target.pose);
  mix(hash, target.twist);
  mix(hash, target.share);
  mix(hash, static_cast<std::uint64_t>(target.motion));
  mix(hash, target.rotation_error);
  mix(hash, std::uint64_t{target.use_rotation_error ? 1u : 0u});
}

}  // namespace

void StageHashes::attach(Scene& scene, consensus::Peer& peer) {
  scene_ = &scene;
  peer_ = &peer;
  inner_ = scene.world->target_source();
  if (inner_ != nullptr) scene.world->set_target_source(this);
  bodies_ = BodiesBySlot(scene);
  hashes_.resize(scene.bodies.size() + 1);
  targets_.bodies.resize(scene.bodies.size());
  poses_.bodies.resize(scene.bodies.size());
}

std::uint64_t& StageHashes::of(const pbd::BodyId& body) {
  const std::uint32_t index = bodies_.index_of(body);
  return index < hashes_.size() ? hashes_[index] : hashes_.back();
}

void StageHashes::start() {
  std::fill(hashes_.begin(), hashes_.end(), 0);
  for (std::size_t i = 0; i < scene_->bodies.size(); ++i) {
    const pbd::BodyState& state = scene_->world->state(scene_->bodies[i].body);
    mix(hashes_[i], state.pose);
    mix(hashes_[i], state.twist);
  }
}

void StageHashes::fold(StageHash& result) {
  result.all = 0;
  for (std::size_t i = 0; i < result.bodies.size(); ++i) {
    result.bodies[i] = static_cast<std::uint32_t>(hashes_[i] ^ hashes_[i] >> 32);
  }
  for (const std::uint64_t each : hashes_) mix(result.all, each);
}

void StageHashes::told() {
  start();
  springs_.clear();
  peer_->springs(springs_);
  for (const pbd::Tether::Def& spring : springs_) mix(of(spring.body), spring);
}

void StageHashes::collect(const pbd::World& world, double dt, const pbd::SolverOptions& options,
                          std::vector<pbd::PoseTarget>& out) {
  const std::size_t first = out.size();
  inner_->collect(world, dt, options, out);
  for (std::size_t i = first; i < out.size(); ++i) mix(of(out[i].body), out[i]);
}

void StageHashes::solved() {
  fold(targets_);
  start();
  fold(poses_);
}

void SentHash::post(consensus::PeerId to, std::span<const std::byte> bytes,
                    consensus::Delivery delivery) {
  mix(hash_, to);
  mix(hash_, static_cast<std::uint64_t>(delivery));
  mix(hash_, pbd::hash_bytes(bytes));
}

void SentHash::drop(consensus::PeerId peer) { mix(hash_, ~peer); }

std::uint64_t SentHash::take() {
  const std::uint64_t result = hash_;
  hash_ = 0;
  return result;
}

}  // namespace tandem::demos
