// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "channel_wire.h"

namespace tandem::net {

/// Longest message of the mesh itself.
constexpr std::size_t kMaxGroupChange = 4096;

/// Pieces in flight; the receiver stores no more of them.
constexpr std::uint64_t kPieceWindow = 256;

/// First byte of each message.
enum class MessageKind : std::uint8_t { Application = 0, GroupChange = 1 };

/// Splits messages into pieces and sends each until it is acknowledged. It has no timers:
/// SentPackets reports losses. It may outlive the connection: the next one to the same process
/// continues with it.
class ReliableSender {
 public:
  /// @param limit  bytes that may wait, plus 64 for each piece
  ReliableSender(std::size_t limit, std::size_t max_message)
      : limit_(limit), max_message_(max_message) {}

  /// False if it is too long or does not fit.
  [[nodiscard]] bool post(std::span<const std::byte> message,
                          MessageKind kind = MessageKind::Application);
  bool due() const { return next_due().has_value(); }
  /// The next piece, if it fits into `room` with its header; it counts as sent then. The view is
  /// valid until the piece is acknowledged.
  struct Piece {
    std::uint64_t number = 0;
    ChannelSection section;
  };
  std::optional<Piece> take(std::size_t room);
  void on_acked(std::uint64_t number);
  void on_lost(std::uint64_t number);
  /// A new connection to the same process: unacknowledged pieces are sent again.
  void restart();
  /// Drops all waiting pieces. The other end notices by the stream number.
  void begin_anew();

  bool empty() const { return pieces_.empty(); }
  std::size_t cost() const { return cost_; }
  std::uint64_t resent() const { return resent_; }

 private:
  enum class State : std::uint8_t { Waiting, Flying, Acked };
  struct Entry {
    State state = State::Waiting;
    bool last = false;
    bool sent = false;
    std::vector<std::byte> bytes;
  };

  Entry* find(std::uint64_t number);
  std::optional<std::size_t> next_due() const;

  std::size_t limit_;
  std::size_t max_message_;
  std::vector<std::byte> kinded_;  // scratch
  std::deque<Entry> pieces_;       // the first has number first_
  std::uint64_t first_ = 1;
  std::uint8_t stream_ = 0;
  std::size_t cost_ = 0;
  std::uint64_t resent_ = 0;
};

/// Reassembles pieces, in order, each once. Stores at most kPieceWindow of them and one incomplete
/// message.
class ReliableReceiver {
 public:
  explicit ReliableReceiver(std::size_t max_message) : max_message_(max_message) {}

  /// Appends completed messages. False for violations of the protocol: a piece beyond the window,
  /// or of a message that is too long.
  [[nodiscard]] bool on_piece(const ChannelSection& piece,
                              std::vector<std::vector<std::byte>>& messages);

 private:
  struct Entry {
    bool last = false;
    std::vector<std::byte> bytes;
  };

  std::size_t max_message_;
  std::uint8_t stream_ = 0;
  std::uint64_t expected_ = 1;
  std::map<std::uint64_t, Entry> early_;
  std::vector<std::byte> message_;
};

}  // namespace tandem::net
