// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "channels.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <utility>

#include "frame_queue.h"
#include "packet_protection.h"

namespace tandem::net {

namespace {

using consensus::Delivery;

constexpr std::int64_t kAckDelay = RttEstimate::kMaxAckDelay;  // a state carries it sooner
constexpr std::size_t kOnWire = kProtectedOverhead + kIpUdpBytes;
constexpr int kAckEvery = 8;  // packets, whatever the time
constexpr std::size_t kMaxGoodbye = 256;
constexpr std::size_t kMaxToTell = 64;

}  // namespace

Channels::Channels(const ChannelOptions& options, std::size_t max_datagram)
    : options_(options),
      reliable_{.sender = {options.reliable_queue_bytes, options.max_message_bytes},
                .receiver = ReliableReceiver(options.max_message_bytes)},
      max_datagram_(max_datagram),
      mtu_(max_datagram) {}

bool Channels::post_state(std::span<const std::byte> state, std::size_t room, std::int64_t now) {
  if (kChannelHeader + kStateHeader + state.size() > room) return false;
  states_.push_back({.bytes = {state.begin(), state.end()}, .at = now});
  states_cost_ += queue_cost(state.size());
  while (states_cost_ > options_.state_queue_bytes) {
    states_cost_ -= queue_cost(states_.front().bytes.size());
    states_.pop_front();
    ++dropped_states_;
  }
  return true;
}

void Channels::drop_stale(std::int64_t now) {
  while (!states_.empty() && now - states_.front().at > options_.state_life) {
    states_cost_ -= queue_cost(states_.front().bytes.size());
    states_.pop_front();
    ++dropped_states_;
  }
}

bool Channels::has_content(std::int64_t now) {
  drop_stale(now);
  return !states_.empty() || reliable_.sender.due() || !to_tell_.empty();
}

void Channels::tell(const KnownPeer& known) {
  if (to_tell_.size() < kMaxToTell) to_tell_.push_back(known);
}

Channels::Reliable Channels::take_reliable() {
  return std::exchange(reliable_,
                       {.sender = {options_.reliable_queue_bytes, options_.max_message_bytes},
                        .receiver = ReliableReceiver(options_.max_message_bytes)});
}

void Channels::resume(Reliable reliable) {
  reliable_ = std::move(reliable);
  reliable_.sender.restart();
}

bool Channels::write_state(std::size_t end, std::vector<std::byte>& out) {
  if (states_.empty()) return false;
  const State& state = states_.front();
  if (out.size() + kStateHeader + state.bytes.size() > end) return false;
  encode({.kind = ChannelSection::Kind::State, .bytes = state.bytes}, out);
  states_cost_ -= queue_cost(state.bytes.size());
  states_.pop_front();
  return true;
}

bool Channels::write_piece(std::size_t end, std::vector<std::byte>& out) {
  if (pieces_.size() == SentPackets::kMaxPieces) return false;
  const auto piece = reliable_.sender.take(end - out.size());
  if (!piece) return false;
  encode(piece->section, out);
  pieces_.push_back(piece->number);
  return true;
}

void Channels::write_acknowledgements(std::int64_t now, std::vector<std::byte>& out) {
  ChannelHeader header;
  if (had_.latest() != 0) {
    header.ack = static_cast<std::uint32_t>(had_.latest());
    header.ack_bits = had_.before_latest();
    header.ack_delay = static_cast<std::uint16_t>(
        std::clamp<std::int64_t>((now - latest_at_) / kAckDelayUnit, 0, 0xffff));
  }
  encode(header, out);
  unacknowledged_ = 0;
  ack_due_ = INT64_MAX;
}

void Channels::write_probe(std::uint64_t sequence, std::size_t datagram, double kbit_per_s,
                           std::int64_t now, std::vector<std::byte>& out) {
  const std::size_t end = out.size() + datagram - kProtectedOverhead;
  write_acknowledgements(now, out);
  const std::array<std::byte, kMaxDatagram> zeros{};
  encode({.kind = ChannelSection::Kind::Padding,
          .bytes = std::span(zeros).first(end - out.size() - kPaddingHeader)},
         out);
  sent_.sent_probe(sequence, datagram + kIpUdpBytes, now);
  mtu_.sent(datagram, kbit_per_s, now);
}

void Channels::begin_path() {
  sent_.begin_path();
  mtu_ = MtuSearch(max_datagram_);
}

void Channels::write(std::uint64_t sequence, std::size_t room, std::int64_t now,
                     const ClockClaim* clock, std::vector<std::byte>& out) {
  drop_stale(now);
  const std::size_t start = out.size();
  const std::size_t end = start + room;
  write_acknowledgements(now, out);
  if (clock != nullptr) {
    const std::int64_t delay = now - latest_at_;
    const bool known = had_.latest() != 0 && delay >= 0 && delay < std::int64_t{kNoClockDelay};
    encode({.kind = ChannelSection::Kind::Clock,
            .clock = *clock,
            .clock_delay = known ? static_cast<std::uint32_t>(delay) : kNoClockDelay},
           out);
  }

  // In turn, so that neither waits for ever where the rate is low; what is left over goes to both.
  pieces_.clear();
  const std::size_t empty = out.size();
  if (reliable_first_) (void)write_piece(end, out);
  while (write_state(end, out)) continue;
  while (write_piece(end, out)) continue;
  reliable_first_ = !reliable_first_;
  const bool has_content = out.size() > empty;
  while (!to_tell_.empty() && out.size() + kKnownBytes <= end) {
    encode({.kind = ChannelSection::Kind::Known, .known = to_tell_.front()}, out);
    to_tell_.pop_front();
  }
  if (has_content) {
    sent_.sent(sequence, out.size() - start + kOnWire, pieces_, now);
  } else {
    sent_.sent_empty(sequence, now);
  }
}

void Channels::settle(std::int64_t now) {
  for (const std::uint64_t number : outcome_.lost_pieces) reliable_.sender.on_lost(number);
  for (const std::uint64_t number : outcome_.acked_pieces) reliable_.sender.on_acked(number);
  feedback_.acked += outcome_.acked_packets;
  feedback_.lost += outcome_.lost_packets;
  feedback_.acked_bytes += outcome_.acked_bytes;
  feedback_.late += outcome_.late_packets;
  for (const auto& [bytes, is_probe] : outcome_.lost_sizes) {
    is_probe ? mtu_.probe_lost(now) : mtu_.lost(bytes - kIpUdpBytes);
  }
  for (const auto& [bytes, is_probe] : outcome_.acked_sizes) {
    mtu_.acked(bytes - kIpUdpBytes, is_probe, now);
  }
  outcome_.clear();
  // What does not fit any more would be in the way of all that follows.
  const std::size_t most = mtu_.size() - kProtectedOverhead - kChannelHeader - kStateHeader;
  const auto is_long = [most](const State& state) { return state.bytes.size() > most; };
  if (std::ranges::none_of(states_, is_long)) return;
  for (const State& state : states_) {
    if (!is_long(state)) continue;
    states_cost_ -= queue_cost(state.bytes.size());
    ++dropped_states_;
  }
  std::erase_if(states_, is_long);
}

void Channels::keep(Delivery delivery, std::vector<std::byte> bytes, std::int64_t now) {
  const std::size_t cost = queue_cost(bytes.size());
  inbox_.push_back({.delivery = delivery, .bytes = std::move(bytes), .at = now});
  if (delivery == Delivery::Reliable) {
    inbox_reliable_ += cost;
    return;
  }
  inbox_states_ += cost;
  while (inbox_states_ > options_.inbox_bytes) {
    const auto oldest = std::ranges::find(inbox_, Delivery::Newest, &Message::delivery);
    inbox_states_ -= queue_cost(oldest->bytes.size());
    inbox_.erase(oldest);
    ++dropped_states_;
  }
}

bool Channels::take_message(std::vector<std::byte> message, std::int64_t now) {
  if (message.empty() || message.front() > static_cast<std::byte>(MessageKind::GroupChange)) {
    return false;
  }
  const auto kind = static_cast<MessageKind>(message.front());
  message.erase(message.begin());
  if (kind == MessageKind::GroupChange) {
    if (message.size() > kMaxGroupChange) return false;
    group_change_ = std::move(message);  // a later one says all that an earlier one did
    return true;
  }
  if (message.size() > options_.max_message_bytes) return false;
  keep(Delivery::Reliable, std::move(message), now);
  return true;
}

void Channels::note_clock(const ChannelSection& section, std::int64_t now) {
  const auto sent = sent_.sent_at(packet_.header);
  if (!sent || section.clock_delay == kNoClockDelay) return;
  // Not of an honest clock; the difference below could overflow.
  if (section.clock.sent <= -ClockFilter::kFarthest) return;
  exchange_ = {.sample = {.sent = *sent,
                          .their_received = section.clock.sent - section.clock_delay,
                          .their_sent = section.clock.sent,
                          .received = now},
               .claim = section.clock};
}

Channels::Read Channels::take(const ChannelSection& section, std::int64_t now) {
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
      if (!reliable_.receiver.on_piece(section, complete_)) return Read::Malformed;
      for (auto& message : complete_) {
        if (!take_message(std::move(message), now)) return Read::Malformed;
      }
      break;
    case Kind::Known:
      if (told_.size() < kMaxToTell) told_.push_back(section.known);
      break;
    case Kind::Clock:
      note_clock(section, now);
      break;
    case Kind::Challenge:
      challenge_ = section.token;
      break;
    case Kind::Answer:
      answer_ = section.token;
      break;
    case Kind::State:
    case Kind::Goodbye:
    case Kind::Padding:
      break;
  }
  return Read::Ok;
}

Channels::Read Channels::read(std::uint64_t sequence, std::span<const std::byte> plain,
                              std::int64_t now) {
  if (!decode_channel_packet(plain, packet_)) return Read::Malformed;
  if (!sent_.on_ack(packet_.header, now, outcome_)) return Read::Malformed;
  mtu_.heard();
  settle(now);
  const auto is_piece = [](const ChannelSection& s) {
    return s.kind == ChannelSection::Kind::Piece;
  };
  if (std::ranges::any_of(packet_.sections, is_piece) &&
      (inbox_reliable_ >= options_.inbox_bytes || !budget_.admits(now))) {
    return Read::Full;
  }
  for (const ChannelSection& section : packet_.sections) {
    if (const Read result = take(section, now); result != Read::Ok) return result;
  }
  if (sequence > had_.latest()) latest_at_ = now;
  if (had_.fresh(sequence)) had_.note(sequence);
  // The rest is said again anyway.
  const auto wants_ack = [](const ChannelSection& s) {
    return s.kind == ChannelSection::Kind::State || s.kind == ChannelSection::Kind::Piece ||
           s.kind == ChannelSection::Kind::Padding;
  };
  if (std::ranges::any_of(packet_.sections, wants_ack)) {
    ++unacknowledged_;
    ack_due_ = unacknowledged_ >= kAckEvery ? now : std::min(ack_due_, now + kAckDelay);
  }
  return Read::Ok;
}

void Channels::on_time(std::int64_t now) {
  sent_.on_time(now, outcome_);
  settle(now);
}

void Channels::drain(std::vector<Message>& out) {
  std::ranges::move(inbox_, std::back_inserter(out));
  inbox_.clear();
  inbox_states_ = inbox_reliable_ = 0;
}

Channels::Feedback Channels::take_feedback() { return std::exchange(feedback_, {}); }

}  // namespace tandem::net
