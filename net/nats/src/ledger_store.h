// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "hub_impl.h"
#include "ledger_wire.h"
#include "subjects.h"

namespace tandem::nats {

/// A ledger's stream on the server. Each call blocks on the server, for a second at most, so use
/// the hub's job thread.
class __attribute__((visibility("hidden"))) LedgerStore {
 public:
  enum class Result : std::uint8_t { Done, Refused, NoServer };

  LedgerStore(NatsHub::Impl& hub, const Subjects& subjects, const net::crypto::Secret& session_key);

  /// Create the stream if it does not exist. Subjects:
  ///   BASE.body.ID  the record     BASE.in.PATH.ID  it may be in that cell
  Result open();
  /// Write a record unless the server has one later than `before`. With `before` equal to the
  /// record: write it again if it was lost.
  /// @param record  on Done with its place, on Refused the later one
  Result write(StoredRecord& record, const StoredRecord& before);
  /// Calls `found` with each record whose body is in that cell.
  Result look(const Cell& cell, const std::function<void(const StoredRecord&)>& found);

  /// Subject of notifications about written records.
  std::string news(const Cell& cell) const {
    return subjects_.base() + "news." + subjects_.path(cell);
  }
  std::optional<StoredRecord> read_news(std::span<const std::byte> bytes) const;

 private:
  std::string record_subject(const consensus::SharedId& id) const;
  std::string index_subject(const Cell& cell, const std::string& id) const;
  /// @param follows  the present sequence under that subject; null: any
  Result publish(const std::string& subject, std::span<const std::byte> bytes,
                 const std::uint64_t* follows, std::uint64_t& sequence);
  /// The present record of a body; without a place if there is none.
  Result read(const consensus::SharedId& id, StoredRecord& out);
  /// @param sequence  of the record that moved the body: later entries stay
  void take_back(const std::string& subject, std::uint64_t sequence);
  void tell(const StoredRecord& record, std::span<const std::byte> sealed, const Cell& cell);

  NatsHub::Impl& hub_;
  Subjects subjects_;
  net::crypto::Secret session_key_;
  net::crypto::Random random_;
  std::string stream_;
  NatsOwned<jsCtx> context_;
  std::uint64_t open_ = 0;  ///< life in which the stream is known to exist
};

}  // namespace tandem::nats
