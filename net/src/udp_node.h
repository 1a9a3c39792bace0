// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "address.h"
#include "clock_sync.h"
#include "handshake.h"
#include "tandem/consensus/transport.h"
#include "udp_dials.h"
#include "udp_node_options.h"
#include "udp_peers.h"
#include "udp_relay.h"

namespace tandem::net {

/// One process of a mesh without its socket: handshakes, connections, identities. Datagrams come
/// in, and go out by `send`; it never blocks and reads no clock. Times in ns.
///
/// Connected peers exchange addresses of third ones, so that one address is enough to meet all. A
/// peer unreachable for kRelayPatience is contacted through one that reaches it; such a connection
/// has its own keys, which the relay does not have.
class UdpNode {
 public:
  UdpNode(const UdpNodeOptions& options, const crypto::Random& random, SendDatagram send);
  UdpNode(const UdpNode&) = delete;
  UdpNode& operator=(const UdpNode&) = delete;

  /// Keep dialling until the peer there is connected.
  /// @param key  the session key to try first, see Credentials::key
  void dial(const Address& address, std::int64_t now, std::size_t key = 0) {
    dials_.add(address, now, key);
  }
  /// Stop dialling over this path, and end its connections.
  void hang_up(std::uint64_t path, const std::string& reason, std::int64_t now);
  /// False if the datagram was useless.
  bool on_datagram(std::span<const std::byte> datagram, const Address& from, std::int64_t now);
  /// The same for the DatagramPath with this number. Datagrams sent to its path_address() belong
  /// there.
  bool on_path(std::span<const std::byte> datagram, std::uint64_t number, std::int64_t now) {
    now_ = now;
    return receive(datagram, path_address(number), now);
  }
  /// Sends due datagrams; call at next_due() and after any other call.
  void poll(std::int64_t now);
  std::int64_t next_due(std::int64_t now);
  /// Say goodbye to all and accept no new connections. Done when connections() is 0.
  void leave(const std::string& reason, std::int64_t now);
  std::size_t connections() const { return peers_.connections().size(); }
  /// The table of peers, to query, and to set whom to prefer. Handshakes belong to this node.
  UdpPeers& table() { return peers_; }

  bool post(consensus::PeerId to, std::span<const std::byte> bytes, consensus::Delivery delivery,
            std::int64_t now) {
    return peers_.post(to, bytes, delivery, now);
  }
  void drain(std::vector<consensus::Packet>& out) { peers_.drain(clock_, out); }
  void drop(consensus::PeerId peer, const std::string& reason, std::int64_t now);
  std::vector<consensus::PeerStatus> peers() const {
    std::vector<consensus::PeerStatus> out;
    peers_.list(out);
    return out;
  }

  /// Bytes of the longest state that post() accepts for any peer, by the path MTUs known so far.
  std::size_t max_state_bytes() const;

  /// Apply a change signed by the organiser and forward it: revoked peers are told and disconnected
  /// at once.
  Credentials::Changed change_group(std::span<const std::byte> signed_change, std::int64_t now);
  /// Identity of this process and admission of others, with the organiser's changes so far (`group`
  /// is the number of the change in force; 0: none).
  const HandshakeConfig& credentials() const { return options_.handshake; }

  /// The connected peer `teller` announces a third one.
  void told(consensus::PeerId teller, const KnownPeer& known, std::int64_t now);
  /// The connected peer `relay` delivers a datagram of or for a third one.
  void passed_on(consensus::PeerId relay, const UdpConnection::Relayed& relayed, std::int64_t now);
  const UdpRelay& relay() const { return relay_; }
  /// The upper half of this node's receiver numbers.
  std::uint16_t receiver_prefix() const { return receiver_prefix_; }

  SessionTime session_now(std::int64_t now) { return clock_.now(now); }
  ClockStatus clock(std::int64_t now);
  /// With Clock::System: the system clock's lead.
  void set_correction(std::int64_t correction, std::int64_t now) {
    clock_.set_correction(correction, now);
  }
  /// `unknown`: datagrams with an unknown receiver number, or unauthenticated ones from another
  /// address than the peer's.
  UdpStrangers strangers() const {
    UdpStrangers out = responder_.counters();
    out.unknown = unknown_;
    return out;
  }
  std::uint64_t unknown() const { return unknown_; }
  /// Number of times that a peer was followed to another address.
  std::uint64_t moves() const { return moves_; }

 private:
  using Connection = UdpPeers::Connection;

  bool receive(std::span<const std::byte> datagram, const Address& from, std::int64_t now);
  bool on_packet(const ProtectedHeader& header, std::span<const std::byte> datagram,
                 const Address& from, std::int64_t now);
  std::uint32_t free_receiver();
  void attach(Connection& connection, std::int64_t now);

  UdpNodeOptions options_;
  crypto::Random random_;
  std::int64_t now_ = 0;  // of the current call
  ClockSync clock_;
  std::int64_t clock_due_ = INT64_MIN;
  UdpPeers peers_;
  UdpRelay relay_;
  SendDatagram transmit_;  // through a relay if needed
  UdpDials dials_;
  HandshakeResponder responder_;
  std::int64_t mesh_due_ = INT64_MIN;
  std::uint16_t receiver_prefix_ = 0;
  std::uint64_t unknown_ = 0;
  std::uint64_t moves_ = 0;
};

}  // namespace tandem::net
