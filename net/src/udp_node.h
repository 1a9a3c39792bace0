// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "address.h"
#include "handshake.h"
#include "tandem/consensus/transport.h"
#include "udp_connection.h"

namespace tandem::net {

struct UdpNodeOptions {
  HandshakeConfig handshake;
  UdpConnectionOptions connection;
  std::size_t max_peers = 64;
  std::int64_t backoff_min = 100'000'000;
  std::int64_t backoff_max = 3'000'000'000;
  std::int64_t drop_hold = 1'000'000'000;
};

/// One process of a mesh without its socket: handshakes, connections, who is who. Datagrams come
/// in, datagrams go out by `send`; nothing waits, nothing reads a clock. Times in ns.
///
/// Two connections to one peer: a larger incarnation wins; of one process the one that the lower id
/// began, then the newer one. Both ends decide alike.
class UdpNode {
 public:
  using Send = std::function<void(std::span<const std::byte>, const Address&)>;

  UdpNode(const UdpNodeOptions& options, const crypto::Random& random, Send send);
  UdpNode(const UdpNode&) = delete;
  UdpNode& operator=(const UdpNode&) = delete;

  /// Keep trying to have a connection to whoever is there.
  void dial(const Address& address, std::int64_t now);
  void on_datagram(std::span<const std::byte> datagram, const Address& from, std::int64_t now);
  /// Sends what is due; call at next_due() and after anything else.
  void poll(std::int64_t now);
  std::int64_t next_due(std::int64_t now);
  /// Say goodbye to all; no new connections. Done when connections() is 0.
  void leave(const std::string& reason, std::int64_t now);
  std::size_t connections() const { return connections_.size(); }
  /// Something reliable is still on its way.
  bool busy() const;

  bool post(consensus::PeerId to, std::span<const std::byte> bytes, consensus::Delivery delivery,
            std::int64_t now);
  void drain(std::vector<consensus::Packet>& out);
  void drop(consensus::PeerId peer, const std::string& reason, std::int64_t now);
  std::vector<consensus::PeerStatus> peers() const;
  const HandshakeResponder::Counters& strangers() const { return responder_.counters(); }
  /// Datagrams with a receiver number that nobody has, or from another address than its peer's.
  std::uint64_t unknown() const { return unknown_; }

 private:
  struct Dial {
    Address address;
    consensus::PeerId peer = 0;  // 0 until it has told
    std::unique_ptr<HandshakeInitiator> attempt;
    std::int64_t due = 0;
    std::int64_t backoff = 0;
  };
  struct Connection {
    std::unique_ptr<UdpConnection> link;
    Address address;
    bool began_here = false;
    bool attached = false;
  };
  struct Record {
    consensus::PeerStatus status;
    std::uint64_t incarnation = 0;
    std::uint32_t receiver = 0;  // of the attached connection; 0: none
    bool dropped = false;        // until it makes a handshake itself
    std::int64_t hold_until = INT64_MIN;
    std::vector<Channels::Message> inbox;  // of connections that are gone
  };

  std::size_t attached_count() const;
  Verdict decide(const Introduction& other, std::int64_t now) const;
  std::uint32_t free_receiver();
  void open(const Session& session, const Address& address, bool began_here, std::int64_t now);
  void attach(std::uint32_t receiver, std::int64_t now);
  void detach(Connection& connection);
  void poll_dial(Dial& dial, std::int64_t now);
  void finish(Dial& dial, std::int64_t now);
  Connection* attached(consensus::PeerId peer);

  UdpNodeOptions options_;
  crypto::Random random_;
  Send send_;
  std::int64_t now_ = 0;  // of the call that is running
  HandshakeResponder responder_;
  std::vector<Dial> dials_;
  std::map<std::uint32_t, Connection> connections_;
  std::map<consensus::PeerId, Record> records_;
  std::uint64_t unknown_ = 0;
  bool leaving_ = false;
};

}  // namespace tandem::net
