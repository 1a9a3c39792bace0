// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/consensus/virtual_network.h"

#include <array>
#include <cstddef>
#include <cstdio>
#include <vector>

// A packet that takes 50 ms.
int main() {
  using namespace tandem::consensus;
  VirtualNetwork network({.latency = 0.05});
  Transport& from = network.transport(1);
  Transport& to = network.transport(2);
  const std::array<std::byte, 1> bytes{std::byte{42}};
  if (!from.post(2, bytes, Delivery::Newest)) return 1;
  std::vector<Packet> packets;
  network.advance_to(49'999'999);
  to.drain(packets);
  if (!packets.empty()) return 1;
  network.advance_to(50'000'000);
  to.drain(packets);
  std::printf("virtual_network: %zu packet after 50 ms\n", packets.size());
  return packets.size() == 1 && packets[0].bytes[0] == bytes[0] ? 0 : 1;
}
