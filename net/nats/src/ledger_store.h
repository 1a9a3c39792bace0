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

/// A ledger's stream on the server. Each call waits for the server, a second at most, so they are
/// made on the hub's thread for that.
class __attribute__((visibility("hidden"))) LedgerStore {
 public:
  enum class Result : std::uint8_t { Done, Refused, NoServer };

  LedgerStore(NatsHub::Impl& hub, const Subjects& subjects, const net::crypto::Secret& session_key);

  /// Make the stream where there is none. Subjects:
  ///   BASE.body.ID  the record     BASE.in.PATH.ID  it may be in that cell
  Result open();
  /// Write a record where the server has none that is later than `before`. With `before` the record
  /// itself: write it again where it was lost.
  /// @param record  on Done with its place, on Refused the later one
  Result write(StoredRecord& record, const StoredRecord& before);
  /// Calls `found` with each record whose body is in that cell.
  Result look(const Cell& cell, const std::function<void(const StoredRecord&)>& found);

  /// Where others are told at once of what was written.
  std::string news(const Cell& cell) const {
    return subjects_.base() + "news." + subjects_.path(cell);
  }
  std::optional<StoredRecord> read_news(std::span<const std::byte> bytes) const;

 private:
  std::string record_subject(const consensus::SharedId& id) const;
  std::string index_subject(const Cell& cell, const std::string& id) const;
  /// @param follows  the sequence of what stands under that subject; null: whatever it is
  Result publish(const std::string& subject, std::span<const std::byte> bytes,
                 const std::uint64_t* follows, std::uint64_t& sequence);
  /// The record of a body as it stands; without a place where there is none.
  Result read(const consensus::SharedId& id, StoredRecord& out);
  /// @param sequence  of the record that says so: what was written later stays
  void take_back(const std::string& subject, std::uint64_t sequence);
  void tell(const StoredRecord& record, std::span<const std::byte> sealed, const Cell& cell);

  NatsHub::Impl& hub_;
  Subjects subjects_;
  net::crypto::Secret session_key_;
  net::crypto::Random random_;
  std::string stream_;
  NatsOwned<jsCtx> context_;
  std::uint64_t open_ = 0;  ///< the life in which the stream is known to be there
};

}  // namespace tandem::nats
