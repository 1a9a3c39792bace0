// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "measures/link_probe.h"

#include <cmath>

#include "tandem/pbd/bytes.h"

namespace tandem::demos {

std::vector<double> link_latencies(const consensus::LinkOptions& link, double rate, double seconds,
                                   std::uint64_t seed) {
  using consensus::SessionTime;
  constexpr SessionTime kLook = 100'000;  // ns
  consensus::VirtualNetwork network(link, seed, 0);
  consensus::Transport& from = network.transport(1);
  consensus::Transport& to = network.transport(2);
  const auto packets = static_cast<std::int64_t>(std::ceil(rate * seconds));
  const auto end = static_cast<SessionTime>(1e9 * (seconds + 10.0 * link.latency + 1.0));
  std::vector<double> result;
  std::vector<std::byte> bytes;
  std::vector<consensus::Packet> arrived;
  std::int64_t sent = 0;
  for (SessionTime now = 0; now < end; now += kLook) {
    network.advance_to(now);
    arrived.clear();
    to.drain(arrived);
    for (const consensus::Packet& packet : arrived) {
      pbd::ByteReader in(packet.bytes);
      result.push_back(1e-6 * static_cast<double>(now - static_cast<SessionTime>(in.u64())));
    }
    while (sent < packets && static_cast<double>(sent) * 1e9 <= rate * static_cast<double>(now)) {
      bytes.clear();
      pbd::ByteWriter(bytes).u64(static_cast<std::uint64_t>(now));
      from.post(2, bytes, consensus::Delivery::Newest);
      ++sent;
    }
  }
  return result;
}

}  // namespace tandem::demos
