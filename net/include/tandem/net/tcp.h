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

/// What one process brings to a session over TCP. Queue sizes count each frame with 64 bytes more
/// than its payload, so that many tiny frames are bounded as well.
struct TANDEM_API TcpOptions {
  using Transport = TcpTransport;  ///< what they are options of

  PeerId self = 0;               ///< unique in the session, never 0
  std::uint64_t scene_hash = 0;  ///< peers with another one are refused
  /// Port to accept peers on; 0 takes a free one (local_port()); none: this peer only dials.
  std::optional<std::uint16_t> listen_port = {};
  std::string listen_address = "0.0.0.0";  ///< numeric; "::" for IPv6 and IPv4
  /// Peers to dial. One is enough: it tells the addresses of the others. Names (not addresses) are
  /// looked up by the system, whose time-out may then delay the destructor.
  std::vector<HostPort> connect = {};

  /// The same for all members, not zero: frames are encrypted and authenticated. None: they are in
  /// the clear, and all addresses must be loopback ones unless `insecure` says otherwise.
  std::optional<Key> session_key = {};
  std::optional<Key> identity = {};  ///< secret of this peer, with session_key; none: a new one
  /// Other peers; neither they nor an organiser: any member.
  std::vector<TrustedPeer> trusted = {};
  /// Whose certificates let others in, and who may change the group: his public key.
  std::optional<Key> organiser = {};
  std::vector<std::byte> certificate = {};  ///< of this peer, see sign(Certificate); with organiser
  bool insecure = false;  ///< frames in the clear over any network, no session_key

  std::uint32_t max_message_bytes = 64 * 1024;        ///< longest payload, in [64, 16 MiB]
  std::size_t send_queue_bytes = 1024 * 1024;         ///< per peer, >= 2 * max_message_bytes
  std::size_t receive_queue_bytes = 4 * 1024 * 1024;  ///< per peer, >= 2 * max_message_bytes
  std::size_t max_peers = 64;                         ///< connected at once, in [1, 1024]
  /// Kernel send buffer. Small: what waits there can no longer be replaced by a newer state. Too
  /// small for delay * bandwidth of the path: it caps the throughput.
  std::size_t socket_buffer_bytes = 256 * 1024;  ///< in [4096, 64 MiB]

  std::chrono::milliseconds handshake_timeout{3000};  ///< from accepted to peer; > 0
  std::chrono::milliseconds idle_timeout{5000};       ///< nothing heard for so long: cut; > 0
  std::chrono::milliseconds backoff_min{100};         ///< before the first redial; > 0
  std::chrono::milliseconds backoff_max{3000};        ///< doubled up to here, >= backoff_min
  std::chrono::milliseconds drop_hold{1000};     ///< a dropped peer is refused for so long; >= 0
  std::chrono::milliseconds flush_timeout{250};  ///< destructor's patience, in [0, 10 s]
  /// Tells a restarted peer from its predecessor, which had a smaller one: peers that have seen a
  /// larger one refuse it. 0: system clock, ns.
  std::uint64_t incarnation = 0;

  /// Throws std::invalid_argument that says what the field must be and what it is.
  void validate() const;
};

/// A dialled address, whether or not its peer is known yet.
struct TANDEM_API DialStatus {
  HostPort address = {};
  PeerId peer = 0;             ///< 0 until it has told its id
  bool connected = false;      ///< its peer is
  std::uint64_t attempts = 0;  ///< dials since it was connected for longer than backoff_max
  std::string reason = {};     ///< why the last attempt failed; empty where none has
};

/// Connections that did not become a peer, or had to be given up.
struct TANDEM_API StrangerStatus {
  std::uint64_t accepted = 0;   ///< inbound connections, good ones included
  std::uint64_t refused = 0;    ///< wrong version, scene, id; session full; dropped peer on hold
  std::uint64_t malformed = 0;  ///< bytes that are no handshake
  std::uint64_t timed_out = 0;  ///< handshake not completed in time
  std::uint64_t limited = 0;    ///< over the rate of an address, with a session key
  std::uint64_t bad_proof = 0;  ///< do not have the session key
  /// Frames that the other end has not sealed, or not there: forged, changed, repeated, out of
  /// order. Each has ended its connection, which may have been that of a peer.
  std::uint64_t forged = 0;
  std::string last_reason = {};  ///< of the latest of them
};

/// Full mesh over TCP: every process accepts and dials, learns the others' addresses from any peer
/// it reaches, keeps exactly one connection to each, and redials with back-off for ever.
///
/// - Frames carry a length prefix, checked before anything is allocated or kept.
/// - Newest: where a queue is full the oldest state goes, counted in dropped_queue_full.
/// - Reliable: numbered and acknowledged, so what a broken connection lost is sent again when the
///   same process is back, once and in order. Where states alone cannot make room the connection
///   is cut with a reason and set up again. A restarted process starts empty.
/// - Two connections to one peer: the lower id decides and the newest handshake wins, so that a
///   half-dead connection never stands in the way of its successor.
/// - A peer restarted with the same id (a larger incarnation) takes over at once; from then on the
///   older process is refused.
/// - Packet::received is of the system clock; round trips are not measured.
/// - With a session key each connection begins with a key exchange, and each frame is encrypted and
///   authenticated; docs/protocol.md says how. Without one, bytes are in the clear: this machine,
///   or a trusted network or tunnel with `insecure`.
/// - A member may make this process dial addresses of its choice (loopback ones without key and
///   `insecure`).
///
/// One thread of its own does all network work. post, drain, drop and the readers take a short lock
/// and never wait for the network. The destructor tries to send what is queued as Reliable for
/// flush_timeout, then closes; no thread or descriptor is left.
/// @par Thread safety  Distinct objects: safe. One object: one thread at a time.
class TANDEM_API TcpTransport final : public consensus::Transport {
 public:
  /// Throws std::invalid_argument (TcpOptions::validate) or std::system_error saying what cannot be
  /// listened on and why.
  explicit TcpTransport(const TcpOptions& options);
  ~TcpTransport() override;
  TcpTransport(const TcpTransport&) = delete;
  TcpTransport& operator=(const TcpTransport&) = delete;

  PeerId self() const override;
  /// @see consensus::Transport::post. Counted as dropped_queue_full where a full queue refuses it.
  bool post(PeerId to, std::span<const std::byte> bytes, consensus::Delivery delivery) override;
  /// Ordered by peer id, within one peer as they came. Appends whole packets, frees the queues.
  void drain(std::vector<consensus::Packet>& out) override;
  /// Cuts the connection, tells the peer why, discards its packets that are not drained. It is not
  /// dialled again, and refused for drop_hold; then a handshake of its own brings it back.
  void drop(PeerId peer, const std::string& reason) override;
  std::vector<consensus::PeerStatus> peers() const override;

  /// As UdpTransport::change_group; it is done when group() says so.
  void change_group(std::span<const std::byte> signed_change);
  /// Number of the change that holds, from whomever it came; 0: none.
  std::uint64_t group() const;

  std::vector<DialStatus> dials() const;
  StrangerStatus strangers() const;
  /// The port that is listened on, 0 where none is.
  std::uint16_t local_port() const;
  /// Changes when that peer is a new process; 0 where it was never connected.
  std::uint64_t incarnation(PeerId peer) const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tandem::net
