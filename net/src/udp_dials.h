// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "channel_wire.h"
#include "crypto.h"
#include "handshake.h"
#include "udp_peers.h"

namespace tandem::net {

/// Addresses that a node dials, and their handshakes. Times in ns.
class UdpDials {
 public:
  using PeerId = consensus::PeerId;

  /// Callbacks into the node.
  struct Hooks {
    HandshakeResponder::NextReceiver next_receiver;
    SendDatagram send;
    std::function<void(const Session&, const Address&)> established;
  };

  UdpDials(const UdpNodeOptions& options, const crypto::Random& random, UdpPeers& peers,
           Hooks hooks)
      : options_(options), random_(random), peers_(peers), hooks_(std::move(hooks)) {}

  /// Keep dialling until the peer there is connected.
  void add(const Address& address, std::int64_t now, std::size_t key) {
    if (std::ranges::find(dials_, address, &Dial::address) != dials_.end()) return;
    dials_.push_back(
        {.address = address, .due = now, .backoff = options_.backoff_min, .attempts = key});
  }
  /// Stop dialling.
  void remove(const Address& address) {
    std::erase_if(dials_, [&](const Dial& dial) { return dial.address == address; });
  }
  /// An address announced by the connected peer `teller`, until the announcements end.
  void add_told(const KnownPeer& known, PeerId teller, std::int64_t now);
  /// A peer that can be reached through others only.
  void add_relayed(PeerId peer, std::int64_t now);
  void forget_told(std::int64_t now);

  /// A responder's answer.
  void on_datagram(std::span<const std::byte> datagram, const Address& from, std::int64_t now);
  /// Sends due datagrams.
  void poll(std::int64_t now);
  std::int64_t next_due(std::int64_t now) const;
  /// The peer has a connection, to this address.
  void on_attached(PeerId peer, const Address& address);
  /// The session key has changed: handshakes begin again.
  void on_group_change();
  /// Whether a handshake in progress uses this number.
  bool has_promised(std::uint32_t receiver) const;

 private:
  struct Dial {
    Address address;
    PeerId peer = 0;  // 0 until known
    std::unique_ptr<HandshakeInitiator> attempt;
    std::int64_t due = 0;
    std::int64_t backoff = 0;
    std::size_t attempts = 0;
    PeerId told_by = 0;  // 0: by the application
    std::int64_t told_at = 0;
  };

  bool is_wanted(const Dial& dial) const;
  void poll(Dial& dial, std::int64_t now);
  void finish(Dial& dial, std::int64_t now);

  const UdpNodeOptions& options_;
  const crypto::Random& random_;
  UdpPeers& peers_;
  Hooks hooks_;
  std::vector<Dial> dials_;
};

}  // namespace tandem::net
