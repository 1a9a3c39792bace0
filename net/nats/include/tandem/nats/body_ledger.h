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

/// What is written of one body.
struct TANDEM_API LedgerRecord {
  consensus::SharedId id = {};
  Cell cell = {};                ///< of level 0, in which it is looked for
  consensus::PeerId keeper = 0;  ///< who writes where it goes; 0: nobody, whoever comes may
  pbd::Pose pose = {};           ///< of the centre of mass, world
  pbd::Twist twist = {};         ///< world
  std::uint64_t revision = 0;    ///< one more with each record of this body; 0: not written yet
};

struct TANDEM_API LedgerNews {
  enum class Kind : std::uint8_t {
    Found,    ///< somebody has written it, or it was there when its cell was watched
    Written,  ///< this object has
    Refused,  ///< this object has not, since somebody else did first: this is what he wrote
  };
  Kind kind{};
  LedgerRecord record = {};
};

/// Where each body of a session was last, whoever is there: a last word for each, kept by
/// JetStream. For bodies that nobody simulates, and for handing them over.
///
/// - A body has one record, under its id. A record is written against the one that the writer knew
///   last: of two who write at once one is Refused, so that a body is never in two places.
/// - In which cell it is found an index says, which is written before a record and taken back after
///   the next one. So a body is in no cell at no time; an index that is too old says nothing, since
///   the record decides.
/// - A server that fails may lose what it had acknowledged. After each reconnect whoever wrote a
///   record or watches its cell writes it again, unless there is a later one. Where two have
///   written without knowing of each other, chance decides, for everybody alike.
/// - Records are sealed under the session key and bound to their id; the server can hold one back,
///   or show one from before, and change none.
///
/// Nothing waits for the server: what is asked for is done on a thread of the hub's, as soon as
/// there is a server, and take() has the news.
/// @par Thread safety  Distinct objects: safe. One object: one thread at a time.
class TANDEM_API BodyLedger {
 public:
  static constexpr std::size_t kMaxWaiting = 4096;  ///< things asked for and not done

  /// @throws std::invalid_argument (LedgerOptions::validate)
  explicit BodyLedger(const LedgerOptions& options);
  ~BodyLedger();
  BodyLedger(const BodyLedger&) = delete;
  BodyLedger& operator=(const BodyLedger&) = delete;

  /// Hear of all bodies that are in a cell, and of those that come and go, until unwatch().
  void watch(const Cell& cell);
  void unwatch(const Cell& cell);
  /// Write where a body is. Its cell is that of the pose, or the one of before where it has not
  /// gone further out of it than CellOptions::slack. False where the last write() of that body is
  /// not done yet, too much waits, or a number is not finite.
  bool write(const consensus::SharedId& id, consensus::PeerId keeper, const pbd::Pose& pose,
             const pbd::Twist& twist);
  /// The last that is known here of a body; null: nothing. Until the next call of take().
  const LedgerRecord* known(const consensus::SharedId& id) const;
  /// Append what has become of all that, in order.
  void take(std::vector<LedgerNews>& out);
  /// Asked for and not done.
  std::size_t waiting() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tandem::nats
