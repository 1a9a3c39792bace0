// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "sent_packets.h"

#include <algorithm>

namespace tandem::net {

void SentPackets::Outcome::clear() {
  acked_pieces.clear();
  lost_pieces.clear();
  acked_sizes.clear();
  lost_sizes.clear();
  acked_packets = acked_bytes = lost_packets = late_packets = 0;
}

void SentPackets::grow() {
  std::vector<Entry> before(2 * entries_.size());
  before.swap(entries_);
  for (const Entry& entry : before) {
    if (entry.sequence != 0) slot(entry.sequence) = entry;
  }
}

bool SentPackets::may_come(const Entry& entry, std::int64_t now) {
  return entry.state == State::Flying ||
         (entry.state == State::Lost && now - entry.at < RttEstimate::kMaxTimeout);
}

SentPackets::Entry& SentPackets::next_slot(std::uint64_t sequence, std::int64_t now) {
  while (entries_.size() < kRing && may_come(slot(sequence), now)) grow();
  Entry& entry = slot(sequence);
  if (entry.state == State::Flying) lost(entry, overrun_);
  entry.sequence = sequence;
  entry.state = State::None;
  entry.is_probe = false;
  entry.piece_count = 0;
  latest_sent_ = sequence;
  const std::size_t ring = entries_.size();
  if (sequence >= ring) oldest_ = std::max(oldest_, sequence - ring + 1);
  return entry;
}

void SentPackets::sent_empty(std::uint64_t sequence, std::int64_t now) {
  next_slot(sequence, now).at = now;
}

void SentPackets::sent_probe(std::uint64_t sequence, std::size_t bytes, std::int64_t now) {
  sent(sequence, bytes, {}, now);
  slot(sequence).is_probe = true;
}

std::uint64_t SentPackets::widen(std::uint32_t ack) const {
  // The number nearest below the last one sent; 0 if there is none.
  const std::uint64_t behind =
      static_cast<std::uint32_t>(static_cast<std::uint32_t>(latest_sent_) - ack);
  return behind >= latest_sent_ ? 0 : latest_sent_ - behind;
}

std::optional<std::int64_t> SentPackets::sent_at(const ChannelHeader& header) const {
  const std::uint64_t ack = header.ack == 0 && header.ack_bits == 0 ? 0 : widen(header.ack);
  const Entry& entry = slot(ack);
  return ack != 0 && entry.sequence == ack ? std::optional(entry.at) : std::nullopt;
}

std::int64_t SentPackets::first_sent_from(std::uint64_t sequence) const {
  const std::uint64_t ring = entries_.size();
  for (sequence = std::max(sequence, latest_sent_ >= ring ? latest_sent_ - ring + 1 : 0);
       sequence <= latest_sent_; ++sequence) {
    if (slot(sequence).sequence == sequence) return slot(sequence).at;
  }
  return INT64_MAX;
}

void SentPackets::sent(std::uint64_t sequence, std::size_t bytes,
                       std::span<const std::uint64_t> pieces, std::int64_t now) {
  Entry& entry = next_slot(sequence, now);
  entry.at = now;
  entry.bytes = bytes;
  entry.state = State::Flying;
  entry.piece_count = static_cast<std::uint8_t>(std::min(pieces.size(), kMaxPieces));
  std::copy_n(pieces.begin(), entry.piece_count, entry.pieces.begin());
  ++in_flight_;
}

void SentPackets::acked(std::uint64_t sequence, Outcome& outcome) {
  Entry& entry = slot(sequence);
  if (entry.sequence != sequence) return;
  if (entry.state != State::Flying && entry.state != State::Lost) return;
  outcome.acked_sizes.push_back({entry.bytes, entry.is_probe});
  if (entry.state == State::Flying) {
    --in_flight_;
  } else {
    outcome.late_packets += entry.is_probe ? 0 : 1;
  }
  entry.state = State::Acked;
  ++outcome.acked_packets;
  outcome.acked_bytes += entry.bytes;
  outcome.acked_pieces.insert(outcome.acked_pieces.end(), entry.pieces.begin(),
                              entry.pieces.begin() + entry.piece_count);
}

void SentPackets::lost(Entry& entry, Outcome& outcome) {
  entry.state = State::Lost;
  --in_flight_;
  outcome.lost_sizes.push_back({entry.bytes, entry.is_probe});
  if (entry.is_probe) return;
  ++outcome.lost_packets;
  outcome.lost_pieces.insert(outcome.lost_pieces.end(), entry.pieces.begin(),
                             entry.pieces.begin() + entry.piece_count);
}

bool SentPackets::on_ack(const ChannelHeader& header, std::int64_t now, Outcome& outcome) {
  if (header.ack == 0 && header.ack_bits == 0) return true;  // nothing had yet
  const std::uint64_t ack = widen(header.ack);
  if (ack == 0) return false;

  // Packets counted as lost too: if a queue grows faster than the estimate, all are late.
  if (const Entry& entry = slot(ack);
      ack >= path_first_ && entry.sequence == ack &&
      (entry.state == State::Flying || entry.state == State::Lost)) {
    rtt_.add(now - entry.at - header.ack_delay * kAckDelayUnit, now);
  }
  const std::uint64_t before = outcome.acked_packets;
  acked(ack, outcome);
  // Packets are acknowledged many times: skip those known.
  if (ack > highest_acked_) {
    const std::uint64_t ahead = ack - highest_acked_;
    known_acked_ = ahead < 64 ? known_acked_ << ahead | std::uint64_t{1} << (ahead - 1) : 0;
    highest_acked_ = ack;
  }
  const std::uint64_t behind = highest_acked_ - ack;
  const std::uint64_t news =
      header.ack_bits & ~(behind < 64 ? known_acked_ >> behind : std::uint64_t{0});
  for (std::uint64_t i = 0; i < 64 && i + 1 < ack; ++i) {
    if ((news >> i & 1) != 0) acked(ack - 1 - i, outcome);
  }
  if (behind < 64) known_acked_ |= header.ack_bits << behind;
  if (outcome.acked_packets > before) backoff_ = 0;

  for (; oldest_ + kReorder <= highest_acked_; ++oldest_) {
    Entry& entry = slot(oldest_);
    if (entry.sequence == oldest_ && entry.state == State::Flying) lost(entry, outcome);
  }
  return true;
}

void SentPackets::on_time(std::int64_t now, Outcome& outcome) {
  if (!overrun_.lost_sizes.empty()) {
    outcome.lost_sizes.insert(outcome.lost_sizes.end(), overrun_.lost_sizes.begin(),
                              overrun_.lost_sizes.end());
    outcome.lost_packets += overrun_.lost_packets;
    outcome.lost_pieces.insert(outcome.lost_pieces.end(), overrun_.lost_pieces.begin(),
                               overrun_.lost_pieces.end());
    overrun_.clear();
  }
  const std::int64_t timeout =
      std::min(rtt_.timeout() << std::min(backoff_, 4), RttEstimate::kMaxTimeout);
  bool any = false;
  for (; oldest_ <= latest_sent_; ++oldest_) {
    Entry& entry = slot(oldest_);
    if (entry.sequence != oldest_ || entry.state != State::Flying) continue;
    if (now - entry.at < timeout) break;
    lost(entry, outcome);
    any = true;
  }
  if (any && now - last_timeout_ >= timeout) {
    ++backoff_;
    last_timeout_ = now;
  }
}

}  // namespace tandem::net
