// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "peer/room_peer.h"

#include <algorithm>
#include <cstring>
#include <nlohmann/json.hpp>
#include <span>
#include <utility>

namespace tandem::room {

namespace {

using nlohmann::json;

constexpr consensus::SessionTime kStep = 16'666'667;  // ns
constexpr double kDt = 1.0 / 60.0;                    // s
constexpr int kMostSteps = 8;                         // at once
constexpr consensus::SessionTime kTooLate = 250'000'000;
constexpr consensus::SessionTime kDigestEvery = 500'000'000;
constexpr consensus::SessionTime kTellEvery = 1'000'000'000;
constexpr int kHandEvery = 3;    // steps
constexpr int kHaveEvery = 120;  // steps

// The hand's limits are those of the live view (docs/view.md).
constexpr double kFastest = 2.0;      // m/s
constexpr double kReach = 0.1;        // m
constexpr double kForcePerKg = 40.0;  // N/kg: four times the weight
constexpr double kFullAt = 0.04;      // m, stretch at maximum force
constexpr double kDampingRatio = 0.7;

std::span<const std::uint8_t> bytes_of(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

Vec3 shortened(const Vec3& way, double most) {
  const double length = way.norm();
  return length > most ? Vec3(most / length * way) : way;
}

void append_float(Bytes& out, double value) {
  const auto rounded = static_cast<float>(value);
  std::uint32_t bits = 0;
  std::memcpy(&bits, &rounded, sizeof bits);
  for (std::size_t i = 0; i < 4; ++i) out.push_back(static_cast<std::uint8_t>(bits >> (8 * i)));
}

consensus::PeerOptions peer_options() {
  consensus::PeerOptions options;
  options.sending.format = consensus::StateFormat::Compact;
  options.replay.budget = 1.5;  // as in pages
  return options;
}

}  // namespace

RoomPeer::RoomPeer(const Address& address, MemberId self, std::string_view scene,
                   std::string profile)
    : scene_(scene),
      transport_(address, self, std::move(profile)),
      peer_(scene_.scene().world(), transport_, peer_options()) {
  for (const RoomScene::Body& body : scene_.bodies()) share(body);
}

RoomPeer::~RoomPeer() {
  if (time_ > 0) peer_.leave(time_);
}

void RoomPeer::share(const RoomScene::Body& body) {
  if (body.mass > 0.0)
    peer_.share({.id = consensus::SharedId::from_name(body.name), .body = body.body, .owner = {}});
}

int RoomPeer::advance() {
  transport_.poll();
  hear();
  const auto now = transport_.now();
  if (!now) return 0;
  // Late steps are skipped: others' updates contain their results.
  if (time_ == 0 || *now - time_ > kTooLate) time_ = *now - *now % kStep;
  int steps = 0;
  while (time_ + kStep <= *now && steps < kMostSteps) {
    step();
    ++steps;
  }
  return steps;
}

void RoomPeer::step() {
  move_hand();
  peer_.before_step(time_);
  scene_.scene().step(kDt);
  time_ += kStep;
  peer_.after_step(time_);
  if (time_ - told_ >= kDigestEvery) send_digest();
  if (time_ / kStep % kHaveEvery == 0) say_have();
  if (hand_ && --until_hand_ <= 0) send_hand();
}

bool RoomPeer::pull(std::string_view name, const Vec3& to) {
  const RoomScene::Body* const body = scene_.find(name);
  if (body == nullptr || !(body->mass > 0.0)) return false;
  if (hand_ && hand_->body != name) release();
  if (!hand_)
    hand_ = Hand{std::string(name), scene_.scene().world().pose(body->body).position, to, {}};
  hand_->wanted = to;
  return true;
}

void RoomPeer::release() {
  if (!hand_) return;
  if (hand_->spring.spring != 0) peer_.release(hand_->spring);
  hand_.reset();
  send_all(Channel::Hand, {});
}

void RoomPeer::move_hand() {
  if (!hand_) return;
  const RoomScene::Body& body = *scene_.find(hand_->body);
  const Vec3 held = scene_.scene().world().pose(body.body).position;
  hand_->anchor += shortened(hand_->wanted - hand_->anchor, kFastest * kDt);
  hand_->anchor = held + shortened(hand_->anchor - held, kReach);
  if (hand_->spring.spring != 0) return peer_.move(hand_->spring, hand_->anchor, time_);
  const double force = kForcePerKg * body.mass;
  const double stiffness = force / kFullAt;
  hand_->spring = peer_.grab({.body = consensus::SharedId::from_name(body.name),
                              .anchor_w = hand_->anchor,
                              .stiffness = stiffness,
                              .damping = 2.0 * kDampingRatio * std::sqrt(stiffness * body.mass),
                              .max_force = force});
}

void RoomPeer::hear() {
  heard_.clear();
  newcomers_.clear();
  transport_.take_newcomers(newcomers_);
  for (const MemberId id : newcomers_) say_made(id);
  transport_.take(heard_);
  for (const RoomTransport::Heard& heard : heard_) {
    if (heard.channel != Channel::Words) continue;
    hear_words(heard.from, {reinterpret_cast<const char*>(heard.bytes.data()), heard.bytes.size()});
  }
}

/// Untrusted, like all input from members.
void RoomPeer::hear_words(MemberId from, std::string_view text) {
  const json words = json::parse(text, nullptr, false);
  if (!words.is_object()) return;
  if (const auto away = words.find("away"); away != words.end() && away->is_boolean()) {
    transport_.set_away(from, away->get<bool>());
  }
  // Messages may be lost while connections change: a member with fewer bodies is sent all.
  if (const auto have = words.find("have"); have != words.end() && have->is_number()) {
    const bool less = have->get<double>() < static_cast<double>(made_.size());
    // Limits repetitions for one member.
    if (less && time_ - told_made_[from] > kTellEvery) say_made(from);
  }
  if (const auto made = words.find("made"); made != words.end() && made->is_array()) {
    for (const json& one : *made) {
      const std::string body = one.dump();
      const RoomScene::Body* const added = scene_.make(body);
      if (added == nullptr) continue;
      share(*added);
      made_.push_back(body);
    }
  }
}

/// Sends all bodies made by members, in messages of limited length.
void RoomPeer::say_made(MemberId to) {
  constexpr std::size_t kEach = 64;
  told_made_[to] = time_;
  for (std::size_t first = 0; first < made_.size(); first += kEach) {
    std::string text = "{\"made\":[";
    for (std::size_t i = first; i < std::min(first + kEach, made_.size()); ++i) {
      if (i > first) text += ',';
      text += made_[i];
    }
    text += "]}";
    transport_.send(to, Channel::Words, bytes_of(text));
  }
}

/// Session time, ns, then the upper half of the id and the position of each body.
void RoomPeer::send_digest() {
  told_ = time_;
  Bytes out;
  append_u64(out, static_cast<std::uint64_t>(time_));
  for (const RoomScene::Body& body : scene_.bodies()) {
    if (!(body.mass > 0.0)) continue;
    append_u64(out, consensus::SharedId::from_name(body.name).high);
    const Vec3 at = scene_.scene().world().pose(body.body).position;
    for (int i = 0; i < 3; ++i) append_float(out, at[i]);
  }
  send_all(Channel::Digest, out);
}

void RoomPeer::say_have() {
  const std::string text = "{\"have\":" + std::to_string(made_.size()) + "}";
  const std::span<const std::uint8_t> bytes = bytes_of(text);
  send_all(Channel::Words, Bytes(bytes.begin(), bytes.end()));
}

void RoomPeer::send_hand() {
  until_hand_ = kHandEvery;
  Bytes out;
  for (int i = 0; i < 3; ++i) append_float(out, hand_->anchor[i]);
  for (int i = 0; i < 3; ++i) append_float(out, 0.0);  // attachment at the centre
  out.insert(out.end(), hand_->body.begin(), hand_->body.end());
  send_all(Channel::Hand, out);
}

void RoomPeer::send_all(Channel channel, const Bytes& bytes) {
  for (const consensus::PeerStatus& other : transport_.peers()) {
    if (other.connected) transport_.send(other.id, channel, bytes);
  }
}

}  // namespace tandem::room
