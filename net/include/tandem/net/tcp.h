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
#include <vector>

#include "tandem/consensus/transport.h"
#include "tandem/net/keys.h"
#include "tandem/net/membership.h"
#include "tandem/net/session.h"
#include "tandem/pbd/export.h"

namespace tandem::net {

using consensus::PeerId;

class TcpTransport;

/// Options of one process in a session over TCP. Queue sizes count 64 bytes per frame beyond its
/// payload, so that tiny frames are bounded too.
struct TANDEM_API TcpOptions {
  using Transport = TcpTransport;  ///< what they are options of

  PeerId self = 0;               ///< unique in the session, never 0
  std::uint64_t scene_hash = 0;  ///< peers with a different one are refused
  /// Port on which peers are accepted; 0 = a free one (local_port()); none = this peer only dials.
  std::optional<std::uint16_t> listen_port = {};
  std::string listen_address = "0.0.0.0";  ///< numeric; "::" for IPv6 and IPv4
  /// Peers to dial. One is enough: it sends the addresses of the others. Host names are looked up
  /// by the system, whose time-out may then delay the destructor.
  std::vector<HostPort> connect = {};

  /// The same for all members, not zero: frames are encrypted and authenticated. None: they are in
  /// the clear, and all addresses must be loopback ones unless `insecure` is set.
  std::optional<Key> session_key = {};
  std::optional<Key> identity = {};  ///< secret of this peer, with session_key; none = a new one
  /// Accepted peers. With neither these nor an organiser: any member.
  std::vector<TrustedPeer> trusted = {};
  /// Public key of the organiser, whose certificates admit peers and who may change the group.
  std::optional<Key> organiser = {};
  std::vector<std::byte> certificate = {};  ///< of this peer, see sign(Certificate); with organiser
  bool insecure = false;  ///< frames in the clear over any network, without session_key

  std::uint32_t max_message_bytes = 64 * 1024;        ///< longest payload, in [64, 16 MiB]
  std::size_t send_queue_bytes = 1024 * 1024;         ///< per peer, >= 2 * max_message_bytes
  std::size_t receive_queue_bytes = 4 * 1024 * 1024;  ///< per peer, >= 2 * max_message_bytes
  std::size_t max_peers = 64;                         ///< connected at once, in [1, 1024]
  /// Kernel send buffer. It should be small, as data in it can no longer be replaced by a newer
  /// state; but less than delay * bandwidth of the path limits the throughput.
  std::size_t socket_buffer_bytes = 256 * 1024;  ///< in [4096, 64 MiB]

  std::chrono::milliseconds handshake_timeout{3000};  ///< from accepted to peer; > 0
  std::chrono::milliseconds idle_timeout{5000};       ///< silence before a connection is cut; > 0
  std::chrono::milliseconds backoff_min{100};         ///< before the first redial; > 0
  std::chrono::milliseconds backoff_max{3000};        ///< doubled up to here, >= backoff_min
  std::chrono::milliseconds drop_hold{1000};     ///< time for which a dropped peer is refused; >= 0
  std::chrono::milliseconds flush_timeout{250};  ///< for the destructor, in [0, 10 s]
  /// Orders restarts of one peer: peers that have seen a larger one refuse this one. 0: system
  /// clock, ns.
  std::uint64_t incarnation = 0;

  /// Throws std::invalid_argument that says what the field must be and what it is.
  void validate() const;
};

/// A dialled address, whether its peer is known yet or not.
struct TANDEM_API DialStatus {
  HostPort address = {};
  PeerId peer = 0;             ///< 0 until it has told its id
  bool connected = false;      ///< whether its peer is connected
  std::uint64_t attempts = 0;  ///< dials since it was connected for longer than backoff_max
  std::string reason = {};     ///< why the last attempt failed; empty if none has
};

/// Connections that did not become a peer's, or failed.
struct TANDEM_API StrangerStatus {
  std::uint64_t accepted = 0;   ///< inbound connections, good ones included
  std::uint64_t refused = 0;    ///< wrong version, scene, id; session full; dropped peer on hold
  std::uint64_t malformed = 0;  ///< bytes that are not a handshake
  std::uint64_t timed_out = 0;  ///< handshake not completed in time
  std::uint64_t limited = 0;    ///< over the rate of an address, with a session key
  std::uint64_t bad_proof = 0;  ///< without the session key
  /// Frames not sealed by the other end for this place in the stream: forged, changed, repeated,
  /// out of order. Each has ended its connection, which may have been a peer's.
  std::uint64_t forged = 0;
  std::string last_reason = {};  ///< of the latest of them
};

/// Full mesh over TCP: every process accepts and dials, learns the others' addresses from any peer
/// that it is connected to, keeps exactly one connection to each, and redials with back-off,
/// without a limit.
///
/// - Frames carry a length prefix, checked before anything is allocated or kept.
/// - Newest: a full queue drops the oldest state, counted in dropped_queue_full.
/// - Reliable: numbered and acknowledged. Messages lost with a connection are sent again when the
/// same process is back, once and in order. If dropping states does not make room, the connection
/// is cut with a reason and set up again. A restarted process starts empty.
/// - Two connections to one peer: the lower id decides and the newest handshake wins, so that a
/// half-dead connection never blocks its successor.
/// - A peer restarted with the same id (a larger incarnation) takes over at once; from then on the
/// older process is refused.
/// - Packet::received is by the system clock; round trips are not measured.
/// - With a session key each connection begins with a key exchange, and each frame is encrypted and
/// authenticated; see docs/protocol.md. Without one, bytes are in the clear: for this machine, or a
/// trusted network or tunnel with `insecure`.
/// - A member may make this process dial addresses of its choice (loopback ones without key and
/// `insecure`).
///
/// Its own thread does all network work. post, drain, drop and the readers take a short lock and
/// never block on the network. The destructor tries for flush_timeout to send queued Reliable
/// messages, then closes; no thread or descriptor is left.
/// @par Thread safety  Distinct objects: safe. One object: one thread at a time.
class TANDEM_API TcpTransport final : public consensus::Transport {
 public:
  /// Throws std::invalid_argument (TcpOptions::validate) or std::system_error naming the address
  /// that cannot be listened on and why.
  explicit TcpTransport(const TcpOptions& options);
  ~TcpTransport() override;
  TcpTransport(const TcpTransport&) = delete;
  TcpTransport& operator=(const TcpTransport&) = delete;

  PeerId self() const override;
  /// @see consensus::Transport::post. A message refused by a full queue counts in
  /// dropped_queue_full.
  bool post(PeerId to, std::span<const std::byte> bytes, consensus::Delivery delivery) override;
  /// By peer id, each peer's in order of arrival. Appends whole packets, frees the queues.
  void drain(std::vector<consensus::Packet>& out) override;
  /// Cuts the connection, tells the peer why, discards its packets that were not drained. It is not
  /// dialled again, and refused for drop_hold; then its own handshake brings it back.
  void drop(PeerId peer, const std::string& reason) override;
  std::vector<consensus::PeerStatus> peers() const override;

  /// As UdpTransport::change_group; done once group() returns its number.
  void change_group(std::span<const std::byte> signed_change);
  /// Number of the change in force, from any sender; 0 = none.
  std::uint64_t group() const;

  std::vector<DialStatus> dials() const;
  StrangerStatus strangers() const;
  /// The listening port, 0 if there is none.
  std::uint16_t local_port() const;
  /// Changes when that peer is a new process; 0 if it was never connected.
  std::uint64_t incarnation(PeerId peer) const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tandem::net
