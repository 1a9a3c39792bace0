// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tandem/consensus/transport.h"
#include "tandem/nats/cells.h"
#include "tandem/nats/hub.h"
#include "tandem/net/keys.h"
#include "tandem/pbd/export.h"
#include "tandem/pbd/types.h"

namespace tandem::nats {

struct TANDEM_API CellEventOptions {
  std::shared_ptr<NatsHub> hub = {};  ///< of a server with JetStream
  std::string prefix = "tandem";      ///< as NatsOptions::prefix
  std::uint64_t scene_hash = 0;       ///< of the session
  net::Key session_key{};             ///< the same for all members, not zero
  CellOptions cells = {};             ///< as NatsOptions::cells
  consensus::PeerId self = 0;         ///< not 0
  /// How long events are kept for members that come later or were disconnected; in [1 s, 1 day],
  /// the same for all members of a session.
  std::chrono::seconds kept{120};

  /// @throws std::invalid_argument naming field, value and rule
  void validate() const;
};

/// An application event at a position. Untrusted.
struct TANDEM_API CellEvent {
  Cell cell = {};  ///< of level 0
  consensus::PeerId from = 0;
  consensus::SessionTime stamp = 0;  ///< ns, as claimed by its sender
  std::string topic = {};
  std::vector<std::byte> payload = {};
};

/// Events that concern a place, for members near it, kept by JetStream: a door was unlocked here.
/// Events that concern members anywhere belong to consensus::EventChannel.
///
/// - Each event arrives once at every member within CellOptions::near of its cell while it is kept;
/// those of one sender and cell arrive in the order sent.
/// - Events sent without a server are sent once there is one. A server that fails may lose events
/// that it had acknowledged: after each reconnect a sender repeats those within `kept`, and
/// receivers drop duplicates.
/// - Events are sealed under the session key and bound to their cell. Any member can send in
/// another's name.
///
/// No call blocks on the server: requests are done on a thread of the hub's.
/// @par Thread safety  Distinct objects: safe. One object: one thread at a time.
class TANDEM_API CellEvents {
 public:
  static constexpr std::size_t kMaxTopicBytes = 64;
  static constexpr std::size_t kMaxPayloadBytes = 8 * 1024;
  static constexpr std::size_t kMaxKept = 1024;  ///< own events that are remembered
  /// Events that wait for take(). Later ones wait at the server, while it keeps them.
  static constexpr std::size_t kMaxUntaken = 1024;

  /// @throws std::invalid_argument (CellEventOptions::validate)
  explicit CellEvents(const CellEventOptions& options);
  ~CellEvents();
  CellEvents(const CellEvents&) = delete;
  CellEvents& operator=(const CellEvents&) = delete;

  /// Position of the user, m, world: selects the cells to listen to. If not finite, the last
  /// position stays.
  void set_position(const pbd::Vec3& position);
  /// Send an event at a position, m, world. @param stamp  session time, ns  @return false if topic
  /// or payload are too long, the position is not finite, or kMaxKept others were sent within
  /// CellEventOptions::kept
  bool send(const pbd::Vec3& position, std::string_view topic, std::span<const std::byte> payload,
            consensus::SessionTime stamp);
  /// Append the events received since the last call, at most kMaxUntaken.
  void take(std::vector<CellEvent>& out);
  /// Requests to the server that are not done.
  std::size_t waiting() const;
  /// Messages dropped because they are not of a member of this session, or belong to another cell.
  std::uint64_t refused() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tandem::nats
