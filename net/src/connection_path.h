// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "crypto.h"
#include "direct_way.h"
#include "path_validation.h"
#include "udp_node_options.h"

namespace tandem::net {

/// Where the other end of a connection is, and how it is followed to another address while the
/// connection goes on. A way through a relay is a connection of its own, made with proofs of its
/// own: from and to there nobody is followed. Times in ns.
class ConnectionPath {
 public:
  ConnectionPath(UdpConnection& link, const Address& address) : link_(&link), address_(address) {}

  const Address& address() const { return address_; }
  /// It is there, or may have moved there.
  bool may_be_at(const Address& address) const {
    return address == address_ || may_move_to(address);
  }

  /// It is not followed from here; what comes from elsewhere has come by the way from socket to
  /// socket.
  void add_direct() { direct_.emplace(); }
  /// Null where there is none.
  DirectWay* direct() { return direct_ ? &*direct_ : nullptr; }
  /// The other end is there, as far as is known.
  bool is_known(const Address& from) const {
    return from == address_ || (direct_ && from == direct_->address());
  }
  /// What comes from there is no sign of a move.
  bool is_at(const Address& from) const { return from == address_ || direct_.has_value(); }
  /// Sends a datagram of the connection to its other end.
  void send(std::span<const std::byte> datagram, const SendDatagram& send);

  /// A packet with this number has come from address(). It may be a copy.
  void refute(std::uint64_t sequence) {
    if (moving_ && moving_->refuted_by(sequence)) moving_.reset();
  }
  /// A packet of the other end, opened and not read yet, has come from elsewhere.
  void on_elsewhere(const Address& from, std::uint64_t sequence, std::size_t bytes,
                    const crypto::Random& random, std::int64_t now);
  /// What a packet that was read asks about the way on which it came, or answers.
  void on_read(const Address& from, const SendDatagram& send, std::int64_t now);
  /// A third peer says that it is there.
  void on_rumour(const Address& to, std::int64_t now);
  /// Sends what is due. True where the peer is followed: address() is another one now.
  [[nodiscard]] bool poll(const SendDatagram& send, const crypto::Random& random, std::int64_t now);
  /// When poll() may do something, if nothing comes before.
  std::int64_t next_due(std::int64_t now) const;

 private:
  bool may_move_to(const Address& address) const;
  void poll_rumour(const SendDatagram& send, std::int64_t now);
  void follow(std::int64_t now);
  /// How long an original may come after a copy of it that took another way.
  std::int64_t patience() const { return link_->channels().rtt().timeout(); }

  UdpConnection* link_;
  Address address_;
  std::optional<PathValidation> moving_;  // packets come from another address
  std::optional<PathRumour> rumour_;      // others say that it is elsewhere
  std::optional<DirectWay> direct_;
  std::int64_t question_due_ = INT64_MIN;  // who copies packets does not make us ask all the time
};

}  // namespace tandem::net
