// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "stream_protection.h"

#include "octets.h"
#include "require.h"
#include "tandem/pbd/bytes.h"
#include "wire.h"

namespace tandem::net {

namespace {

static_assert(kSealBytes == crypto::kTagBytes);

constexpr std::size_t kLengthBytes = 4;
constexpr std::byte kRekey{static_cast<std::uint8_t>(FrameType::Rekey)};

}  // namespace

StreamSealer::StreamSealer(const crypto::Secret& key, std::int64_t now, const RekeyPolicy& policy,
                           std::uint64_t first_sequence)
    : key_(key), policy_(policy), next_(first_sequence), epoch_start_(now) {
  crypto::initialise();
  require(policy.packets > 0, "RekeyPolicy", "packets", policy.packets, "> 0");
  require(policy.period > 0, "RekeyPolicy", "period", policy.period, "> 0 ns");
  require(first_sequence > 0, "StreamSealer", "first_sequence", first_sequence, "> 0");
}

bool StreamSealer::seal(std::span<const std::byte> frames, std::int64_t now,
                        std::vector<std::byte>& out) {
  while (!frames.empty()) {
    if (frames_ >= policy_.packets || now - epoch_start_ >= policy_.period) {
      if (!seal_one(std::span(&kRekey, 1), out)) return false;
      key_ = crypto::next_key(key_);
      ++epoch_;
      frames_ = 0;
      epoch_start_ = now;
    }
    const std::size_t length = pbd::ByteReader(frames).u32();
    if (!seal_one(frames.subspan(kLengthBytes, length), out)) return false;
    ++frames_;
    frames = frames.subspan(kLengthBytes + length);
  }
  return true;
}

bool StreamSealer::seal_one(std::span<const std::byte> body, std::vector<std::byte>& out) {
  if (next_ == 0) return false;
  const std::size_t at = out.size();
  pbd::ByteWriter(out).u32(static_cast<std::uint32_t>(body.size() + kSealBytes));
  out.resize(at + kLengthBytes + body.size() + kSealBytes);
  const std::span<std::byte> frame = std::span(out).subspan(at);
  crypto::seal(key_, next_, octets(std::span<const std::byte>(frame.first(kLengthBytes))),
               octets(body), octets(frame.subspan(kLengthBytes)));
  ++next_;  // to 0 after the last one
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
