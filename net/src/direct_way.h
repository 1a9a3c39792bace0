// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "address.h"
#include "crypto.h"
#include "udp_connection.h"

namespace tandem::net {

using SendDatagram = std::function<void(std::span<const std::byte>, const Address&)>;

/// Random, never 0 (kNoToken): only a receiver can echo it.
std::uint64_t random_token(const crypto::Random& random);

/// A direct path between sockets, beside the path by which a connection was made (a server's). Both
/// carry datagrams of the one connection, under the same keys and numbers: a packet that comes by
/// both is opened once. The other end is challenged at the addresses that it announces; after
/// kProofs answers all packets go this way alone. If a packet and all after it are unacknowledged
/// for patience(), packets go both ways until an answer comes, for at most kDoubt. Each failure
/// makes the next pause longer. Times in ns.
class DirectWay {
 public:
  static constexpr std::size_t kMaxOffered = 4;           ///< addresses; the oldest is dropped
  static constexpr int kProofs = 3;                       ///< answers from one address in a row
  static constexpr int kAsks = 6;                         ///< per search
  static constexpr std::int64_t kAskEvery = 100'000'000;  ///< ns
  static constexpr std::int64_t kDoubt = 1'000'000'000;
  static constexpr std::int64_t kMinRest = 1'000'000'000;
  static constexpr std::int64_t kMaxRest = 16'000'000'000;
  static constexpr std::int64_t kSteady = 30'000'000'000;  ///< after it failures are forgiven

  /// Whether the direct path is to be used if possible.
  void want(bool wanted, UdpConnection& link, std::int64_t now);
  /// The other end announces this address.
  void offer(const Address& address);
  /// An authenticated packet has come from this address.
  void on_heard(const Address& from) {
    if (wanted_) offer(from);
  }
  void on_answer(std::uint64_t token, UdpConnection& link, std::int64_t now);
  /// Sends due challenges.
  void poll(UdpConnection& link, const SendDatagram& send, const crypto::Random& random,
            std::int64_t now);

  /// Which paths the next datagram takes.
  bool uses_path() const { return state_ != State::Up; }
  bool uses_direct() const { return state_ == State::Up || state_ == State::Doubt; }
  const Address& address() const { return address_; }
  /// A packet that takes neither path was sealed before this number: its arrival proves nothing
  /// about this path.
  void exclude_before(std::uint64_t sequence) { first_ = std::max(first_, sequence); }
  /// Whether it is searching: the other end needs our address.
  bool searches() const { return wanted_ && state_ == State::Search; }
  /// Longest wait for a sign that packets arrive.
  std::int64_t patience() const {
    return std::clamp<std::int64_t>(2 * round_trip_ + 80'000'000, 120'000'000, 1'000'000'000);
  }

 private:
  enum class State : std::uint8_t { Search, Up, Doubt };
  struct Asked {
    std::uint64_t token = 0;
    Address address;
    std::int64_t at = 0;
    std::uint64_t sequence = 0;  // of the packet that was to be sent next
  };

  void ask(const Address& address, UdpConnection& link, const SendDatagram& send,
           const crypto::Random& random, std::int64_t now);
  void search(UdpConnection& link, const SendDatagram& send, const crypto::Random& random,
              std::int64_t now);
  void rise(UdpConnection& link, std::int64_t now);
  void fall(UdpConnection& link, std::int64_t now);
  void look_at_acknowledged(const UdpConnection& link);

  bool wanted_ = false;
  State state_ = State::Search;
  std::int64_t since_ = 0;  // of the state
  std::vector<Address> offered_;
  Address address_;  // the one that has answered
  int proofs_ = 0;   // its answers in a row
  int asks_ = 0;     // in this search
  std::int64_t ask_due_ = INT64_MIN;
  std::int64_t rest_ = kMinRest;
  std::array<Asked, 16> asked_{};
  std::size_t next_asked_ = 0;
  std::uint64_t first_ = 0;     // from this number on packets went this way alone
  std::uint64_t unproven_ = 0;  // from this number on arrival by this path is unproven
  std::int64_t round_trip_ = 0;
};

}  // namespace tandem::net
