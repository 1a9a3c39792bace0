// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Packs what was chosen: indices, states with anchors, withdrawals.
#include <algorithm>

#include "send/outbox.h"

namespace tandem::consensus {

bool Outbox::post(Link& link, Delivery delivery) {
  if (!transport_.post(link.to, packet_, delivery)) return false;
  stats_.bytes_sent += packet_.size();
  counters_of(link).bytes += packet_.size();
  if (link.kbit_per_s > 0.0) {
    link.room -= static_cast<double>(packet_.size()) + kPacketOverhead;
  }
  return true;
}

void Outbox::post_indices(Link& link, std::span<const OutgoingState> states) {
  constexpr std::size_t kRun = 256;                        // ids of one message
  constexpr std::size_t kLongest = kIdBytes * (kRun + 1);  // its approximate bytes
  const std::size_t most = packet_limit(transport_, Delivery::Reliable);
  // A further message is begun if a long one fits, or half the packet is left.
  const std::size_t least = std::min(kLongest, most / 2);
  packet_.clear();
  places_.clear();
  const auto flush = [&] {
    const bool told = packet_.empty() || post(link, Delivery::Reliable);
    for (const std::uint32_t index : places_) link.sent[index].indexed = told;
    packet_.clear();
    places_.clear();
  };
  std::size_t i = 0;
  while (i < due_.size()) {
    ids_.clear();
    // At least one: if packets are too short for it, the transport reports that.
    const std::size_t run = std::clamp<std::size_t>(indices_in(most - packet_.size()), 1, kRun);
    const std::uint32_t first = states[due_[i].at].index;
    for (; i < due_.size() && ids_.size() < run; ++i) {
      const std::uint32_t index = states[due_[i].at].index;
      if (link.sent[index].indexed) {
        if (ids_.empty()) ++i;
        break;
      }
      if (index != first + ids_.size()) break;
      ids_.push_back(indexed_[index]);
      places_.push_back(index);
    }
    if (ids_.empty()) continue;
    encode_indices(table_, static_cast<std::uint16_t>(first), ids_, packet_);
    if (packet_.size() + least > most) flush();
  }
  flush();
  // A state whose index was not sent would belong to no body.
  std::erase_if(due_, [&](const Due& due) { return !link.sent[states[due.at].index].indexed; });
}

std::span<const std::byte> Outbox::post_anchors(Link& link, const AnchorMessages& anchors) {
  if (taken_.empty()) return {};
  for (std::size_t i = 0; i + 1 < taken_.size(); ++i) {
    const std::span<const std::byte> message = anchors[taken_[i]];
    packet_.assign(message.begin(), message.end());
    post(link, Delivery::Newest);
  }
  return anchors[taken_.back()];
}

void Outbox::post_states(Link& link, std::span<const OutgoingState> states,
                         std::span<const std::byte> anchors, bool reliable, SessionTime now) {
  const bool compact = options_.format == StateFormat::Compact;
  places_.clear();
  compact_.clear();
  full_.clear();
  for (const Due& due : due_) {
    if (due.reliable != reliable) continue;
    const OutgoingState& state = states[due.at];
    StateUpdate update = state.update;
    update.flags.teleported = link.sent[state.index].jumped > 0;
    places_.push_back(due.at);
    if (compact) compact_.push_back({state.index, update});
    if (!compact) full_.push_back(update);
  }
  if (reliable && !places_.empty()) link.committed = now;
  const Delivery delivery = reliable ? Delivery::Reliable : Delivery::Newest;
  const std::size_t most = packet_limit(transport_, delivery);
  packet_.assign(anchors.begin(), anchors.end());
  std::size_t next = 0;
  while (next < places_.size()) {
    std::size_t count = 0;
    if (compact) {
      count = encode_compact(std::span(compact_).subspan(next), table_, most, packet_);
    } else {
      const std::size_t room = most > packet_.size() ? most - packet_.size() : 0;
      // If no state fits beside the anchors, the next packet has the states.
      const bool fits = packet_.empty() || room >= kHeaderBytes + kStateBytes;
      count = std::min({kMaxRecords, records_in(room, kStateBytes), places_.size() - next});
      if (!fits) count = 0;
      encode(std::span<const StateUpdate>(full_).subspan(next, count), packet_);
    }
    if (packet_.empty() && count == 0) return;  // packets too short for any state
    const bool gone = packet_.empty() || post(link, delivery);
    packet_.clear();
    for (std::size_t k = next; k < next + count && gone; ++k) {
      const OutgoingState& state = states[places_[k]];
      Sent& sent = link.sent[state.index];
      const StateUpdate& there = compact ? compact_[k].update : full_[k];
      sent.stamp = now;
      sent.pose = there.pose;
      sent.twist = there.twist;
      sent.flags = state.update.flags;
      sent.influence = state.update.influence;
      sent.committed = state.update.flags.resting && (reliable || sent.committed);
      sent.news = sent.news > 0 ? static_cast<std::uint8_t>(sent.news - 1) : std::uint8_t{0};
      sent.jumped = sent.jumped > 0 ? static_cast<std::uint8_t>(sent.jumped - 1) : std::uint8_t{0};
      sent.priority = 0.0;
    }
    counters_of(link).states += gone ? count : 0;
    next += count;
  }
  if (!packet_.empty()) post(link, delivery);  // anchors alone
}

void Outbox::withdraw(Link& link) {
  std::span<IndexedState> left(withdrawn_);
  while (!left.empty()) {
    packet_.clear();
    std::size_t count = 1;
    if (options_.format == StateFormat::Compact) {
      count = encode_compact(left, table_, packet_limit(transport_, Delivery::Reliable), packet_);
    } else {
      encode(std::span<const StateUpdate>(&left.front().update, 1), packet_);
    }
    if (count == 0) return;
    if (!packet_.empty()) post(link, Delivery::Reliable);
    left = left.subspan(count);
  }
}

}  // namespace tandem::consensus
