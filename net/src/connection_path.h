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

/// The address of the other end of a connection, followed when it changes. A relayed path is a
/// separate connection with its own proofs: it is never followed from or to. Times in ns.
class ConnectionPath {
 public:
  ConnectionPath(UdpConnection& link, const Address& address) : link_(&link), address_(address) {}

  const Address& address() const { return address_; }
  /// Whether the other end is at this address, or may have moved there.
  bool may_be_at(const Address& address) const {
    return address == address_ || may_move_to(address);
  }

  /// Do not follow moves from this address: packets from elsewhere have come by the direct path
  /// between sockets.
  void add_direct() { direct_.emplace(); }
  /// Null if there is none.
  DirectWay* direct() { return direct_ ? &*direct_ : nullptr; }
  /// Whether the other end is known to be there.
  bool is_known(const Address& from) const {
    return from == address_ || (direct_ && from == direct_->address());
  }
  /// Whether packets from there are no sign of a move.
  bool is_at(const Address& from) const { return from == address_ || direct_.has_value(); }
  /// Sends a datagram of the connection to its other end.
  void send(std::span<const std::byte> datagram, const SendDatagram& send);

  /// A packet with this number, maybe a copy, has come from address().
  void refute(std::uint64_t sequence) {
    if (moving_ && moving_->refuted_by(sequence)) moving_.reset();
  }
  /// A packet, opened and not read yet, has come from elsewhere.
  void on_elsewhere(const Address& from, std::uint64_t sequence, std::size_t bytes,
                    const crypto::Random& random, std::int64_t now);
  /// Handle a challenge or answer of the packet just read, on the path that it came by.
  void on_read(const Address& from, const SendDatagram& send, std::int64_t now);
  /// A third peer claims that it is there.
  void on_rumour(const Address& to, std::int64_t now);
  /// Sends what is due. True if the peer has moved: address() has changed.
  [[nodiscard]] bool poll(const SendDatagram& send, const crypto::Random& random, std::int64_t now);
  /// Time of the next action of poll(), if nothing comes before.
  std::int64_t next_due(std::int64_t now) const;

 private:
  bool may_move_to(const Address& address) const;
  void poll_rumour(const SendDatagram& send, std::int64_t now);
  void follow(std::int64_t now);
  /// Longest delay of an original after its copy on another path.
  std::int64_t patience() const { return link_->channels().rtt().timeout(); }

  UdpConnection* link_;
  Address address_;
  std::optional<PathValidation> moving_;  // packets come from another address
  std::optional<PathRumour> rumour_;      // third peers claim another address
  std::optional<DirectWay> direct_;
  std::int64_t question_due_ = INT64_MIN;  // limits the challenges that copied packets can cause
};

}  // namespace tandem::net
