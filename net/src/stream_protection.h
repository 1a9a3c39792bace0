// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "crypto.h"
#include "packet_protection.h"

namespace tandem::net {

// Sealed frames of a stream (wire.h). Each authenticates the length before it. A stream neither
// loses nor reorders, so sequence numbers are implicit: each frame is opened under its expected
// number. A frame of type Rekey is the last one under its key.

/// Seals what one end of a stream sends.
class StreamSealer {
 public:
  StreamSealer(const crypto::Secret& key, std::int64_t now, const RekeyPolicy& policy = {},
               std::uint64_t first_sequence = 1)
      : key_(key, now, policy, first_sequence) {}

  /// Appends `frames`, whole ones as made by append_frame(), and Rekey frames as needed. False if
  /// the numbers have run out: then the connection is over.
  [[nodiscard]] bool seal(std::span<const std::byte> frames, std::int64_t now,
                          std::vector<std::byte>& out);
  std::uint64_t epoch() const { return key_.epoch(); }

 private:
  bool seal_one(std::span<const std::byte> body, std::vector<std::byte>& out);

  SealingKey key_;
};

/// Opens what the other end has sealed.
class StreamOpener {
 public:
  explicit StreamOpener(const crypto::Secret& key, std::uint64_t first_sequence = 1);
  StreamOpener(const StreamOpener&) = delete;
  StreamOpener& operator=(const StreamOpener&) = delete;

  /// `frame` is a whole one with its length. Returns type and payload, in a buffer that the next
  /// call overwrites; empty if the frame was for this object alone. None, then and ever after, if
  /// it is not what the other end sealed at this place.
  std::optional<std::span<const std::byte>> open(std::span<const std::byte> frame);
  std::uint64_t epoch() const { return epoch_; }

 private:
  crypto::Secret key_;
  std::uint64_t next_;
  std::uint64_t epoch_ = 0;
  bool broken_ = false;
  std::vector<std::byte> plain_;
};

}  // namespace tandem::net
