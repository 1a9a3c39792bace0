// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "channels.h"

#include <algorithm>
#include <array>
#include <utility>

#include "packet_protection.h"

namespace tandem::net {

namespace {

constexpr std::size_t kOnWire = kProtectedOverhead + kIpUdpBytes;

}  // namespace

Channels::Channels(const ChannelOptions& options, std::size_t max_datagram)
    : options_(options),
      states_(options.state_queue_bytes, options.state_life),
      reliable_(options.reliable_queue_bytes, options.max_message_bytes),
      max_datagram_(max_datagram),
      mtu_(max_datagram),
      inbox_(options.receive_queue_bytes, options.max_message_bytes) {}

bool Channels::post_state(std::span<const std::byte> state, std::size_t room, std::int64_t now) {
  if (kChannelHeader + kStateHeader + state.size() > room) return false;
  states_.push(state, now);
  return true;
}

bool Channels::has_content(std::int64_t now) {
  states_.drop_stale(now);
  return !states_.empty() || reliable_.due() || !to_tell_.empty();
}

Channels::Reliable Channels::take_reliable() {
  return {.sender =
              std::exchange(reliable_, {options_.reliable_queue_bytes, options_.max_message_bytes}),
          .receiver = inbox_.replace_receiver(ReliableReceiver(options_.max_message_bytes))};
}

void Channels::resume(Reliable reliable) {
  reliable_ = std::move(reliable.sender);
  reliable_.restart();
  inbox_.replace_receiver(std::move(reliable.receiver));
}

bool Channels::write_piece(std::size_t end, std::vector<std::byte>& out) {
  if (pieces_.size() == SentPackets::kMaxPieces) return false;
  const auto piece = reliable_.take(end - out.size());
  if (!piece) return false;
  encode(piece->section, out);
  pieces_.push_back(piece->number);
  return true;
}

void Channels::write_probe(std::uint64_t sequence, std::size_t datagram, double kbit_per_s,
                           std::int64_t now, std::vector<std::byte>& out) {
  const std::size_t end = out.size() + datagram - kProtectedOverhead;
  acknowledger_.write(now, out);
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
  states_.drop_stale(now);
  const std::size_t start = out.size();
  const std::size_t end = start + room;
  acknowledger_.write(now, out);
  if (clock != nullptr) {
    encode({.kind = ChannelSection::Kind::Clock,
            .clock = *clock,
            .clock_delay = acknowledger_.clock_delay(now)},
           out);
  }

  // In turn, so that neither starves at a low rate; each gets what the other leaves.
  pieces_.clear();
  const std::size_t empty = out.size();
  if (reliable_first_) (void)write_piece(end, out);
  while (states_.write(end, out)) continue;
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
  for (const std::uint64_t number : outcome_.lost_pieces) reliable_.on_lost(number);
  for (const std::uint64_t number : outcome_.acked_pieces) reliable_.on_acked(number);
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
  // Longer states would block all that follow.
  states_.drop_longer(mtu_.size() - kProtectedOverhead - kChannelHeader - kStateHeader);
}

void Channels::note_clock(const ChannelSection& section, std::int64_t now) {
  const auto sent = sent_.sent_at(packet_.header);
  if (!sent || section.clock_delay == kNoClockDelay) return;
  // Not an honest clock's; the difference below could overflow.
  if (section.clock.sent <= -ClockFilter::kFarthest) return;
  exchange_ = {.sample = {.sent = *sent,
                          .their_received = section.clock.sent - section.clock_delay,
                          .their_sent = section.clock.sent,
                          .received = now},
               .claim = section.clock};
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
  if (std::ranges::any_of(packet_.sections, is_piece) && !inbox_.admits_pieces(now)) {
    return Read::Full;
  }
  for (const ChannelSection& section : packet_.sections) {
    if (section.kind == ChannelSection::Kind::Clock) note_clock(section, now);
    if (const Read result = inbox_.take(section, now); result != Read::Ok) return result;
  }
  // Other sections are repeated anyway.
  const auto wants_ack = [](const ChannelSection& s) {
    return s.kind == ChannelSection::Kind::State || s.kind == ChannelSection::Kind::Piece ||
           s.kind == ChannelSection::Kind::Padding;
  };
  acknowledger_.note(sequence, std::ranges::any_of(packet_.sections, wants_ack), now);
  return Read::Ok;
}

void Channels::on_time(std::int64_t now) {
  sent_.on_time(now, outcome_);
  settle(now);
}

}  // namespace tandem::net
