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

/// Names one participant of a session; chosen by the application, unique, never 0.
using PeerId = std::uint64_t;

/// Session time in ns, common to all peers.
using SessionTime = std::int64_t;

/// Longest packet of this library, below the default frame limit of tandem::net.
inline constexpr std::size_t kMaxPacketBytes = 60 * 1024;

enum class Delivery : std::uint8_t {
  Newest,    ///< states: may be lost, may be dropped when a queue is full, oldest first
  Reliable,  ///< constraints and membership: in order, resent by the transport where it can
};

/// What a member may do, as far as all others are concerned: each may what those before it may.
enum class Role : std::uint8_t {
  Watch,  ///< hear what the others say; its own states and springs count for nothing
  Act,    ///< pull at bodies by springs, which all simulate; its states count for nothing
  Share,  ///< say where bodies are
};

/// Bytes from one peer, exactly as that peer posted them. Untrusted.
struct TANDEM_API Packet {
  PeerId from = 0;
  std::vector<std::byte> bytes = {};
  /// When they came; the least value where the transport does not say.
  SessionTime received = INT64_MIN;
  /// What its sender may do, as the transport knows it.
  Role role = Role::Share;
};

/// A peer as the transport sees it.
struct TANDEM_API PeerStatus {
  PeerId id = 0;
  bool connected = false;
  std::string reason = {};  ///< why it is not connected; empty where it is
  std::uint64_t packets_in = 0;
  std::uint64_t packets_out = 0;
  std::uint64_t bytes_in = 0;
  std::uint64_t bytes_out = 0;
  double kbit_per_s = 0.0;  ///< what the way there bears now, headers included; 0 = not known
  std::uint64_t dropped_queue_full = 0;  ///< states dropped because a queue was full
  std::uint64_t rejected = 0;            ///< frames refused: too long, wrong version, not decodable
  std::int64_t round_trip = -1;          ///< to it and back, smoothed, ns; -1: not known
  Role role = Role::Share;               ///< of the process that is or was connected
  std::uint64_t over_budget = 0;         ///< messages refused or held back: more than a member may
};

/// Carries bytes between peers. Faults are data (PeerStatus), never exceptions.
/// @par Thread safety  Distinct objects: safe. One object: post, drain, drop, peers from one thread
/// at a time; an implementation's own threads are its own business.
class TANDEM_API Transport {
 public:
  virtual ~Transport() = default;

  virtual PeerId self() const = 0;
  /// Post bytes to one peer. Never waits. False where they were dropped at once (unknown peer,
  /// not connected, too long).
  virtual bool post(PeerId to, std::span<const std::byte> bytes, Delivery delivery) = 0;
  /// Bytes of the longest packet that post() takes to any peer.
  virtual std::size_t max_packet_bytes(Delivery /*delivery*/) const { return kMaxPacketBytes; }
  /// Append everything that has come since the last call to `out`. Never waits.
  virtual void drain(std::vector<Packet>& out) = 0;
  /// Cut a peer off, with the reason for its status. It may come back only through a new handshake.
  virtual void drop(PeerId peer, const std::string& reason) = 0;
  /// All peers ever seen in this session, by ascending id.
  virtual std::vector<PeerStatus> peers() const = 0;
  /// The same in place of what `out` holds, whose memory is used again where a transport can: it is
  /// asked in each step.
  virtual void list_peers(std::vector<PeerStatus>& out) const { out = peers(); }
};

}  // namespace tandem::consensus
