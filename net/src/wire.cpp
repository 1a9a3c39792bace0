// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "wire.h"

#include <algorithm>

namespace tandem::net {

void encode(pbd::ByteWriter& writer, const Hello& hello) {
  writer.u32(kMagic);
  writer.u16(hello.version);
  writer.u64(hello.peer);
  writer.u64(hello.incarnation);
  writer.u64(hello.scene_hash);
  writer.u32(hello.max_message_bytes);
  writer.u32(hello.idle_timeout_ms);
  writer.u16(hello.listen_port);
}

std::optional<Hello> decode_hello(std::span<const std::byte> payload) {
  pbd::ByteReader reader(payload);
  if (reader.u32() != kMagic) return {};
  Hello hello;
  hello.version = reader.u16();
  hello.peer = reader.u64();
  if (reader.failed() || hello.peer == 0) return {};
  if (hello.version != kProtocolVersion) return hello;
  hello.incarnation = reader.u64();
  hello.scene_hash = reader.u64();
  hello.max_message_bytes = reader.u32();
  hello.idle_timeout_ms = reader.u32();
  hello.listen_port = reader.u16();
  if (reader.failed() || reader.remaining() != 0 || hello.incarnation == 0) return {};
  return hello;
}

void encode(pbd::ByteWriter& writer, const Welcome& welcome) {
  writer.u64(welcome.ticket);
  writer.u64(welcome.received);
}

std::optional<Welcome> decode_welcome(std::span<const std::byte> payload) {
  pbd::ByteReader reader(payload);
  Welcome welcome;
  welcome.ticket = reader.u64();
  welcome.received = reader.u64();
  if (reader.failed() || reader.remaining() != 0) return {};
  return welcome;
}

void encode(pbd::ByteWriter& writer, std::span<const PeerAddress> addresses) {
  for (const PeerAddress& address : addresses) {
    writer.u64(address.peer);
    for (const std::uint8_t byte : address.ip) writer.u8(byte);
    writer.u16(address.port);
  }
}

std::optional<std::vector<PeerAddress>> decode_addresses(std::span<const std::byte> payload) {
  constexpr std::size_t kEntry = 8 + 16 + 2;
  if (payload.size() % kEntry != 0 || payload.size() > kMaxAddresses * kEntry) return {};
  pbd::ByteReader reader(payload);
  std::vector<PeerAddress> addresses(payload.size() / kEntry);
  for (PeerAddress& address : addresses) {
    address.peer = reader.u64();
    for (std::uint8_t& byte : address.ip) byte = reader.u8();
    address.port = reader.u16();
  }
  return addresses;
}

void encode(pbd::ByteWriter& writer, const KeyFrame& frame) {
  writer.u32(kKeyMagic);
  writer.u16(frame.version);
  writer.bytes(frame.message);
}

std::optional<KeyFrame> decode_key_frame(std::span<const std::byte> payload) {
  pbd::ByteReader reader(payload);
  if (reader.u32() != kKeyMagic) return {};
  KeyFrame frame;
  frame.version = reader.u16();
  if (reader.failed()) return {};
  frame.message = payload.last(reader.remaining());
  return frame;
}

std::string decode_reason(std::span<const std::byte> payload) {
  std::string text;
  for (const std::byte byte : payload.first(std::min(payload.size(), kMaxReason))) {
    const char c = static_cast<char>(byte);
    text += c >= ' ' && c <= '~' ? c : '?';
  }
  return text;
}

void FrameBuffer::raise_limit(std::size_t max_payload) {
  max_length_ = 1 + max_payload;
  bytes_.resize(std::max(bytes_.size(), 4 + max_length_));
}

std::optional<FrameBuffer::Frame> FrameBuffer::next() {
  const auto frame = next_whole(1);
  if (!frame) return {};
  return Frame{static_cast<FrameType>((*frame)[4]), frame->subspan(kFrameHeader)};
}

std::optional<std::span<const std::byte>> FrameBuffer::next_whole(std::size_t least) {
  if (bad()) return {};
  const std::size_t had = end_ - begin_;
  if (had >= 4) {
    std::size_t length = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      length |= std::to_integer<std::size_t>(bytes_[begin_ + i]) << (8 * i);
    }
    if (length < least || length > max_length_) {
      error_ = "frame of length " + std::to_string(length) + ", must be " + std::to_string(least) +
               " to " + std::to_string(max_length_);
      return {};
    }
    if (had >= 4 + length) {
      const std::span<const std::byte> frame(bytes_.data() + begin_, 4 + length);
      begin_ += 4 + length;
      return frame;
    }
  }
  // A whole frame fits from the start of the buffer, so this makes room to read.
  std::copy(bytes_.begin() + static_cast<std::ptrdiff_t>(begin_),
            bytes_.begin() + static_cast<std::ptrdiff_t>(end_), bytes_.begin());
  end_ = had;
  begin_ = 0;
  return {};
}

}  // namespace tandem::net
