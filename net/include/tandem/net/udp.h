// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <system_error>
#include <vector>

#include "tandem/consensus/transport.h"
#include "tandem/net/clock.h"
#include "tandem/net/datagram_path.h"
#include "tandem/net/keys.h"
#include "tandem/net/membership.h"
#include "tandem/net/session.h"
#include "tandem/pbd/export.h"

namespace tandem::net {

class UdpTransport;

/// Options of one process in a session over UDP.
struct TANDEM_API UdpOptions {
  using Transport = UdpTransport;  ///< what they are options of

  consensus::PeerId self = 0;     ///< unique in the session, never 0
  std::uint64_t scene_hash = 0;   ///< peers with a different one are refused
  std::uint16_t listen_port = 0;  ///< one socket for all peers; 0 = a free one (local_port())
  std::string listen_address = "0.0.0.0";  ///< numeric; "::" for IPv6 and IPv4
  std::vector<HostPort> connect = {};  ///< one is enough; names are looked up until they are found

  Key session_key{};                 ///< the same for all members, not zero
  std::optional<Key> identity = {};  ///< secret of this peer; none = a new one
  std::vector<TrustedPeer> trusted =
      {};  ///< other peers; neither they nor an organiser: any member
  /// Public key of the organiser, whose certificates admit peers and who may change the group.
  std::optional<Key> organiser = {};
  std::vector<std::byte> certificate = {};  ///< of this peer, see sign(Certificate); with organiser

  double kbit_per_s = 256.0;     ///< budget of each link, IP and UDP headers counted
  double min_kbit_per_s = 32.0;  ///< lower bound under congestion; in (0, kbit_per_s]
  std::size_t max_datagram =
      1472;  ///< bytes of UDP payload, the most that is tried; in [548, 1472]
  std::size_t state_queue_bytes = 64 * 1024;       ///< per peer, >= 2048
  std::size_t reliable_queue_bytes = 1024 * 1024;  ///< per peer, >= 2 * max_message_bytes
  std::size_t receive_queue_bytes =
      4 * 1024 * 1024;                        ///< per peer and kind, >= 2 * max_message_bytes
  std::size_t max_message_bytes = 64 * 1024;  ///< of a Reliable one, in [64, 1 MiB]
  std::size_t max_peers = 64;                 ///< in [1, 1024]
  Clock clock = Clock::Session;               ///< source of session_now()
  bool kernel_filter = true;  ///< lets the kernel drop junk by its first bytes, if it can
  bool relay = true;  ///< forward for peers without a route to each other, and be forwarded for

  std::chrono::milliseconds idle_timeout{5000};  ///< silence before it is cut; >= 40 ms
  std::chrono::milliseconds backoff_min{100};    ///< before the first redial; > 0
  std::chrono::milliseconds backoff_max{3000};   ///< doubled up to here
  std::chrono::milliseconds drop_hold{1000};     ///< time for which a dropped peer is refused
  std::chrono::milliseconds flush_timeout{250};  ///< for the destructor, in [0, 10 s]
  std::uint64_t incarnation = 0;                 ///< as TcpOptions::incarnation

  /// Throws std::invalid_argument that says what the field must be and what it is.
  void validate() const;
};

/// Handshakes of strangers, and datagrams without a connection.
struct TANDEM_API UdpStrangers {
  std::uint64_t malformed = 0;
  std::uint64_t limited = 0;     ///< over the rate
  std::uint64_t challenged = 0;  ///< asked to prove their address
  std::uint64_t bad_cookie = 0;  ///< failed to prove it
  std::uint64_t bad_proof = 0;   ///< without the session key
  std::uint64_t refused = 0;     ///< members, but wrong scene, id or key; full; on hold
  std::uint64_t unknown = 0;     ///< packets without a connection
};

/// State of one entry of UdpOptions::connect.
struct TANDEM_API UdpLookup {
  HostPort address = {};
  bool found = false;          ///< and dialled since; not looked up again
  std::uint64_t attempts = 0;  ///< backoff_max apart
  std::string reason = {};     ///< why the last one failed; empty if found
};

/// Datagrams forwarded for peers without a route to each other, sealed with keys that this peer
/// does not have.
struct TANDEM_API UdpRelayed {
  std::uint64_t forwarded = 0;
  std::uint64_t refused = 0;  ///< no route, over the budget of a link, or not wanted
};

/// Mesh over UDP, encrypted and authenticated; see docs/protocol.md. Only in builds with libsodium.
///
/// - Newest: one packet each, at most max_packet_bytes(): initially 1154, then as much as the paths
/// to all peers were found to carry, less 46; post() refuses longer ones. Sent within the budget;
/// after 200 ms of waiting a state is dropped.
/// - Reliable: in order, in pieces, resent until acknowledged, delivered once. Messages that a
/// broken connection had not delivered continue when the same process comes back; a restarted
/// process starts empty.
/// - Members exchange the addresses of third peers: one known address is enough. Peers without a
/// route to each other go through one that has both.
///
/// Its own thread does all network work. post, drain, drop and the readers take a short lock and
/// never block on the network.
/// @par Thread safety  Distinct objects: safe. One object: one thread at a time.
class TANDEM_API UdpTransport final : public consensus::Transport {
 public:
  /// Throws std::invalid_argument (UdpOptions::validate) or std::system_error naming the address
  /// that cannot be bound and why.
  explicit UdpTransport(const UdpOptions& options);
  ~UdpTransport() override;
  UdpTransport(const UdpTransport&) = delete;
  UdpTransport& operator=(const UdpTransport&) = delete;

  /// Dial over a path as for UdpOptions::connect: handshake, keys and rights are the same. Both
  /// ends call it. The path is kept until disconnect() or the end of this transport.
  /// @throws std::invalid_argument if it is null
  void connect(std::shared_ptr<DatagramPath> path);
  /// Stop dialling over a path, end the connections over it, and release it: with it a path of one
  /// meeting (tandem::ice) ends. No effect for a path that is not connected.
  void disconnect(const DatagramPath& path);

  consensus::PeerId self() const override;
  bool post(consensus::PeerId to, std::span<const std::byte> bytes,
            consensus::Delivery delivery) override;
  std::size_t max_packet_bytes(consensus::Delivery delivery) const override;
  /// By peer id, each peer's in order of arrival.
  void drain(std::vector<consensus::Packet>& out) override;
  void drop(consensus::PeerId peer, const std::string& reason) override;
  std::vector<consensus::PeerStatus> peers() const override;
  void list_peers(std::vector<consensus::PeerStatus>& out) const override;

  /// Apply a change signed by the organiser, see GroupChange, and forward it to all members. False
  /// if the signature is not the organiser's, or the change is known.
  bool change_group(std::span<const std::byte> signed_change);
  /// Number of the change in force, from any sender; 0 = none.
  std::uint64_t group() const;

  /// The time for consensus::Peer and PhysicsClock. It starts as the system clock, runs alone
  /// without peers, and takes over the time of a session that it joins: a step, which PhysicsClock
  /// makes a skip. Once clock().synchronised it never steps.
  SessionTime session_now() const;
  /// session_now() with its accuracy.
  ClockStatus clock() const;

  std::uint16_t local_port() const;
  /// In the order of UdpOptions::connect.
  std::vector<UdpLookup> lookups() const;
  UdpStrangers strangers() const;
  UdpRelayed relayed() const;
  /// The peer that forwards packets to `peer`; 0 = direct, or not connected.
  consensus::PeerId relay_of(consensus::PeerId peer) const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tandem::net
