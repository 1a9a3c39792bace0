// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "link_model.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "tandem/pbd/validate.h"

namespace tandem::consensus {

using pbd::detail::require;
using pbd::detail::require_in;

namespace {

/// Rounds to the nearest nanosecond.
SessionTime to_ns(double seconds) {
  return static_cast<SessionTime>(std::floor(seconds * 1e9 + 0.5));
}

/// Each direction has its own generator.
std::uint64_t seed_of(std::uint64_t seed, PeerId from, PeerId to) {
  const std::uint64_t a = pbd::SplitMix64(seed).next();
  const std::uint64_t b = pbd::SplitMix64(a ^ from).next();
  return pbd::SplitMix64(b + to).next();
}

bool later(const Flight& a, const Flight& b) {
  if (a.due != b.due) return a.due > b.due;
  if (a.from != b.from) return a.from > b.from;
  if (a.to != b.to) return a.to > b.to;
  return a.number > b.number;
}

}  // namespace

void LinkOptions::validate() const {
  constexpr double kLongest = 3600.0;
  require_in(0.0, kLongest, "LinkOptions", "latency", latency, "s");
  require_in(0.0, kLongest, "LinkOptions", "jitter", jitter, "s");
  require_in(0.0, 0.99, "LinkOptions", "loss", loss);
  require_in(0.0, 1.0, "LinkOptions", "duplicate", duplicate);
  require_in(0.0, 1.0, "LinkOptions", "reorder", reorder);
  require_in(0.0, kLongest, "LinkOptions", "reorder_delay", reorder_delay, "s");
  require_in(0.0, 1000.0, "LinkOptions", "bursts", bursts, "per s");
  require_in(0.0, kLongest, "LinkOptions", "burst_length", burst_length, "s");
  require_in(0.0, 1000.0, "LinkOptions", "stalls", stalls, "per s");
  require_in(0.0, kLongest, "LinkOptions", "stall_length", stall_length, "s");
  require(bandwidth == 0.0 || (std::isfinite(bandwidth) && bandwidth >= 1.0), "LinkOptions",
          "bandwidth", bandwidth, "0 or at least 1 bit/s");
  require(max_state_bytes >= 1 && max_state_bytes <= VirtualNetwork::kMaxPacketBytes, "LinkOptions",
          "max_state_bytes", static_cast<double>(max_state_bytes), "from 1 to 65536");
}

LinkOptions network_profile(int number) {
  struct Row {
    double latency;
    double jitter;
  };
  constexpr std::array<Row, 5> kTable = {
      {{3.5e-3, 0.0}, {6e-3, 0.5e-3}, {28.5e-3, 2.5e-3}, {63.5e-3, 4e-3}, {123.5e-3, 5e-3}}};
  if (number < 1 || number > 5) {
    pbd::detail::refuse("network_profile: number", "from 1 to 5", number);
  }
  const Row& row = kTable[static_cast<std::size_t>(number - 1)];
  LinkOptions options;
  options.latency = row.latency;
  options.jitter = row.jitter;
  return options;
}

std::span<const NamedNetwork> named_networks() {
  static constexpr LinkOptions kWifi{
      .latency = 0.01, .jitter = 0.003, .stalls = 0.2, .stall_length = 1.0};
  static constexpr LinkOptions kBursts{
      .latency = 0.02, .jitter = 0.005, .bursts = 0.25, .burst_length = 0.2};
  static constexpr std::array<NamedNetwork, 4> kAll{{
      {.name = "wifi", .up = kWifi, .down = kWifi},
      {.name = "swollen",
       .up = {.latency = 0.02, .bandwidth = 128e3, .queue_limit = 16000},
       .down = {.latency = 0.02}},
      {.name = "lopsided", .up = {.latency = 0.2}, .down = {.latency = 0.02}},
      {.name = "bursts", .up = kBursts, .down = kBursts},
  }};
  return kAll;
}

void Air::push(Flight flight) {
  heap_.push_back(std::move(flight));
  std::push_heap(heap_.begin(), heap_.end(), later);
}

Flight Air::pop() {
  std::pop_heap(heap_.begin(), heap_.end(), later);
  Flight flight = std::move(heap_.back());
  heap_.pop_back();
  return flight;
}

std::vector<Flight> Air::take(PeerId from, PeerId to) {
  const auto first = std::partition(heap_.begin(), heap_.end(),
                                    [&](const Flight& f) { return f.from != from || f.to != to; });
  std::vector<Flight> taken(std::make_move_iterator(first), std::make_move_iterator(heap_.end()));
  heap_.erase(first, heap_.end());
  std::make_heap(heap_.begin(), heap_.end(), later);
  std::sort(taken.begin(), taken.end(),
            [](const Flight& a, const Flight& b) { return later(b, a); });
  return taken;
}

Link::Link(PeerId from, PeerId to, const LinkOptions& options, std::uint64_t seed, SessionTime now)
    : from_(from),
      to_(to),
      options_(options),
      random_(seed_of(seed, from, to)),
      bursts_(seed_of(seed + 1, to, from), now),
      stalls_(seed_of(seed + 2, to, from), now),
      busy_until_(now),
      last_reliable_(now) {}

std::size_t Link::waiting_bytes(Delivery delivery) const {
  std::size_t sum = 0;
  for (const Waiting& w : waiting_) sum += w.delivery == delivery ? w.bytes.size() : 0;
  return sum;
}

/// Makes room for `size` more bytes of states by dropping the oldest; false if it cannot.
bool Link::make_room(std::size_t size) {
  if (size > options_.queue_limit) return false;
  std::size_t waiting = waiting_bytes(Delivery::Newest);
  while (waiting + size > options_.queue_limit) {
    const auto oldest = std::find_if(waiting_.begin(), waiting_.end(), [](const Waiting& w) {
      return w.delivery == Delivery::Newest;
    });
    waiting -= oldest->bytes.size();
    waiting_.erase(oldest);
    ++counters_.queue_full;
  }
  return true;
}

bool Link::post(SessionTime now, std::span<const std::byte> bytes, Delivery delivery, Air& air) {
  const std::size_t most =
      delivery == Delivery::Newest ? options_.max_state_bytes : VirtualNetwork::kMaxPacketBytes;
  if (bytes.size() > most || !closed_.empty()) return false;
  send_waiting(now, air);
  if (delivery == Delivery::Reliable) {
    const std::size_t waiting = waiting_bytes(Delivery::Reliable);
    if (waiting + bytes.size() > VirtualNetwork::kMaxReliableBytes) return false;
  } else if (cut_) {
    ++counters_.cut;
    return false;
  } else if (busy_until_ > now && !make_room(bytes.size())) {
    ++counters_.queue_full;
    return false;
  }
  waiting_.push_back({{bytes.begin(), bytes.end()}, delivery, now});
  ++counters_.posted;
  bytes_posted_ += bytes.size();
  send_waiting(now, air);
  return true;
}

void Link::send_waiting(SessionTime time, Air& air) {
  while (open() && !waiting_.empty() && busy_until_ <= time) {
    Waiting packet = std::move(waiting_.front());
    waiting_.pop_front();
    SessionTime departure = std::max(busy_until_, packet.posted);
    if (options_.bandwidth > 0.0) {
      const double bits = 8.0 * static_cast<double>(packet.bytes.size());
      departure += to_ns(bits / options_.bandwidth);
    }
    busy_until_ = departure;
    launch(std::move(packet), departure, air);
  }
}

SessionTime Spells::end_at(SessionTime time, double rate, double length) {
  if (rate <= 0.0) return time;
  while (end_ <= time) {
    // Uniform, from 0 to twice the mean: a logarithm would differ between platforms.
    begin_ = end_ + to_ns(2.0 * random_.unit() / rate);
    end_ = begin_ + to_ns(2.0 * random_.unit() * length) + 1;
  }
  return time >= begin_ ? end_ : time;
}

/// Decide a packet's fate. The number of draws is the same for every packet, so that one option
/// does not change the effect of the others.
void Link::launch(Waiting packet, SessionTime departure, Air& air) {
  const LinkOptions& o = options_;
  const bool lost = random_.unit() < o.loss;
  const bool doubled = random_.unit() < o.duplicate;
  const bool held_back = random_.unit() < o.reorder;
  const double hold = random_.unit() * o.reorder_delay;
  const double first = std::max(o.latency + o.jitter * (2.0 * random_.unit() - 1.0), 0.0);
  const double second = std::max(o.latency + o.jitter * (2.0 * random_.unit() - 1.0), 0.0);
  pbd::SplitMix64 resends(random_.next());
  departure = stalls_.end_at(departure, o.stalls, o.stall_length);
  const SessionTime through = bursts_.end_at(departure, o.bursts, o.burst_length);

  if (packet.delivery == Delivery::Reliable) {
    const SessionTime timeout = std::max(to_ns(2.0 * o.latency), SessionTime{1'000'000});
    SessionTime due = through + to_ns(first);
    if (through > departure) {
      due += timeout;
      ++counters_.resent;
    }
    for (bool again = lost; again; again = resends.unit() < o.loss) {
      due += timeout;
      ++counters_.resent;
    }
    last_reliable_ = std::max(last_reliable_, due);
    fly(last_reliable_, packet.posted, packet.delivery, std::move(packet.bytes), air);
    return;
  }
  if (through > departure) {
    ++counters_.lost;
    return;
  }
  if (doubled) {
    ++counters_.duplicated;
    fly(departure + to_ns(second), packet.posted, packet.delivery, packet.bytes, air);
  }
  if (lost) {
    ++counters_.lost;
    return;
  }
  if (held_back) ++counters_.held_back;
  fly(departure + to_ns(held_back ? first + hold : first), packet.posted, packet.delivery,
      std::move(packet.bytes), air);
}

void Link::fly(SessionTime due, SessionTime posted, Delivery delivery, std::vector<std::byte> bytes,
               Air& air) {
  air.push({due, from_, to_, sent_++, posted, delivery, std::move(bytes)});
}

void Link::count_delivered(const Flight& flight) {
  ++counters_.delivered;
  bytes_delivered_ += flight.bytes.size();
  if (flight.delivery != Delivery::Newest) return;
  const auto delay = static_cast<double>(flight.due - flight.posted);
  // Smoothed as transports do.
  delay_ = delay_ < 0.0 ? delay : delay_ + 0.125 * (delay - delay_);
}

void Link::set_options(SessionTime now, const LinkOptions& options, Air& air) {
  send_waiting(now, air);
  options_ = options;
}

/// Recall packets in transit: states are lost, reliable ones wait in front again.
void Link::recall(SessionTime now, Air& air) {
  std::vector<Flight> flights = air.take(from_, to_);
  for (auto flight = flights.rbegin(); flight != flights.rend(); ++flight) {
    if (flight->delivery == Delivery::Newest) {
      ++counters_.cut;
    } else {
      waiting_.push_front({std::move(flight->bytes), flight->delivery, now});
    }
  }
}

void Link::cut(SessionTime now, Air& air) {
  if (cut_) return;
  send_waiting(now, air);
  cut_ = true;
  counters_.cut +=
      std::erase_if(waiting_, [](const Waiting& w) { return w.delivery == Delivery::Newest; });
  recall(now, air);
}

void Link::close(SessionTime now, std::string reason, Air& air) {
  send_waiting(now, air);
  recall(now, air);
  waiting_.clear();
  closed_ = std::move(reason);
}

void Link::heal(SessionTime now, Air& air) {
  if (open()) return;
  cut_ = false;
  closed_.clear();
  busy_until_ = std::max(busy_until_, now);
  send_waiting(now, air);
}

}  // namespace tandem::consensus
