// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "nats/server.h"
#include "support/catch.h"
#include "tandem/nats/nats_transport.h"

namespace tandem::nats::testing {

using consensus::Delivery;
using consensus::Packet;
using consensus::PeerId;
using consensus::PeerStatus;
using pbd::Vec3;
using tandem::testing::eventually;

inline net::Key session_key(std::uint8_t seed = 7) {
  net::Key key{};
  key.fill(seed);
  return key;
}

inline NatsOptions options_of(std::uint16_t port, PeerId self) {
  NatsOptions out;
  out.server.servers = {{"127.0.0.1", port}};
  out.member.self = self;
  out.member.scene_hash = 42;
  out.member.session_key = session_key();
  out.member.kbit_per_s = 4000.0;
  out.member.idle_timeout = std::chrono::milliseconds(15000);
  out.cells.presence_hz = 10.0;
  return out;
}

inline PeerStatus status_of(const NatsTransport& transport, PeerId peer) {
  for (const PeerStatus& each : transport.peers()) {
    if (each.id == peer) return each;
  }
  return {};
}

inline bool linked(const NatsTransport& a, const NatsTransport& b) {
  return status_of(a, b.self()).connected && status_of(b, a.self()).connected;
}

inline std::vector<std::byte> numbered(std::uint64_t value, std::size_t length = 8) {
  std::vector<std::byte> out(length);
  std::memcpy(out.data(), &value, sizeof value);
  return out;
}
inline std::uint64_t number_of(const Packet& packet) {
  std::uint64_t out = ~std::uint64_t{0};
  if (packet.bytes.size() >= sizeof out) std::memcpy(&out, packet.bytes.data(), sizeof out);
  return out;
}

}  // namespace tandem::nats::testing
