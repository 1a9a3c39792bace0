// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "tandem/consensus/transport.h"
#include "tandem/net/membership.h"

namespace tandem::net {

// The four datagrams of a handshake, little-endian; docs/protocol.md has the tables. In every
// version they begin with
//   u8 type,  u32 magic,  u16 version,  u64 nonce of the initiator
// so that a mismatch can be reported.

constexpr std::uint32_t kUdpMagic = 0x55444e54;  // "TNDU"
constexpr std::uint16_t kUdpVersion = 4;
constexpr std::size_t kHandshakeHeader = 1 + 4 + 2 + 8;
constexpr std::size_t kCookieBytes = 8 + 16;
constexpr std::size_t kHelloBytes = 64;  // padded: no answer is longer
constexpr std::size_t kMaxNoiseMessage = 512;

enum class HandshakeType : std::uint8_t { Hello = 1, Challenge = 2, Initiate = 3, Accept = 4 };

using Cookie = std::array<std::uint8_t, kCookieBytes>;

struct HandshakePacket {
  HandshakeType type{};
  std::uint16_t version = kUdpVersion;
  std::uint64_t nonce = 0;
  Cookie cookie{};                        // of Challenge and Initiate
  std::span<const std::uint8_t> noise{};  // of Initiate and Accept; a view into the datagram
};

/// Replaces `datagram`.
void encode(const HandshakePacket& packet, std::vector<std::byte>& datagram);
/// None if it is no handshake. For another version only type, version and nonce are set.
std::optional<HandshakePacket> decode_handshake(std::span<const std::byte> datagram);

enum class Verdict : std::uint8_t {
  Welcome = 0,
  SceneDiffers = 1,
  SameId = 2,      // both ends have the same peer id
  NotTrusted = 3,  // the peer has another public key, or is not listed
  Full = 4,
  OnHold = 5,     // dropped recently
  Outdated = 6,   // a later process of the same peer is connected
  NotSigned = 7,  // no certificate of the organiser for id and key
  Expired = 8,    // the certificate has expired
  Revoked = 9,    // by the organiser
  NoWork = 10,    // the work for the id is missing
  Taken = 11,     // another key uses the id
  Unbound = 12,   // behind a relay, without proof of the id
};
const char* describe(Verdict verdict);

/// Proof of the right to an id, see Credentials. Fixed length.
struct Badge {
  std::uint64_t stamp = 0;
  std::array<std::byte, kCertificateBytes> certificate{};  // zeros: none

  bool has_certificate() const { return certificate != std::array<std::byte, kCertificateBytes>{}; }
};

constexpr std::size_t kBadgeBytes = 8 + kCertificateBytes;

void encode(const Badge& badge, std::vector<std::byte>& out);
/// None if the length is wrong.
std::optional<Badge> decode_badge(std::span<const std::byte> bytes);

/// What each end reports about itself, sealed.
struct Introduction {
  consensus::PeerId peer = 0;
  std::uint64_t incarnation = 0;
  std::uint64_t scene_hash = 0;
  std::uint32_t receiver = 0;  // receiver number for packets to it; 0 if it refuses
  std::uint32_t idle_timeout_ms = 0;
  Verdict verdict = Verdict::Welcome;  // of the responder
  Badge badge;
};

constexpr std::size_t kIntroductionBytes = 8 + 8 + 8 + 4 + 4 + 1 + kBadgeBytes;

std::vector<std::uint8_t> encode(const Introduction& introduction);
std::optional<Introduction> decode_introduction(std::span<const std::uint8_t> bytes);

}  // namespace tandem::net
