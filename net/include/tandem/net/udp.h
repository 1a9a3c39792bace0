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

/// What one process brings to a session over UDP.
struct TANDEM_API UdpOptions {
  using Transport = UdpTransport;  ///< what they are options of

  consensus::PeerId self = 0;     ///< unique in the session, never 0
  std::uint64_t scene_hash = 0;   ///< peers with another one are refused
  std::uint16_t listen_port = 0;  ///< one socket for all; 0 takes a free one (local_port())
  std::string listen_address = "0.0.0.0";  ///< numeric; "::" for IPv6 and IPv4
  std::vector<HostPort> connect = {};  ///< one is enough; names are looked up until they are found

  Key session_key{};                 ///< the same for all members, not zero
  std::optional<Key> identity = {};  ///< secret of this peer; none: a new one
  std::vector<TrustedPeer> trusted =
      {};  ///< other peers; neither they nor an organiser: any member
  /// Whose certificates let others in, and who may change the group: his public key.
  std::optional<Key> organiser = {};
  std::vector<std::byte> certificate = {};  ///< of this peer, see sign(Certificate); with organiser

  double kbit_per_s = 256.0;     ///< budget of each link, IP and UDP headers counted
  double min_kbit_per_s = 32.0;  ///< congestion does not go below; in (0, kbit_per_s]
  std::size_t max_datagram =
      1472;  ///< bytes of UDP payload, the most that is tried; in [548, 1472]
  std::size_t state_queue_bytes = 64 * 1024;       ///< per peer, >= 2048
  std::size_t reliable_queue_bytes = 1024 * 1024;  ///< per peer, >= 2 * max_message_bytes
  std::size_t receive_queue_bytes =
      4 * 1024 * 1024;                        ///< per peer and kind, >= 2 * max_message_bytes
  std::size_t max_message_bytes = 64 * 1024;  ///< of a Reliable one, in [64, 1 MiB]
  std::size_t max_peers = 64;                 ///< in [1, 1024]
  Clock clock = Clock::Session;               ///< what session_now() goes by
  bool kernel_filter = true;  ///< let the kernel drop junk by its first bytes, where it can
  bool relay = true;  ///< pass on for peers that do not reach each other, and be passed on for

  std::chrono::milliseconds idle_timeout{5000};  ///< nothing heard for so long: cut; >= 40 ms
  std::chrono::milliseconds backoff_min{100};    ///< before the first redial; > 0
  std::chrono::milliseconds backoff_max{3000};   ///< doubled up to here
  std::chrono::milliseconds drop_hold{1000};     ///< a dropped peer is refused for so long
  std::chrono::milliseconds flush_timeout{250};  ///< destructor's patience, in [0, 10 s]
  std::uint64_t incarnation = 0;                 ///< as TcpOptions::incarnation

  /// Throws std::invalid_argument that says what the field must be and what it is.
  void validate() const;
};

/// Strangers, and datagrams that belong to nobody.
struct TANDEM_API UdpStrangers {
  std::uint64_t malformed = 0;
  std::uint64_t limited = 0;     ///< over the rate
  std::uint64_t challenged = 0;  ///< asked to prove their address
  std::uint64_t bad_cookie = 0;  ///< did not
  std::uint64_t bad_proof = 0;   ///< do not have the session key
  std::uint64_t refused = 0;     ///< members, but wrong scene, id or key; full; on hold
  std::uint64_t unknown = 0;     ///< packets of no connection
};

/// What has become of one of UdpOptions::connect.
struct TANDEM_API UdpLookup {
  HostPort address = {};
  bool found = false;          ///< and dialled since; it is not looked up again
  std::uint64_t attempts = 0;  ///< backoff_max apart
  std::string reason = {};     ///< why the last one failed; empty where found
};

/// What was passed on for peers that have no route to each other: whole datagrams, sealed with keys
/// that this peer does not have.
struct TANDEM_API UdpRelayed {
  std::uint64_t forwarded = 0;
  std::uint64_t refused = 0;  ///< no way there, over the budget of a link, or not wanted
};

/// Mesh over UDP, encrypted and authenticated; docs/protocol.md says how. Only in builds that have
/// found libsodium.
///
/// - Newest: one packet each, at most max_packet_bytes(): 1154 to begin with, then as much as the
///   ways to all peers were found to carry, less 46; post() refuses longer ones. Sent
///   within the budget; what waits longer than 200 ms is dropped.
/// - Reliable: in order, cut into pieces, sent again until acknowledged, each once. What a broken
///   connection had not delivered goes on where the same process comes back; a restarted one starts
///   empty.
/// - Members tell each other the addresses of third ones: one that is reached is enough. Peers that
///   do not reach each other go through one that reaches both.
///
/// One thread of its own does all network work. post, drain, drop and the readers take a short lock
/// and never wait for the network.
/// @par Thread safety  Distinct objects: safe. One object: one thread at a time.
class TANDEM_API UdpTransport final : public consensus::Transport {
 public:
  /// Throws std::invalid_argument (UdpOptions::validate) or std::system_error saying what cannot be
  /// bound and why.
  explicit UdpTransport(const UdpOptions& options);
  ~UdpTransport() override;
  UdpTransport(const UdpTransport&) = delete;
  UdpTransport& operator=(const UdpTransport&) = delete;

  /// Dial over a path as one of UdpOptions::connect, for good: handshake, keys and rights are the
  /// same. Both ends do. It is kept until disconnect(), or until this transport is gone.
  /// @throws std::invalid_argument null
  void connect(std::shared_ptr<DatagramPath> path);
  /// Dial over it no more, end what is connected over it, and keep it no longer: a path that is of
  /// one meeting (tandem::ice) goes with it. One that connect() was not given: nothing.
  void disconnect(const DatagramPath& path);

  consensus::PeerId self() const override;
  bool post(consensus::PeerId to, std::span<const std::byte> bytes,
            consensus::Delivery delivery) override;
  std::size_t max_packet_bytes(consensus::Delivery delivery) const override;
  /// Ordered by peer id, within one peer as they came.
  void drain(std::vector<consensus::Packet>& out) override;
  void drop(consensus::PeerId peer, const std::string& reason) override;
  std::vector<consensus::PeerStatus> peers() const override;
  void list_peers(std::vector<consensus::PeerStatus>& out) const override;

  /// Take over what the organiser has signed, see GroupChange, and pass it on to all members. False
  /// where it is not his, or no news.
  bool change_group(std::span<const std::byte> signed_change);
  /// Number of the change that holds, from whomever it came; 0: none.
  std::uint64_t group() const;

  /// The time to give to consensus::Peer and PhysicsClock. It goes on alone where nobody is there,
  /// starts as the system clock, and takes over the time of a session that it joins: a step then,
  /// of which PhysicsClock makes a skip. Once clock().synchronised it never steps.
  SessionTime session_now() const;
  /// The same with how well it is known.
  ClockStatus clock() const;

  std::uint16_t local_port() const;
  /// In the order of UdpOptions::connect.
  std::vector<UdpLookup> lookups() const;
  UdpStrangers strangers() const;
  UdpRelayed relayed() const;
  /// Through whom packets to `peer` go; 0: straight there, or nowhere.
  consensus::PeerId relay_of(consensus::PeerId peer) const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tandem::net
