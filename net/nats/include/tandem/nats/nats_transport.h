// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tandem/consensus/transport.h"
#include "tandem/nats/cells.h"
#include "tandem/nats/hub.h"
#include "tandem/net/clock.h"
#include "tandem/net/udp.h"
#include "tandem/pbd/export.h"
#include "tandem/pbd/types.h"

namespace tandem::nats {

class NatsTransport;

/// Who may tell what a cell comes to.
struct TANDEM_API TrustedSpeaker {
  consensus::PeerId peer = 0;
  net::Key public_key{};  ///< net::organiser_public_key() of NatsOptions::speaker
};

/// What one peer brings to a session over NATS.
struct TANDEM_API NatsOptions {
  using Transport = NatsTransport;  ///< what they are options of

  /// Connection to the server, which many peers of a process may share; null: one for this peer
  /// alone, as `server` says.
  std::shared_ptr<NatsHub> hub = {};
  HubOptions server = {};
  std::string prefix = "tandem";  ///< first word of all subjects: letters, digits, - and _
  /// Who this peer is, whom it lets in, and how each connection goes: handshake, keys, rights,
  /// rates and queues are those of UDP. What is about sockets and finding each other is not used:
  /// listen_port, listen_address, connect, max_peers, kernel_filter and relay.
  net::UdpOptions member = {};
  CellOptions cells = {};
  /// So many of the nearest are spoken to by UDP where both ends have HubOptions::direct and that
  /// works, in [0, 256].
  std::size_t direct_peers = 16;
  /// Ed25519 secret with which this peer signs what it says of a cell.
  std::optional<net::Key> speaker = {};
  /// Whose summaries count; empty: those of all who have the session key, signed or not.
  std::vector<TrustedSpeaker> speakers = {};
  /// ns, never less than before, from any thread: what goes in place of the steady clock, for
  /// programs whose time is not the wall's. Session time then begins as this one.
  std::function<std::int64_t()> steady = {};

  /// @throws std::invalid_argument naming field, value and rule
  void validate() const;
};

/// What somebody has said of a cell that is far away. Untrusted.
struct TANDEM_API CellSummary {
  Cell cell = {};
  consensus::PeerId from = 0;
  std::uint32_t people = 0;
  std::vector<std::byte> content = {};
};

/// A peer that is connected because it is near, and where it has said that its user is.
struct TANDEM_API NearPeer {
  consensus::PeerId peer = 0;
  pbd::Vec3 position = pbd::Vec3::Zero();  ///< m, world; untrusted
};

struct TANDEM_API NatsStatus {
  HubStatus hub = {};
  double hears = 0.0;                  ///< m: whom this peer connects to now
  std::size_t limit = 0;               ///< so many of them at most, see CellOptions::max_near
  std::size_t met = 0;                 ///< connected to, or about to be
  std::size_t direct = 0;              ///< of those, spoken to by UDP alone
  std::size_t contacts = 0;            ///< known to be near
  std::size_t cells = 0;               ///< listened to
  std::int64_t lag = -1;               ///< ns, from here through the server and back; -1: not known
  std::uint64_t direct_out = 0;        ///< datagrams by UDP
  std::uint64_t direct_bytes_out = 0;  ///< of them
  std::uint64_t direct_in = 0;         ///< likewise, taken in
  std::uint64_t direct_bytes_in = 0;
  std::uint64_t dropped = 0;  ///< messages that came faster than they were taken in
  std::uint64_t refused = 0;  ///< messages to cells that did not open or were not signed
  std::uint64_t unknown = 0;  ///< packets of no connection, over the server or by UDP
};

/// Peers that meet through NATS servers: whoever is near is connected, whoever is far is
/// summarised.
///
/// - Connections are those of net::UdpTransport in all but the socket: datagrams go to a subject of
///   each peer. Handshake, seals, rights, the reliable channel, rate and session time are the same.
/// - A peer says to its cell where it is and hears who is in the cells about it; it is connected to
///   the nearest. With the user's position (set_position) both follow him.
/// - What is further away comes as summaries of cells, several times a second. The content of one
///   is a packet of tandem::consensus and comes out of drain() as from the peer that spoke, unless
///   that one is connected.
/// - A peer that is too slow hears fewer of the nearest, down to CellOptions::min_near, and each
///   connection slows down by itself; when it catches up it hears more again.
/// - The nearest speak by UDP where they can (NatsOptions::direct_peers): all goes that way alone,
///   by both while it is in doubt, and by the server where it fails. It is the same connection all
///   the time; what comes by both ways counts once. These peers alone are told the addresses of
///   HubOptions::direct.
/// - Where the server goes away nothing is sent but by UDP; what is reliable goes on when it is
///   back. Peers are kept for UdpOptions::idle_timeout.
///
/// post, drain and the others take a short lock and never wait for the network.
/// @par Thread safety  Distinct objects: safe. One object: one thread at a time.
class TANDEM_API NatsTransport final : public consensus::Transport {
 public:
  /// @throws std::invalid_argument (NatsOptions::validate), std::runtime_error (NatsHub)
  explicit NatsTransport(const NatsOptions& options);
  ~NatsTransport() override;
  NatsTransport(const NatsTransport&) = delete;
  NatsTransport& operator=(const NatsTransport&) = delete;

  consensus::PeerId self() const override;
  bool post(consensus::PeerId to, std::span<const std::byte> bytes,
            consensus::Delivery delivery) override;
  std::size_t max_packet_bytes(consensus::Delivery delivery) const override;
  void drain(std::vector<consensus::Packet>& out) override;
  void drop(consensus::PeerId peer, const std::string& reason) override;
  /// Of those that are or were near lately.
  std::vector<consensus::PeerStatus> peers() const override;
  void list_peers(std::vector<consensus::PeerStatus>& out) const override;

  /// The user is here now, m, world; not finite: he stays where he was.
  void set_position(const pbd::Vec3& position);
  /// Who is near, by ascending id; appended. For consensus::NearbyInterest.
  void near_peers(std::vector<NearPeer>& out) const;
  /// Whether this peer speaks for its cell of that level, from 1.
  bool speaks(int level) const;
  /// What it says where it does, from now on: a packet of tandem::consensus, at most
  /// kMaxSummaryBytes; longer ones are refused. @return whether it was taken
  bool set_summary(int level, std::span<const std::byte> content);
  static constexpr std::size_t kMaxSummaryBytes = 8 * 1024;
  /// Append what was said of far cells since the last call, at most the last kMaxSummaries.
  void take_summaries(std::vector<CellSummary>& out);
  static constexpr std::size_t kMaxSummaries = 256;

  /// Do what is due; for hubs that are not driven (HubOptions::driven).
  void poll();

  /// As net::UdpTransport has them.
  bool change_group(std::span<const std::byte> signed_change);
  std::uint64_t group() const;
  consensus::SessionTime session_now() const;
  net::ClockStatus clock() const;

  NatsStatus status() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tandem::nats
