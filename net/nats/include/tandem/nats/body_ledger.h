// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "tandem/consensus/shared_id.h"
#include "tandem/consensus/transport.h"
#include "tandem/nats/cells.h"
#include "tandem/nats/hub.h"
#include "tandem/net/keys.h"
#include "tandem/pbd/export.h"
#include "tandem/pbd/types.h"

namespace tandem::nats {

struct TANDEM_API LedgerOptions {
  std::shared_ptr<NatsHub> hub = {};  ///< of a server with JetStream
  std::string prefix = "tandem";      ///< as NatsOptions::prefix
  std::uint64_t scene_hash = 0;       ///< of the session
  net::Key session_key{};             ///< the same for all members, not zero
  CellOptions cells = {};             ///< as NatsOptions::cells

  /// @throws std::invalid_argument naming field, value and rule
  void validate() const;
};

/// Record of one body.
struct TANDEM_API LedgerRecord {
  consensus::SharedId id = {};
  Cell cell = {};                ///< of level 0, in which the body is found
  consensus::PeerId keeper = 0;  ///< who may write its position; 0 = free for anyone
  pbd::Pose pose = {};           ///< of the centre of mass, world
  pbd::Twist twist = {};         ///< world
  std::uint64_t revision = 0;    ///< increases with each record of this body; 0 = none written yet
};

struct TANDEM_API LedgerNews {
  enum class Kind : std::uint8_t {
    Found,    ///< written by another peer, or present when its cell was watched
    Written,  ///< written by this object
    Refused,  ///< not written, as another peer was first: its record
  };
  Kind kind{};
  LedgerRecord record = {};
};

/// The last position of each body of a session, independent of who is present: one record each,
/// kept by JetStream. For bodies that nobody simulates, and for handing them over.
///
/// - A body has one record, under its id. A record is written against the last one that the writer
/// knew: of two that write at once one is Refused, so that a body is never in two places.
/// - An index tells in which cell a body is found. It is written before a record and removed after
/// the next one, so a body is always in some cell; an outdated index is harmless, since the record
/// decides.
/// - A server that fails may lose records that it had acknowledged. After each reconnect every
/// object that wrote a record or watches its cell writes it again, unless there is a later one. If
/// two were written independently, a random token decides, for all alike.
/// - Records are sealed under the session key and bound to their id; the server can withhold one or
/// show an earlier one, but change none.
///
/// No call blocks on the server: requests are done on a thread of the hub's, as soon as there is a
/// server, and take() returns the results.
/// @par Thread safety  Distinct objects: safe. One object: one thread at a time.
class TANDEM_API BodyLedger {
 public:
  static constexpr std::size_t kMaxWaiting = 4096;  ///< requests not done

  /// @throws std::invalid_argument (LedgerOptions::validate)
  explicit BodyLedger(const LedgerOptions& options);
  ~BodyLedger();
  BodyLedger(const BodyLedger&) = delete;
  BodyLedger& operator=(const BodyLedger&) = delete;

  /// Report all bodies in a cell, and those that come and go, until unwatch().
  void watch(const Cell& cell);
  void unwatch(const Cell& cell);
  /// Write a body's position. Its cell is that of the pose, or the previous one while the pose is
  /// within CellOptions::slack of it. False if the last write() of that body is not done yet, too
  /// many requests wait, or a number is not finite.
  bool write(const consensus::SharedId& id, consensus::PeerId keeper, const pbd::Pose& pose,
             const pbd::Twist& twist);
  /// The last known record of a body; null if there is none. Valid until the next take().
  const LedgerRecord* known(const consensus::SharedId& id) const;
  /// Append the results so far, in order.
  void take(std::vector<LedgerNews>& out);
  /// Requests not done.
  std::size_t waiting() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tandem::nats
