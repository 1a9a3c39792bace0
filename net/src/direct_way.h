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

/// Random, never 0 (kNoToken): whoever says it has received it.
std::uint64_t random_token(const crypto::Random& random);

/// A way from socket to socket, beside the path by which a connection was made (a server's). Both
/// carry datagrams of the one connection, under the same keys and numbers: what comes by both is
/// opened once. The other end is asked where it says that it is; after kProofs answers all goes
/// this way alone. Where a packet and all after it are not acknowledged for patience() all goes by
/// both until an answer comes, or for kDoubt. After each failure it is left alone for longer. Times
/// in ns.
class DirectWay {
 public:
  static constexpr std::size_t kMaxOffered = 4;           ///< addresses; the oldest goes
  static constexpr int kProofs = 3;                       ///< answers from one address in a row
  static constexpr int kAsks = 6;                         ///< of a search
  static constexpr std::int64_t kAskEvery = 100'000'000;  ///< ns
  static constexpr std::int64_t kDoubt = 1'000'000'000;
  static constexpr std::int64_t kMinRest = 1'000'000'000;
  static constexpr std::int64_t kMaxRest = 16'000'000'000;
  static constexpr std::int64_t kSteady = 30'000'000'000;  ///< after it failures are forgotten

  /// Whether it is to be gone where it can be.
  void want(bool wanted, UdpConnection& link, std::int64_t now);
  /// The other end says that it is there.
  void offer(const Address& address);
  /// A packet of the other end, opened, has come from there.
  void on_heard(const Address& from) {
    if (wanted_) offer(from);
  }
  void on_answer(std::uint64_t token, UdpConnection& link, std::int64_t now);
  /// Sends what is to be asked.
  void poll(UdpConnection& link, const SendDatagram& send, const crypto::Random& random,
            std::int64_t now);

  /// By which of the two the next datagram goes.
  bool uses_path() const { return state_ != State::Up; }
  bool uses_direct() const { return state_ == State::Up || state_ == State::Doubt; }
  const Address& address() const { return address_; }
  /// A packet that goes to none of the two was sealed before this number: that it comes says
  /// nothing of this way.
  void exclude_before(std::uint64_t sequence) { first_ = std::max(first_, sequence); }
  /// It is looked for: the other end is to be told where this one is.
  bool searches() const { return wanted_ && state_ == State::Search; }
  /// How long it may stay out that something has come.
  std::int64_t patience() const {
    return std::clamp<std::int64_t>(2 * round_trip_ + 80'000'000, 120'000'000, 1'000'000'000);
  }

 private:
  enum class State : std::uint8_t { Search, Up, Doubt };
  struct Asked {
    std::uint64_t token = 0;
    Address address;
    std::int64_t at = 0;
    std::uint64_t sequence = 0;  // of the packet that was to come next
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
  Address address_;  // that has answered
  int proofs_ = 0;   // of it
  int asks_ = 0;     // of this search
  std::int64_t ask_due_ = INT64_MIN;
  std::int64_t rest_ = kMinRest;
  std::array<Asked, 16> asked_{};
  std::size_t next_asked_ = 0;
  std::uint64_t first_ = 0;     // packets from this number on went this way alone
  std::uint64_t unproven_ = 0;  // whether those from this number on have come this way is not known
  std::int64_t round_trip_ = 0;
};

}  // namespace tandem::net
