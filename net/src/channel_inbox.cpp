// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "channel_inbox.h"

#include <algorithm>
#include <iterator>

#include "frame_queue.h"

namespace tandem::net {

namespace {

using consensus::Delivery;

constexpr std::size_t kMaxGoodbye = 256;

}  // namespace

void ChannelInbox::keep(Delivery delivery, std::vector<std::byte> bytes, std::int64_t now) {
  const std::size_t cost = queue_cost(bytes.size());
  messages_.push_back({.delivery = delivery, .bytes = std::move(bytes), .at = now});
  if (delivery == Delivery::Reliable) {
    reliable_cost_ += cost;
    return;
  }
  states_cost_ += cost;
  while (states_cost_ > limit_) {
    const auto oldest = std::ranges::find(messages_, Delivery::Newest, &Message::delivery);
    states_cost_ -= queue_cost(oldest->bytes.size());
    messages_.erase(oldest);
    ++dropped_states_;
  }
}

bool ChannelInbox::take_message(std::vector<std::byte> message, std::int64_t now) {
  if (message.empty() || message.front() > static_cast<std::byte>(MessageKind::GroupChange)) {
    return false;
  }
  const auto kind = static_cast<MessageKind>(message.front());
  message.erase(message.begin());
  if (kind == MessageKind::GroupChange) {
    if (message.size() > kMaxGroupChange) return false;
    group_change_ = std::move(message);  // a later change supersedes an earlier one
    return true;
  }
  if (message.size() > max_message_) return false;
  keep(Delivery::Reliable, std::move(message), now);
  return true;
}

ChannelInbox::Read ChannelInbox::take(const ChannelSection& section, std::int64_t now) {
  using Kind = ChannelSection::Kind;
  if (section.kind == Kind::State) {
    if (!budget_.admits(now)) return Read::Ok;
    budget_.spend(section.bytes.size());
    keep(Delivery::Newest, {section.bytes.begin(), section.bytes.end()}, now);
    return Read::Ok;
  }
  if (section.kind == Kind::Goodbye) {
    const auto text = section.bytes.first(std::min(section.bytes.size(), kMaxGoodbye));
    goodbye_.assign(text.begin(), text.end());
    return Read::Goodbye;
  }
  budget_.spend(section.kind == Kind::Piece ? section.bytes.size() : 0);
  switch (section.kind) {
    case Kind::Piece:
      complete_.clear();
      if (!receiver_.on_piece(section, complete_)) return Read::Malformed;
      for (auto& message : complete_) {
        if (!take_message(std::move(message), now)) return Read::Malformed;
      }
      break;
    case Kind::Known:
      if (told_.size() < kMaxToTell) told_.push_back(section.known);
      break;
    case Kind::Challenge:
      challenge_ = section.token;
      break;
    case Kind::Answer:
      answer_ = section.token;
      break;
    case Kind::Clock:
    case Kind::State:
    case Kind::Goodbye:
    case Kind::Padding:
      break;
  }
  return Read::Ok;
}

void ChannelInbox::drain(std::vector<Message>& out) {
  std::ranges::move(messages_, std::back_inserter(out));
  messages_.clear();
  states_cost_ = reliable_cost_ = 0;
}

}  // namespace tandem::net
