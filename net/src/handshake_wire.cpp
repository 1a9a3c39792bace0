// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "handshake_wire.h"

#include <algorithm>

#include "octets.h"
#include "tandem/pbd/bytes.h"

namespace tandem::net {

void encode(const HandshakePacket& packet, std::vector<std::byte>& datagram) {
  datagram.clear();
  pbd::ByteWriter writer(datagram);
  writer.u8(static_cast<std::uint8_t>(packet.type));
  writer.u32(kUdpMagic);
  writer.u16(packet.version);
  writer.u64(packet.nonce);
  const bool has_cookie =
      packet.type == HandshakeType::Challenge || packet.type == HandshakeType::Initiate;
  const bool has_noise =
      packet.type == HandshakeType::Initiate || packet.type == HandshakeType::Accept;
  if (has_cookie) writer.bytes(as_bytes(packet.cookie));
  if (has_noise) writer.bytes(as_bytes(packet.noise));
  if (packet.type == HandshakeType::Hello) datagram.resize(kHelloBytes);
}

std::optional<HandshakePacket> decode_handshake(std::span<const std::byte> datagram) {
  pbd::ByteReader reader(datagram);
  HandshakePacket packet;
  const std::uint8_t type = reader.u8();
  if (type < 1 || type > 4 || reader.u32() != kUdpMagic) return {};
  packet.type = static_cast<HandshakeType>(type);
  packet.version = reader.u16();
  packet.nonce = reader.u64();
  if (reader.failed()) return {};
  // For any version: a short question gets no answer.
  if (packet.type == HandshakeType::Hello) {
    return datagram.size() == kHelloBytes ? std::optional(packet) : std::nullopt;
  }
  if (packet.version != kUdpVersion) return packet;
  if (packet.type != HandshakeType::Accept) {
    const auto cookie = octets(reader.bytes(kCookieBytes));
    if (reader.failed()) return {};
    std::copy(cookie.begin(), cookie.end(), packet.cookie.begin());
  }
  packet.noise = octets(datagram.last(reader.remaining()));
  const bool has_noise = packet.type != HandshakeType::Challenge;
  if (has_noise == packet.noise.empty() || packet.noise.size() > kMaxNoiseMessage) return {};
  return packet;
}

const char* describe(Verdict verdict) {
  switch (verdict) {
    case Verdict::Welcome:
      return "welcome";
    case Verdict::SceneDiffers:
      return "scene hash differs";
    case Verdict::SameId:
      return "peer id is used by both ends";
    case Verdict::NotTrusted:
      return "public key is not that of the peer";
    case Verdict::Full:
      return "session full";
    case Verdict::OnHold:
      return "dropped a moment ago";
    case Verdict::Outdated:
      return "a later process of this peer is there";
    case Verdict::NotSigned:
      return "no certificate of the organiser for this id and key";
    case Verdict::Expired:
      return "certificate has expired";
    case Verdict::Revoked:
      return "revoked by the organiser";
    case Verdict::NoWork:
      return "work for the peer id is missing";
    case Verdict::Taken:
      return "another key goes by this peer id";
    case Verdict::Unbound:
      return "relayed, and nothing shows whose id it is";
  }
  return "unknown";
}

void encode(const Badge& badge, std::vector<std::byte>& out) {
  pbd::ByteWriter writer(out);
  writer.u64(badge.stamp);
  writer.bytes(badge.certificate);
}

std::optional<Badge> decode_badge(std::span<const std::byte> bytes) {
  if (bytes.size() != kBadgeBytes) return {};
  pbd::ByteReader reader(bytes);
  Badge out;
  out.stamp = reader.u64();
  std::ranges::copy(reader.bytes(kCertificateBytes), out.certificate.begin());
  return out;
}

std::vector<std::uint8_t> encode(const Introduction& introduction) {
  std::vector<std::byte> bytes;
  pbd::ByteWriter writer(bytes);
  writer.u64(introduction.peer);
  writer.u64(introduction.incarnation);
  writer.u64(introduction.scene_hash);
  writer.u32(introduction.receiver);
  writer.u32(introduction.idle_timeout_ms);
  writer.u8(static_cast<std::uint8_t>(introduction.verdict));
  encode(introduction.badge, bytes);
  const auto view = octets(std::span<const std::byte>(bytes));
  return {view.begin(), view.end()};
}

std::optional<Introduction> decode_introduction(std::span<const std::uint8_t> bytes) {
  pbd::ByteReader reader(as_bytes(bytes));
  Introduction out;
  out.peer = reader.u64();
  out.incarnation = reader.u64();
  out.scene_hash = reader.u64();
  out.receiver = reader.u32();
  out.idle_timeout_ms = reader.u32();
  const std::uint8_t verdict = reader.u8();
  if (reader.failed()) return {};
  const auto badge = decode_badge(as_bytes(bytes).last(reader.remaining()));
  if (!badge) return {};
  out.badge = *badge;
  if (out.peer == 0 || out.incarnation == 0) return {};
  if (verdict > static_cast<std::uint8_t>(Verdict::Unbound)) return {};
  out.verdict = static_cast<Verdict>(verdict);
  if ((out.receiver == 0) != (out.verdict != Verdict::Welcome)) return {};
  return out;
}

}  // namespace tandem::net
