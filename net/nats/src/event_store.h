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

/// An event as it is sealed, with the sending object and its number there.
struct NumberedEvent {
  std::uint64_t source = 0;  ///< random, for each sending object
  std::uint64_t number = 0;  ///< of its events in all cells, from 1
  CellEvent event;
};

void encode(const NumberedEvent& event, std::vector<std::byte>& out);
/// None: too long, truncated, of no cell of level 0.
std::optional<NumberedEvent> decode_event(std::span<const std::byte> bytes);

/// Events received of one cell. Bounded, whatever members send.
class EventLog {
 public:
  static constexpr std::size_t kMaxSources = 1024;  ///< the one silent for the longest is replaced

  /// Whether the event is new; records it.
  bool is_new(const NumberedEvent& event);

  std::uint64_t next = 1;  ///< next sequence to request from the server
  std::uint64_t life = 0;  ///< life of the server that has assigned it

 private:
  struct Source {
    std::uint64_t latest = 0;
    std::uint64_t heard = 0;  ///< increasing
  };
  std::map<std::uint64_t, Source> sources_;
  std::uint64_t turn_ = 0;
};

/// The stream of events on the server. Each call blocks on the server, for a second at most, so use
/// the hub's job thread.
class __attribute__((visibility("hidden"))) EventStore {
 public:
  EventStore(NatsHub::Impl& hub, const Subjects& subjects, const CellEventOptions& options);

  /// Subject, captured by the stream: BASE.ev.PATH
  std::string subject(const Cell& cell) const {
    return subjects_.base() + "ev." + subjects_.path(cell);
  }
  /// Subject of notifications about new events.
  std::string news(const Cell& cell) const {
    return subjects_.base() + "said." + subjects_.path(cell);
  }
  /// Written once, however often it is called. @param name  unique to this event  @return false if
  /// the server has not acknowledged it
  bool write(const Cell& cell, const std::string& name, std::span<const std::byte> sealed);
  /// Calls `found` with each new event of a cell, in order, until it returns that there is no more
  /// room. @return false if there is no server
  bool read(const Cell& cell, EventLog& log, const std::function<bool(const CellEvent&)>& found);
  /// Messages that did not open, or were no event of their cell.
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
  std::uint64_t open_ = 0;  ///< life in which the stream is known to exist
};

}  // namespace tandem::nats
