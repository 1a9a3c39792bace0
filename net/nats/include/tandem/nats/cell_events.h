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
  /// How long what was said is kept for who comes later, or was cut off; in [1 s, 1 day], the same
  /// for all members of a session.
  std::chrono::seconds kept{120};

  /// @throws std::invalid_argument naming field, value and rule
  void validate() const;
};

/// Something that happened at a place, in the application's own words. Untrusted.
struct TANDEM_API CellEvent {
  Cell cell = {};  ///< of level 0
  consensus::PeerId from = 0;
  consensus::SessionTime stamp = 0;  ///< ns, as its sender has said
  std::string topic = {};
  std::vector<std::byte> payload = {};
};

/// Events that concern a place, for whoever is near it, kept by JetStream: a door was unlocked
/// here. What concerns members wherever they are goes over consensus::EventChannel.
///
/// - Each comes once to everybody who is within CellOptions::near of its cell while it is kept, and
///   those of one sender and cell in the order in which they were sent.
/// - What is sent while there is no server is sent when there is one. A server that fails may lose
///   what it had acknowledged: after each reconnect a sender says again what he has said within
///   `kept`, and who has had it does not hear it twice.
/// - Events are sealed under the session key and bound to their cell. Whoever has that key can send
///   in anybody's name.
///
/// Nothing waits for the server: what is asked for is done on a thread of the hub's.
/// @par Thread safety  Distinct objects: safe. One object: one thread at a time.
class TANDEM_API CellEvents {
 public:
  static constexpr std::size_t kMaxTopicBytes = 64;
  static constexpr std::size_t kMaxPayloadBytes = 8 * 1024;
  static constexpr std::size_t kMaxKept = 1024;  ///< own events that are remembered
  /// Events that wait for take(). What comes after them waits at the server, while it is kept.
  static constexpr std::size_t kMaxUntaken = 1024;

  /// @throws std::invalid_argument (CellEventOptions::validate)
  explicit CellEvents(const CellEventOptions& options);
  ~CellEvents();
  CellEvents(const CellEvents&) = delete;
  CellEvents& operator=(const CellEvents&) = delete;

  /// The user is here now, m, world: hear of the cells that are near. Not finite: he stays where he
  /// was.
  void set_position(const pbd::Vec3& position);
  /// Say that something happened there, m, world. @param stamp  session time, ns  @return false
  /// where topic or payload are too long, the position is not finite, or kMaxKept others were said
  /// within CellEventOptions::kept
  bool send(const pbd::Vec3& position, std::string_view topic, std::span<const std::byte> payload,
            consensus::SessionTime stamp);
  /// Append what has come since the last call, at most kMaxUntaken.
  void take(std::vector<CellEvent>& out);
  /// Asked of the server and not done.
  std::size_t waiting() const;
  /// What was read and is of no member of this session, or was said of another cell: dropped.
  std::uint64_t refused() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tandem::nats
