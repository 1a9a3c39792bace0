// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tandem/consensus/transport.h"
#include "tandem/pbd/bytes.h"

namespace tandem::net {

using consensus::PeerId;

// The stream, little-endian:  u32 length | u8 type | payload,  length = 1 + payload bytes; with a
// session key type and payload are sealed after KeyRequest and KeyReply, docs/protocol.md ("TCP").
// Both ends send Hello and check the other's. The peer with the lower id then sends Welcome, the
// other one answers with Welcome, and both are connected. Addresses of third peers follow. Magic,
// version and peer id have the same place in every version, so that a refusal can be explained.

constexpr std::uint32_t kMagic = 0x4d444e54;  // "TNDM"
constexpr std::uint16_t kProtocolVersion = 1;
constexpr std::uint32_t kKeyMagic = 0x4b444e54;  // "TNDK"
constexpr std::uint16_t kKeyVersion = 2;
constexpr std::size_t kFrameHeader = 5;         // length and type
constexpr std::size_t kSealBytes = 16;          // of tag
constexpr std::size_t kMaxKeyFrame = 320;       // payload before there are keys
constexpr std::size_t kReliableHeader = 8;      // sequence number
constexpr std::size_t kMaxControlFrame = 4096;  // payload of all but Newest and Reliable
constexpr std::size_t kMaxAddresses = 128;      // in one frame
constexpr std::size_t kMaxReason = 256;         // bytes of text

enum class FrameType : std::uint8_t {
  Hello = 1,
  Welcome = 2,
  Goodbye = 3,
  Addresses = 4,
  Ping = 5,
  Ack = 6,
  Newest = 7,
  Reliable = 8,
  KeyRequest = 9,
  KeyReply = 10,
  Rekey = 11,  // sealed: the last frame under its key
  GroupChange = 12,
};

struct Hello {
  std::uint16_t version = kProtocolVersion;
  PeerId peer = 0;
  std::uint64_t incarnation = 0;
  std::uint64_t scene_hash = 0;
  std::uint32_t max_message_bytes = 0;
  std::uint32_t idle_timeout_ms = 0;
  std::uint16_t listen_port = 0;  // 0 = does not listen
};

struct Welcome {
  std::uint64_t ticket = 0;    // of the lower id; of two connections the highest one is kept
  std::uint64_t received = 0;  // last Reliable sequence number from the addressee
};

struct PeerAddress {
  PeerId peer = 0;
  std::array<std::uint8_t, 16> ip{};  // IPv6, or IPv4 mapped into it
  std::uint16_t port = 0;
};

/// Contents of KeyRequest and KeyReply. Magic and version have the same place in every version.
struct KeyFrame {
  std::uint16_t version = kKeyVersion;
  std::span<const std::byte> message;  // of Noise; a view into the payload
};

/// Appends one frame; `fill` writes the payload through a pbd::ByteWriter.
template <class Fill>
void append_frame(std::vector<std::byte>& out, FrameType type, Fill&& fill) {
  const std::size_t start = out.size();
  pbd::ByteWriter writer(out);
  writer.u32(0);
  writer.u8(static_cast<std::uint8_t>(type));
  fill(writer);
  const auto length = static_cast<std::uint32_t>(out.size() - start - 4);
  for (std::size_t i = 0; i < 4; ++i) out[start + i] = static_cast<std::byte>(length >> (8 * i));
}

void encode(pbd::ByteWriter& writer, const Hello& hello);
void encode(pbd::ByteWriter& writer, const Welcome& welcome);
void encode(pbd::ByteWriter& writer, std::span<const PeerAddress> addresses);
void encode(pbd::ByteWriter& writer, const KeyFrame& frame);

/// For a Hello of another version only version and peer are set. None if it is no Hello.
std::optional<Hello> decode_hello(std::span<const std::byte> payload);
std::optional<Welcome> decode_welcome(std::span<const std::byte> payload);
std::optional<std::vector<PeerAddress>> decode_addresses(std::span<const std::byte> payload);
std::optional<KeyFrame> decode_key_frame(std::span<const std::byte> payload);
/// Printable ASCII, at most kMaxReason bytes, as it is shown in logs and on terminals.
std::string decode_reason(std::span<const std::byte> payload);

/// Splits a stream into frames, in a buffer whose size depends on the limit alone, never on a
/// received length.
class FrameBuffer {
 public:
  struct Frame {
    FrameType type{};
    std::span<const std::byte> payload;  // valid until the next call of a non-const member
  };

  explicit FrameBuffer(std::size_t max_payload) { raise_limit(max_payload); }
  void raise_limit(std::size_t max_payload);

  /// Room to read into, never empty once next() has returned nothing.
  std::span<std::byte> space() { return std::span(bytes_).subspan(end_); }
  void filled(std::size_t count) { end_ += count; }
  /// The next whole frame. None: read more, or the stream is bad() for good.
  std::optional<Frame> next();
  /// next() with the length before the frame, and at least `least` bytes after it; valid as
  /// Frame::payload.
  std::optional<std::span<const std::byte>> next_whole(std::size_t least);
  /// Drops unread bytes, and clears bad().
  void discard() {
    begin_ = end_ = 0;
    error_.clear();
  }
  bool bad() const { return !error_.empty(); }
  const std::string& error() const { return error_; }

 private:
  std::vector<std::byte> bytes_;
  std::size_t begin_ = 0;
  std::size_t end_ = 0;
  std::size_t max_length_ = 0;  // type and payload
  std::string error_;
};

}  // namespace tandem::net
