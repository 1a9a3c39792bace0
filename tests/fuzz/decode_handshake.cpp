// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Datagrams of strangers, and what their proofs have inside.
#include "handshake_wire.h"
#include "octets.h"
#include "packet_protection.h"
#include "target.h"

namespace fuzz {

using namespace tandem::net;

void run(std::span<const std::byte> input) {
  (void)decode_protected_header(input);
  if (const auto packet = decode_handshake(input)) {
    require(packet->noise.size() <= kMaxNoiseMessage);
    if (packet->version == kUdpVersion) {
      Bytes again;
      encode(*packet, again);
      // A Hello's filling is not looked at.
      require(again.size() == input.size());
      require(packet->type == HandshakeType::Hello || std::ranges::equal(again, input));
    }
  }
  if (const auto introduction = decode_introduction(octets(input))) {
    require(introduction->peer != 0 && introduction->incarnation != 0);
    require(std::ranges::equal(encode(*introduction), octets(input)));
  }
}

std::vector<Bytes> seeds() {
  std::vector<Bytes> out;
  const std::vector<std::uint8_t> noise(129, 7);
  for (const auto type : {HandshakeType::Hello, HandshakeType::Challenge, HandshakeType::Initiate,
                          HandshakeType::Accept}) {
    HandshakePacket packet{.type = type, .nonce = 0x0102030405060708};
    if (type == HandshakeType::Initiate || type == HandshakeType::Accept) packet.noise = noise;
    encode(packet, out.emplace_back());
  }
  const auto introduction = encode(Introduction{
      .peer = 3, .incarnation = 4, .scene_hash = 5, .receiver = 6, .idle_timeout_ms = 5000});
  const auto view = as_bytes(introduction);
  out.emplace_back(view.begin(), view.end());
  return out;
}

}  // namespace fuzz
