// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "tandem/pbd/export.h"

namespace tandem::consensus {

/// Identifies one participant of a session; chosen by the application, unique, never 0.
using PeerId = std::uint64_t;

/// Session time in ns, common to all peers.
using SessionTime = std::int64_t;

/// Longest packet of this library, below the default frame limit of tandem::net.
inline constexpr std::size_t kMaxPacketBytes = 60 * 1024;

enum class Delivery : std::uint8_t {
  Newest,    ///< states: may be lost, and dropped oldest first when a queue is full
  Reliable,  ///< constraints and membership: in order, resent by the transport if it can
};

/// Packets that the other peers accept from a member: each role includes those above it.
enum class Role : std::uint8_t {
  Watch,  ///< receives; its own states and springs are ignored
  Act,    ///< also pulls at bodies by springs, which all simulate; its states are ignored
  Share,  ///< also sends states of bodies
};

/// Bytes from one peer, exactly as that peer posted them. Untrusted.
struct TANDEM_API Packet {
  PeerId from = 0;
  std::vector<std::byte> bytes = {};
  /// Time of arrival; the minimum if the transport reports none.
  SessionTime received = INT64_MIN;
  /// The sender's role, as the transport knows it.
  Role role = Role::Share;
};

/// A peer as the transport sees it.
struct TANDEM_API PeerStatus {
  PeerId id = 0;
  bool connected = false;
  std::string reason = {};  ///< why it is not connected; empty if it is
  std::uint64_t packets_in = 0;
  std::uint64_t packets_out = 0;
  std::uint64_t bytes_in = 0;
  std::uint64_t bytes_out = 0;
  double kbit_per_s = 0.0;  ///< capacity of the path now, headers included; 0 = unknown
  std::uint64_t dropped_queue_full = 0;  ///< states dropped because a queue was full
  std::uint64_t rejected = 0;            ///< frames refused: too long, wrong version, not decodable
  std::int64_t round_trip = -1;          ///< to the peer and back, smoothed, ns; -1 = unknown
  Role role = Role::Share;               ///< of the process that is or was connected
  std::uint64_t over_budget = 0;         ///< messages beyond its budget: refused or delayed
};

/// Carries bytes between peers. Faults are data (PeerStatus), never exceptions.
/// @par Thread safety  Distinct objects: safe. One object: post, drain, drop, peers from one thread
/// at a time; an implementation's own threads are its own business.
class TANDEM_API Transport {
 public:
  virtual ~Transport() = default;

  virtual PeerId self() const = 0;
  /// Post bytes to one peer. Never blocks. False if they were dropped at once (unknown peer, not
  /// connected, too long).
  virtual bool post(PeerId to, std::span<const std::byte> bytes, Delivery delivery) = 0;
  /// Bytes of the longest packet that post() accepts for any peer.
  virtual std::size_t max_packet_bytes(Delivery /*delivery*/) const { return kMaxPacketBytes; }
  /// Append all packets received since the last call to `out`. Never blocks.
  virtual void drain(std::vector<Packet>& out) = 0;
  /// Disconnect a peer, with a reason for its status. It may return only by a new handshake.
  virtual void drop(PeerId peer, const std::string& reason) = 0;
  /// All peers ever seen in this session, by ascending id.
  virtual std::vector<PeerStatus> peers() const = 0;
  /// Like peers(), but replaces the contents of `out`, whose memory is reused if the transport can:
  /// it is called in each step.
  virtual void list_peers(std::vector<PeerStatus>& out) const { out = peers(); }
};

}  // namespace tandem::consensus
