// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "credentials.h"
#include "hub_impl.h"
#include "subjects.h"
#include "tandem/nats/cell_events.h"

namespace tandem::nats {

/// An event as it is sealed: who says it in which of his lives, and its number there.
struct NumberedEvent {
  std::uint64_t source = 0;  ///< drawn by each object that sends
  std::uint64_t number = 0;  ///< of its events in all cells, from 1
  CellEvent event;
};

void encode(const NumberedEvent& event, std::vector<std::byte>& out);
/// None: too long, cut off, of no cell of level 0.
std::optional<NumberedEvent> decode_event(std::span<const std::byte> bytes);

/// What has been heard of one cell. Bounded, whatever members say.
class EventLog {
 public:
  static constexpr std::size_t kMaxSources = 1024;  ///< the longest silent one goes for a new one

  /// Whether it was not heard before; then it has been.
  bool is_new(const NumberedEvent& event);

  std::uint64_t next = 1;  ///< sequence from which on the server is asked
  std::uint64_t life = 0;  ///< of the server that has given it

 private:
  struct Source {
    std::uint64_t latest = 0;
    std::uint64_t heard = 0;  ///< the later, the larger
  };
  std::map<std::uint64_t, Source> sources_;
  std::uint64_t turn_ = 0;
};

/// The stream of events on the server. Each call waits for the server, a second at most, so they
/// are made on the hub's thread for that.
class __attribute__((visibility("hidden"))) EventStore {
 public:
  EventStore(NatsHub::Impl& hub, const Subjects& subjects, const CellEventOptions& options);

  /// Subject, captured by the stream: BASE.ev.PATH
  std::string subject(const Cell& cell) const {
    return subjects_.base() + "ev." + subjects_.path(cell);
  }
  /// Where it is said that something new is there.
  std::string news(const Cell& cell) const {
    return subjects_.base() + "said." + subjects_.path(cell);
  }
  /// Once, however often it is asked for. @param name  of this event alone  @return false where the
  /// server has not said that it has it
  bool write(const Cell& cell, const std::string& name, std::span<const std::byte> sealed);
  /// Calls `found` with what is new in a cell, in order, until it says that there is no room for
  /// more. @return false where there is no server
  bool read(const Cell& cell, EventLog& log, const std::function<bool(const CellEvent&)>& found);
  /// What did not open, or was no event of its cell.
  std::uint64_t refused() const { return refused_; }

 private:
  bool open();

  NatsHub::Impl& hub_;
  Subjects subjects_;
  net::crypto::Secret session_key_;
  std::int64_t kept_;  ///< ns
  std::string stream_;
  NatsOwned<jsCtx> context_;
  std::atomic<std::uint64_t> refused_ = 0;
  std::uint64_t open_ = 0;  ///< the life in which the stream is known to be there
};

}  // namespace tandem::nats
