// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <span>
#include <string>
#include <vector>

#include "tandem/consensus/virtual_network.h"
#include "tandem/pbd/random.h"

namespace tandem::consensus {

/// A packet in transit.
struct Flight {
  SessionTime due = 0;
  PeerId from = 0;
  PeerId to = 0;
  std::uint64_t number = 0;  ///< within its link
  SessionTime posted = 0;
  Delivery delivery = Delivery::Newest;
  std::vector<std::byte> bytes;
};

/// All packets in transit, the earliest first. Ties are ordered by ids, not by the order of serving
/// links, which depends on how the time is divided.
class Air {
 public:
  bool empty() const { return heap_.empty(); }
  SessionTime next_due() const { return heap_.front().due; }
  void push(Flight flight);
  Flight pop();
  /// Remove everything in transit from one peer to another; earliest first.
  std::vector<Flight> take(PeerId from, PeerId to);

 private:
  std::vector<Flight> heap_;
};

/// Successive periods of trouble on a link.
class Spells {
 public:
  Spells(std::uint64_t seed, SessionTime now) : random_(seed), begin_(now), end_(now) {}

  /// End of the spell at `time`, or `time` itself outside of any. `time` must not decrease.
  /// @param rate  1/s, 0: none  @param length  s, mean
  SessionTime end_at(SessionTime time, double rate, double length);

 private:
  pbd::SplitMix64 random_;  ///< separate, so that spells do not change the draws for packets
  SessionTime begin_;
  SessionTime end_;
};

/// One direction between two peers: a queue, a line of finite bandwidth, and random faults.
class Link {
 public:
  Link(PeerId from, PeerId to, const LinkOptions& options, std::uint64_t seed, SessionTime now);

  bool open() const { return !cut_ && closed_.empty(); }
  /// Why the sender's side is not open; empty if it is.
  std::string reason() const { return closed_.empty() && cut_ ? "link cut" : closed_; }
  const LinkCounters& counters() const { return counters_; }
  std::size_t max_state_bytes() const { return options_.max_state_bytes; }
  std::uint64_t bytes_posted() const { return bytes_posted_; }
  std::uint64_t bytes_delivered() const { return bytes_delivered_; }
  /// Whether a packet waits; it starts at free_at().
  bool waits() const { return open() && !waiting_.empty(); }
  SessionTime free_at() const { return busy_until_; }

  bool post(SessionTime now, std::span<const std::byte> bytes, Delivery delivery, Air& air);
  /// Start all transmissions due up to `time`.
  void send_waiting(SessionTime time, Air& air);
  void count_delivered(const Flight& flight);
  /// ns, of states from post() to arrival, smoothed; -1: none has arrived.
  double delay() const { return delay_; }

  void set_options(SessionTime now, const LinkOptions& options, Air& air);
  void cut(SessionTime now, Air& air);
  /// Closed until heal(); packets posted before never arrive.
  void close(SessionTime now, std::string reason, Air& air);
  void heal(SessionTime now, Air& air);

 private:
  struct Waiting {
    std::vector<std::byte> bytes;
    Delivery delivery = Delivery::Newest;
    SessionTime posted = 0;
  };

  std::size_t waiting_bytes(Delivery delivery) const;
  bool make_room(std::size_t size);
  void launch(Waiting packet, SessionTime departure, Air& air);
  void fly(SessionTime due, SessionTime posted, Delivery delivery, std::vector<std::byte> bytes,
           Air& air);
  void recall(SessionTime now, Air& air);

  PeerId from_;
  PeerId to_;
  LinkOptions options_;
  pbd::SplitMix64 random_;
  Spells bursts_;
  Spells stalls_;
  bool cut_ = false;
  std::string closed_;
  std::deque<Waiting> waiting_;
  SessionTime busy_until_;     ///< when the last packet has left the sender
  SessionTime last_reliable_;  ///< when the last reliable packet arrives
  std::uint64_t sent_ = 0;
  LinkCounters counters_;
  double delay_ = -1.0;
  std::uint64_t bytes_posted_ = 0;
  std::uint64_t bytes_delivered_ = 0;
};

}  // namespace tandem::consensus
