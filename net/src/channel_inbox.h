// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <utility>
#include <vector>

#include "channel_wire.h"
#include "member_budget.h"
#include "reliable_channel.h"
#include "tandem/consensus/transport.h"

namespace tandem::net {

constexpr std::size_t kMaxToTell = 64;  // third peers that wait to be announced, or to be read

/// Contents received from the other end of a connection, until they are taken. Bounded, whatever it
/// sends. Times in ns.
class ChannelInbox {
 public:
  /// @param limit_bytes  of either kind of message, not drained
  ChannelInbox(std::size_t limit_bytes, std::size_t max_message_bytes)
      : limit_(limit_bytes), max_message_(max_message_bytes), receiver_(max_message_bytes) {}

  enum class Read {
    Ok,
    Malformed,  // or against the protocol: the connection ends
    Full,       // inbox or budget: not acknowledged, so it comes again
    Goodbye,    // goodbye() has the reason
  };
  /// Whether there is room for pieces of reliable messages.
  bool admits_pieces(std::int64_t now) { return reliable_cost_ < limit_ && budget_.admits(now); }
  Read take(const ChannelSection& section, std::int64_t now);
  /// Continue the reliable messages with `receiver`; returns the previous one.
  ReliableReceiver replace_receiver(ReliableReceiver receiver) {
    return std::exchange(receiver_, std::move(receiver));
  }

  struct Message {
    consensus::Delivery delivery{};
    std::vector<std::byte> bytes;
    std::int64_t at = 0;  // time of arrival
  };
  /// Appends all received messages.
  void drain(std::vector<Message>& out);
  /// Empty if none has come.
  std::vector<std::byte> take_group_change() { return std::exchange(group_change_, {}); }
  /// Third peers announced since the last call.
  std::vector<KnownPeer> take_told() { return std::exchange(told_, {}); }
  /// Token that the other end wants echoed, and the one that it echoes, of the last packet.
  std::optional<std::uint64_t> take_challenge() { return std::exchange(challenge_, {}); }
  std::optional<std::uint64_t> take_answer() { return std::exchange(answer_, {}); }

  const std::vector<std::byte>& goodbye() const { return goodbye_; }
  std::uint64_t dropped_states() const { return dropped_states_; }
  /// Counts messages not accepted or to be resent: the other end sends too much.
  const MemberBudget& budget() const { return budget_; }

 private:
  /// A whole message of the reliable channel. False if it violates the protocol.
  bool take_message(std::vector<std::byte> message, std::int64_t now);
  void keep(consensus::Delivery delivery, std::vector<std::byte> bytes, std::int64_t now);

  std::size_t limit_;
  std::size_t max_message_;
  ReliableReceiver receiver_;
  std::vector<std::vector<std::byte>> complete_;
  std::deque<Message> messages_;
  std::size_t states_cost_ = 0;
  std::size_t reliable_cost_ = 0;
  std::uint64_t dropped_states_ = 0;
  MemberBudget budget_;
  std::vector<KnownPeer> told_;
  std::vector<std::byte> group_change_;
  std::vector<std::byte> goodbye_;
  std::optional<std::uint64_t> challenge_;
  std::optional<std::uint64_t> answer_;
};

}  // namespace tandem::net
