// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "tandem/consensus/virtual_network.h"

namespace tandem::consensus::testing {

inline constexpr SessionTime kMs = 1'000'000;

/// A packet of `size` bytes that carries a number.
inline std::vector<std::byte> numbered(int number, std::size_t size = 4) {
  std::vector<std::byte> bytes(size);
  for (std::size_t i = 0; i < 4; ++i) {
    bytes[i] = static_cast<std::byte>(static_cast<unsigned>(number) >> (8 * i));
  }
  return bytes;
}

inline int number_of(std::span<const std::byte> bytes) {
  unsigned number = 0;
  for (std::size_t i = 0; i < 4; ++i) number |= std::to_integer<unsigned>(bytes[i]) << (8 * i);
  return static_cast<int>(number);
}

struct Arrival {
  int number = 0;
  SessionTime delay = 0;  ///< ns since it was posted
  friend bool operator==(const Arrival&, const Arrival&) = default;
};

/// Post numbered packets from peer 1 to peer 2 every `period` and note when each arrives.
inline std::vector<Arrival> run_stream(const LinkOptions& options, std::uint64_t seed, int count,
                                       SessionTime period, Delivery delivery,
                                       LinkCounters* counters = nullptr) {
  VirtualNetwork network(options, seed);
  Transport& a = network.transport(1);
  Transport& b = network.transport(2);
  std::vector<Arrival> arrivals;
  std::vector<Packet> packets;
  const auto collect = [&] {
    packets.clear();
    b.drain(packets);
    for (const Packet& packet : packets) {
      const int number = number_of(packet.bytes);
      arrivals.push_back({number, network.now() - number * period});
    }
  };
  const auto run_to = [&](SessionTime end) {
    for (auto next = network.next_event(); next && *next <= end; next = network.next_event()) {
      network.advance_to(*next);
      collect();
    }
    network.advance_to(end);
  };
  for (int i = 0; i < count; ++i) {
    run_to(i * period);
    a.post(2, numbered(i, 50), delivery);
  }
  run_to(count * period + 3600'000 * kMs);
  if (counters != nullptr) *counters = network.counters(1, 2);
  return arrivals;
}

}  // namespace tandem::consensus::testing
