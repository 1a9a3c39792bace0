// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "reliable_channel.h"

#include <algorithm>
#include <utility>

namespace tandem::net {

namespace {

constexpr std::size_t kPieceCost = 64;  // approximate overhead of a stored piece

}  // namespace

bool ReliableSender::post(std::span<const std::byte> bytes, MessageKind kind) {
  // The mesh's own messages are short, and bypass the application's limit.
  const bool own = kind != MessageKind::Application;
  if (bytes.size() > max_message_ && !own) return false;
  kinded_.assign(1, static_cast<std::byte>(kind));
  kinded_.insert(kinded_.end(), bytes.begin(), bytes.end());
  const std::span<const std::byte> message = kinded_;
  const std::size_t count = (message.size() + kMaxPieceBytes - 1) / kMaxPieceBytes;
  const std::size_t cost = message.size() + count * kPieceCost;
  if (cost_ + cost > limit_ && !own) return false;
  cost_ += cost;
  for (std::size_t i = 0; i < count; ++i) {
    const auto rest = message.subspan(i * kMaxPieceBytes);
    const auto piece = rest.first(std::min(rest.size(), kMaxPieceBytes));
    pieces_.push_back({.last = i + 1 == count, .bytes = {piece.begin(), piece.end()}});
  }
  return true;
}

std::optional<std::size_t> ReliableSender::next_due() const {
  const std::size_t end = std::min<std::size_t>(pieces_.size(), kPieceWindow);
  for (std::size_t i = 0; i < end; ++i) {
    if (pieces_[i].state == State::Waiting) return i;
  }
  return {};
}

std::optional<ReliableSender::Piece> ReliableSender::take(std::size_t room) {
  const auto index = next_due();
  if (!index) return {};
  Entry& entry = pieces_[*index];
  if (kPieceHeader + entry.bytes.size() > room) return {};
  if (std::exchange(entry.sent, true)) ++resent_;
  entry.state = State::Flying;
  const std::uint64_t number = first_ + *index;
  return Piece{.number = number,
               .section = {.kind = ChannelSection::Kind::Piece,
                           .number = static_cast<std::uint32_t>(number),
                           .last = entry.last,
                           .stream = stream_,
                           .bytes = entry.bytes}};
}

ReliableSender::Entry* ReliableSender::find(std::uint64_t number) {
  if (number < first_ || number - first_ >= pieces_.size()) return nullptr;
  return &pieces_[number - first_];
}

void ReliableSender::on_acked(std::uint64_t number) {
  Entry* entry = find(number);
  if (entry == nullptr) return;
  entry->state = State::Acked;
  while (!pieces_.empty() && pieces_.front().state == State::Acked) {
    cost_ -= pieces_.front().bytes.size() + kPieceCost;
    pieces_.pop_front();
    ++first_;
  }
}

void ReliableSender::on_lost(std::uint64_t number) {
  Entry* entry = find(number);
  if (entry != nullptr && entry->state == State::Flying) entry->state = State::Waiting;
}

void ReliableSender::restart() {
  for (Entry& entry : pieces_) {
    if (entry.state == State::Flying) entry.state = State::Waiting;
  }
}

void ReliableSender::begin_anew() {
  pieces_.clear();
  cost_ = 0;
  first_ = 1;
  stream_ = static_cast<std::uint8_t>((stream_ + 1) % kStreams);
}

bool ReliableReceiver::on_piece(const ChannelSection& piece,
                                std::vector<std::vector<std::byte>>& messages) {
  if (piece.stream != stream_) {
    const auto later = static_cast<std::uint8_t>((piece.stream - stream_) & (kStreams - 1));
    if (later >= kStreams / 2) return true;  // of a finished stream
    stream_ = piece.stream;
    expected_ = 1;
    early_.clear();
    message_.clear();
  }
  const auto ahead =
      static_cast<std::int32_t>(piece.number - static_cast<std::uint32_t>(expected_));
  if (ahead < 0) return true;  // received before
  if (ahead >= static_cast<std::int32_t>(kPieceWindow)) return false;
  early_.try_emplace(expected_ + static_cast<std::uint32_t>(ahead),
                     Entry{.last = piece.last, .bytes = {piece.bytes.begin(), piece.bytes.end()}});
  for (auto next = early_.begin(); next != early_.end() && next->first == expected_;
       next = early_.begin()) {
    Entry& entry = next->second;
    if (message_.size() + entry.bytes.size() > 1 + std::max(max_message_, kMaxGroupChange)) {
      return false;
    }
    message_.insert(message_.end(), entry.bytes.begin(), entry.bytes.end());
    if (entry.last) messages.push_back(std::exchange(message_, {}));
    early_.erase(next);
    ++expected_;
  }
  return true;
}

}  // namespace tandem::net
