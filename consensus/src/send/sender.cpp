// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "send/sender.h"

#include <algorithm>
#include <limits>
#include <span>

#include "common/body_state.h"

namespace tandem::consensus {
namespace {

/// s: a body that has been slow and in one place for this long rests. At a third of it damped
/// bodies are declared at rest 4 mm short of their end (tests/consensus/sending_test.cpp).
constexpr double kRestsFor = 0.25;

/// s: interval at which springs are sent in full, for peers that missed their creation, and to
/// newcomers.
constexpr double kSpringsEvery = 2.0;

}  // namespace

Sender::Sender(PeerData& data, Connections& connections, const Activity& activity)
    : data_(data), connections_(connections), activity_(activity) {
  SendOptions sending = data.options.sending;
  if (!sending.selects() && sending.format == StateFormat::Full) return;
  // An owner must be heard before it counts as gone.
  if (data.options.coupling == Coupling::SingleOwner) {
    sending.rest_refresh = std::min(sending.rest_refresh, 0.5 * data.options.influence.max_age);
  }
  outbox_ = std::make_unique<Outbox>(sending, data.transport, data.stats);
}

std::size_t Sender::most_bodies() const {
  return outbox_ != nullptr ? Outbox::kMaxIndices - 1 : std::numeric_limits<std::size_t>::max();
}

void Sender::send() {
  const SessionTime now = data_.now;
  if (now < next_send_) return;
  const auto interval = static_cast<SessionTime>(1.0 / (kNs * data_.options.update_hz));
  next_send_ = std::max(next_send_ + interval, now - interval);
  connections_.refresh();
  states_.clear();
  spring_states_.clear();
  spring_events_.clear();
  data_.springs.announce(now, spring_states_, spring_events_);
  acts_.clear();
  receipts_.clear();
  data_.acts.announce(acts_, receipts_);
  if (outbox_ != nullptr) {
    send_selected();
  } else {
    send_all();
  }
  send_full_state_to_new();  // the outbox sends bodies itself
}

void Sender::send_all() {
  for (SharedBody& shared : data_.bodies) {
    if (data_.world.contains(shared.def.body)) states_.push_back(state_of(shared));
  }
  post_springs();
  post_states();
}

double Sender::post_springs() {
  const double overhead = Outbox::kPacketOverhead;
  const double events =
      connections_.post_records(Connections::kToAll, std::span<const SpringUpdate>(spring_events_),
                                kSpringBytes, Delivery::Reliable, overhead) +
      connections_.post_records(Connections::kToAll, std::span<const ActUpdate>(acts_), kActBytes,
                                Delivery::Reliable, overhead) +
      connections_.post_records(Connections::kToAll, std::span<const ActReceipt>(receipts_),
                                kActReceiptBytes, Delivery::Reliable, overhead);
  return events + connections_.post_records(Connections::kToAll,
                                            std::span<const SpringUpdate>(spring_states_),
                                            kSpringBytes, Delivery::Newest, overhead);
}

void Sender::post_states() {
  if (interest_ == nullptr) {
    connections_.post_records(Connections::kToAll, std::span<const StateUpdate>(states_),
                              kStateBytes, Delivery::Newest);
    return;
  }
  for (const PeerId peer : connections_.connected()) {
    collect_concerning(peer);
    connections_.post_records(peer, std::span<const StateUpdate>(concerning_), kStateBytes,
                              Delivery::Newest);
  }
}

void Sender::collect_concerning(PeerId peer) {
  concerning_.clear();
  for (const StateUpdate& state : states_) {
    const bool concerns = interest_ == nullptr || interest_->concerns(peer, state.id, state.pose);
    if (concerns) concerning_.push_back(state);
  }
}

void Sender::send_full_state_to_new() {
  for (const PeerId to : connections_.newcomers()) {
    collect_concerning(to);
    connections_.post_records(to, std::span<const StateUpdate>(concerning_), kStateBytes,
                              Delivery::Reliable);
    connections_.post_records(to, std::span<const SpringUpdate>(spring_states_), kSpringBytes,
                              Delivery::Reliable);
  }
  connections_.greeted();
}

StateUpdate Sender::state_of(SharedBody& shared) const {
  const pbd::BodyState& state =
      shared.hard.active ? shared.hard.own : data_.world.state(shared.def.body);
  const bool by_hand = shared.hard.active || data_.springs.holds_alone(shared.def.body);
  const bool kinematic = data_.world.props(shared.def.body).type == pbd::BodyType::Kinematic;
  const bool leads = shared.initiative.strength() >= 1.0;
  const bool jumped = shared.jumped > 0;
  shared.jumped = std::max(shared.jumped - 1, 0);
  return {.id = shared.def.id,
          .pose = state.pose,
          .twist = state.twist,
          .influence = shared.hard.active ? 1.0F : static_cast<float>(data_.announced(shared)),
          .stamp = data_.now,
          .flags = {.in_contact = shared.coupled && !shared.held,
                    .held = shared.held,
                    .owner_driven = by_hand || (shared.def.owner == data_.self() && kinematic),
                    .teleported = jumped,
                    .leads = leads},
          .oriented = shared.def.orientation};
}

bool Sender::rests(SharedBody& shared, const pbd::BodyState& state) const {
  const bool acted_on = shared.held || shared.hard.active || shared.initiative.strength() > 0.0;
  if (acted_on || shared.jumped > 0 || !is_slow(state.twist)) {
    shared.rest_since = 0;
    return false;
  }
  const pbd::Pose& rest = shared.rest_pose;
  const bool stays = shared.rest_since != 0 &&
                     (state.pose.position - rest.position).norm() < kRestDistance &&
                     small_angle(rest.orientation, state.pose.orientation) < kRestAngle;
  if (!stays) {
    shared.rest_pose = state.pose;
    shared.rest_since = data_.now;
  }
  return seconds(data_.now - shared.rest_since) >= kRestsFor;
}

void Sender::encode_own_anchors() {
  const std::size_t most = packet_limit(data_.transport, Delivery::Newest);
  told_in_full_.clear();
  std::span<const SpringUpdate> left(spring_states_);
  while (!left.empty()) {
    const std::size_t before = anchors_.bytes.size();
    const std::size_t count = encode_anchors(left, before + most, told_in_full_, anchors_.bytes);
    if (count == 0) break;  // packets too short for any anchor
    if (anchors_.bytes.size() > before) anchors_.ends.push_back(anchors_.bytes.size());
    left = left.subspan(count);
  }
  spring_states_.swap(told_in_full_);
}

void Sender::renew_indices(std::size_t most) {
  if (!outbox_->renew(most)) return;
  for (SharedBody& shared : data_.bodies) shared.index = SharedBody::kNoIndex;
}

void Sender::collect_selectable() {
  selectable_.clear();
  for (SharedBody& shared : data_.bodies) {
    if (!data_.world.contains(shared.def.body)) continue;
    if (shared.index == SharedBody::kNoIndex) shared.index = outbox_->assign_index(shared.def.id);
    const std::uint32_t slot = shared.def.body.index;
    OutgoingState& state = selectable_.emplace_back();
    state.index = static_cast<std::uint16_t>(shared.index);
    state.gravity = data_.world.all_props()[slot].gravity_scale * data_.world.gravity();
    state.update = state_of(shared);
    UpdateFlags& flags = state.update.flags;
    const bool own_spring = (activity_.bits(slot) & (Springs::kShared | Springs::kAlone)) != 0;
    state.first = flags.leads || flags.owner_driven || own_spring;
    flags.resting = rests(shared, data_.world.state(shared.def.body));
    if (flags.resting) state.update.twist = {};
  }
  const auto by_index = [](const OutgoingState& a, const OutgoingState& b) {
    return a.index < b.index;
  };
  if (!std::is_sorted(selectable_.begin(), selectable_.end(), by_index)) {
    std::sort(selectable_.begin(), selectable_.end(), by_index);
  }
}

void Sender::send_selected() {
  const SessionTime now = data_.now;
  const auto fresh = std::count_if(data_.bodies.begin(), data_.bodies.end(),
                                   [](const auto& s) { return s.index == SharedBody::kNoIndex; });
  renew_indices(Outbox::kMaxIndices - static_cast<std::size_t>(fresh));
  collect_selectable();
  anchors_.clear();
  const bool in_full = data_.options.sending.format == StateFormat::Full ||
                       !connections_.newcomers().empty() ||
                       seconds(now - springs_told_) >= kSpringsEvery;
  if (in_full) springs_told_ = now;
  if (!in_full) encode_own_anchors();
  outbox_->charge(post_springs());
  outbox_->send(connections_.peers(), selectable_, anchors_, interest_, now);
  // Last, so that removed bodies are withdrawn first.
  constexpr std::size_t kSpareIndices = 1024;
  renew_indices(2 * data_.bodies.size() + kSpareIndices);
}

}  // namespace tandem::consensus
