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

/// A peer that may send summaries of cells.
struct TANDEM_API TrustedSpeaker {
  consensus::PeerId peer = 0;
  net::Key public_key{};  ///< net::organiser_public_key() of NatsOptions::speaker
};

/// Options of one peer in a session over NATS.
struct TANDEM_API NatsOptions {
  using Transport = NatsTransport;  ///< what they are options of

  /// Connection to the server, which many peers of a process may share; null: one for this peer
  /// alone, by `server`.
  std::shared_ptr<NatsHub> hub = {};
  HubOptions server = {};
  std::string prefix = "tandem";  ///< first word of all subjects: letters, digits, - and _
  /// Identity, admission and connections: handshake, keys, rights, rates and queues are those of
  /// UDP. Options of sockets and of finding peers are not used: listen_port, listen_address,
  /// connect, max_peers, kernel_filter and relay.
  net::UdpOptions member = {};
  CellOptions cells = {};
  /// Number of the nearest peers that are addressed by UDP if both ends have HubOptions::direct and
  /// it works, in [0, 256].
  std::size_t direct_peers = 16;
  /// Ed25519 secret with which this peer signs summaries of cells.
  std::optional<net::Key> speaker = {};
  /// Accepted signers of summaries; empty: all with the session key, signed or not.
  std::vector<TrustedSpeaker> speakers = {};
  /// ns, never decreasing, called from any thread: replaces the steady clock, for programs whose
  /// time is not real time. Session time then starts at its value.
  std::function<std::int64_t()> steady = {};

  /// @throws std::invalid_argument naming field, value and rule
  void validate() const;
};

/// A peer's summary of a distant cell. Untrusted.
struct TANDEM_API CellSummary {
  Cell cell = {};
  consensus::PeerId from = 0;
  std::uint32_t people = 0;
  std::vector<std::byte> content = {};
};

/// A peer that is connected because it is near, and the announced position of its user.
struct TANDEM_API NearPeer {
  consensus::PeerId peer = 0;
  pbd::Vec3 position = pbd::Vec3::Zero();  ///< m, world; untrusted
};

struct TANDEM_API NatsStatus {
  HubStatus hub = {};
  double hears = 0.0;                  ///< m: range of its connections now
  std::size_t limit = 0;               ///< largest number of them now, see CellOptions::max_near
  std::size_t met = 0;                 ///< connected, or about to be
  std::size_t direct = 0;              ///< of those, by UDP alone
  std::size_t contacts = 0;            ///< known to be near
  std::size_t cells = 0;               ///< subscribed
  std::int64_t lag = -1;               ///< ns, from here through the server and back; -1 = unknown
  std::uint64_t direct_out = 0;        ///< datagrams by UDP
  std::uint64_t direct_bytes_out = 0;  ///< of them
  std::uint64_t direct_in = 0;         ///< received by UDP
  std::uint64_t direct_bytes_in = 0;
  std::uint64_t dropped = 0;  ///< messages dropped, as they came faster than they were processed
  std::uint64_t refused = 0;  ///< messages to cells that did not open or were not signed
  std::uint64_t unknown = 0;  ///< packets without a connection, over the server or by UDP
};

/// Peers that meet through NATS servers: near ones are connected, distant ones are summarised.
///
/// - Connections are those of net::UdpTransport in all but the socket: datagrams go to a subject of
/// each peer. Handshake, seals, rights, the reliable channel, rate and session time are the same.
/// - A peer announces its position to its cell and subscribes to the cells around it; it connects
/// to the nearest peers. Both follow the user's position (set_position).
/// - Distant cells send summaries several times a second. The content of one is a packet of
/// tandem::consensus and comes out of drain() as from the summarising peer, unless that one is
/// connected.
/// - A peer that is too slow connects to fewer of the nearest, down to CellOptions::min_near, and
/// each connection slows down by itself; when it catches up it connects to more again.
/// - The nearest communicate by UDP if possible (NatsOptions::direct_peers): by UDP alone, by both
/// paths while UDP is in doubt, and by the server if it fails. It remains one connection, and a
/// packet that comes by both counts once. Only these peers receive the addresses of
/// HubOptions::direct.
/// - Without the server packets go by UDP only; reliable messages continue when it is back. Peers
/// are kept for UdpOptions::idle_timeout.
///
/// post, drain and the others take a short lock and never block on the network.
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
  /// Peers that are or were recently near.
  std::vector<consensus::PeerStatus> peers() const override;
  void list_peers(std::vector<consensus::PeerStatus>& out) const override;

  /// Position of the user, m, world; if not finite, the last position stays.
  void set_position(const pbd::Vec3& position);
  /// Near peers by ascending id; appended. For consensus::NearbyInterest.
  void near_peers(std::vector<NearPeer>& out) const;
  /// Whether this peer summarises its cell of that level, from 1.
  bool speaks(int level) const;
  /// The summary that it sends from now on, while it does: a packet of tandem::consensus, at most
  /// kMaxSummaryBytes; longer ones are refused. @return whether it was accepted
  bool set_summary(int level, std::span<const std::byte> content);
  static constexpr std::size_t kMaxSummaryBytes = 8 * 1024;
  /// Append the summaries of distant cells since the last call, at most the last kMaxSummaries.
  void take_summaries(std::vector<CellSummary>& out);
  static constexpr std::size_t kMaxSummaries = 256;

  /// Do due work; for hubs that are not driven (HubOptions::driven).
  void poll();

  /// As in net::UdpTransport.
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
