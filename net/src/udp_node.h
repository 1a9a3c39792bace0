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

/// One process of a mesh without its socket: handshakes, connections, who is who. Datagrams come
/// in, datagrams go out by `send`; nothing waits, nothing reads a clock. Times in ns.
///
/// Connected peers tell each other where the third ones are, so that one address is enough to meet
/// all. Who cannot be reached for kRelayPatience is asked through one that can; a connection made
/// that way has keys of its own, which the relay does not have.
class UdpNode {
 public:
  UdpNode(const UdpNodeOptions& options, const crypto::Random& random, SendDatagram send);
  UdpNode(const UdpNode&) = delete;
  UdpNode& operator=(const UdpNode&) = delete;

  /// Keep trying to have a connection to whoever is there.
  /// @param key  which session key is tried first, see Credentials::key
  void dial(const Address& address, std::int64_t now, std::size_t key = 0) {
    dials_.add(address, now, key);
  }
  /// Dial no more by this path, and end what goes over it.
  void hang_up(std::uint64_t path, const std::string& reason, std::int64_t now);
  /// False where it was of no use to anybody.
  bool on_datagram(std::span<const std::byte> datagram, const Address& from, std::int64_t now);
  /// The same of what came by the DatagramPath with this number. What is sent to path_address() of
  /// it is to go there.
  bool on_path(std::span<const std::byte> datagram, std::uint64_t number, std::int64_t now) {
    now_ = now;
    return receive(datagram, path_address(number), now);
  }
  /// Sends what is due; call at next_due() and after anything else.
  void poll(std::int64_t now);
  std::int64_t next_due(std::int64_t now);
  /// Say goodbye to all; no new connections. Done when connections() is 0.
  void leave(const std::string& reason, std::int64_t now);
  std::size_t connections() const { return peers_.connections().size(); }
  /// Who is connected, and how: to be asked, and told whom to prefer. Handshakes are this node's.
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

  /// Bytes of the longest state that post() takes to any peer, as far as is known of the ways
  /// there.
  std::size_t max_state_bytes() const;

  /// Take over what the organiser has signed and pass it on: whoever is revoked is told so and cut
  /// off at once.
  Credentials::Changed change_group(std::span<const std::byte> signed_change, std::int64_t now);
  /// Who this is and whom it lets in, with all that the organiser has said since (`group` is the
  /// number of his change that holds; 0: none).
  const HandshakeConfig& credentials() const { return options_.handshake; }

  /// The connected peer `teller` says where a third one is.
  void told(consensus::PeerId teller, const KnownPeer& known, std::int64_t now);
  /// The connected peer `relay` hands over a datagram of or for a third one.
  void passed_on(consensus::PeerId relay, const UdpConnection::Relayed& relayed, std::int64_t now);
  const UdpRelay& relay() const { return relay_; }
  /// The upper half of all receiver numbers that this node gives out.
  std::uint16_t receiver_prefix() const { return receiver_prefix_; }

  SessionTime session_now(std::int64_t now) { return clock_.now(now); }
  ClockStatus clock(std::int64_t now);
  /// With Clock::System: what that is ahead.
  void set_correction(std::int64_t correction, std::int64_t now) {
    clock_.set_correction(correction, now);
  }
  /// `unknown`: datagrams with a receiver number that nobody has, or from another address than its
  /// peer's that it has not sealed.
  UdpStrangers strangers() const {
    UdpStrangers out = responder_.counters();
    out.unknown = unknown_;
    return out;
  }
  std::uint64_t unknown() const { return unknown_; }
  /// How often a peer was followed to another address.
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
  std::int64_t now_ = 0;  // of the call that is running
  ClockSync clock_;
  std::int64_t clock_due_ = INT64_MIN;
  UdpPeers peers_;
  UdpRelay relay_;
  SendDatagram transmit_;  // by a relay where need be
  UdpDials dials_;
  HandshakeResponder responder_;
  std::int64_t mesh_due_ = INT64_MIN;
  std::uint16_t receiver_prefix_ = 0;
  std::uint64_t unknown_ = 0;
  std::uint64_t moves_ = 0;
};

}  // namespace tandem::net
