// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "stream_protection.h"

#include "octets.h"
#include "tandem/pbd/bytes.h"
#include "wire.h"

namespace tandem::net {

namespace {

static_assert(kSealBytes == crypto::kTagBytes);

constexpr std::size_t kLengthBytes = 4;
constexpr std::byte kRekey{static_cast<std::uint8_t>(FrameType::Rekey)};

}  // namespace

bool StreamSealer::seal(std::span<const std::byte> frames, std::int64_t now,
                        std::vector<std::byte>& out) {
  while (!frames.empty()) {
    if (key_.is_worn(now)) {
      if (!seal_one(std::span(&kRekey, 1), out)) return false;
      key_.renew(now);
    }
    const std::size_t length = pbd::ByteReader(frames).u32();
    if (!seal_one(frames.subspan(kLengthBytes, length), out)) return false;
    frames = frames.subspan(kLengthBytes + length);
  }
  return true;
}

bool StreamSealer::seal_one(std::span<const std::byte> body, std::vector<std::byte>& out) {
  if (key_.next_sequence() == 0) return false;
  const std::size_t at = out.size();
  pbd::ByteWriter(out).u32(static_cast<std::uint32_t>(body.size() + kSealBytes));
  out.resize(at + kLengthBytes + body.size() + kSealBytes);
  const std::span<std::byte> frame = std::span(out).subspan(at);
  key_.seal(frame.first(kLengthBytes), body, frame.subspan(kLengthBytes));
  return true;
}

StreamOpener::StreamOpener(const crypto::Secret& key, std::uint64_t first_sequence)
    : key_(key), next_(first_sequence) {
  crypto::initialise();
}

std::optional<std::span<const std::byte>> StreamOpener::open(std::span<const std::byte> frame) {
  if (broken_ || next_ == 0 || frame.size() <= kLengthBytes + kSealBytes) {
    broken_ = true;
    return {};
  }
  plain_.resize(frame.size() - kLengthBytes - kSealBytes);
  if (!crypto::open(key_, next_, octets(frame.first(kLengthBytes)),
                    octets(frame.subspan(kLengthBytes)), octets(std::span(plain_)))) {
    broken_ = true;
    return {};
  }
  ++next_;
  if (plain_.size() == 1 && plain_.front() == kRekey) {
    key_ = crypto::next_key(key_);
    ++epoch_;
    return std::span<const std::byte>();
  }
  return std::span<const std::byte>(plain_);
}

}  // namespace tandem::net
