// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "crypto.h"
#include "replay_window.h"

namespace tandem::net {

// A protected packet, see docs/protocol.md:
//   u8 0x40 | epoch % 16,  u32 receiver,  u64 sequence,  sealed bytes,  16 bytes of tag.
// The header is authenticated. Each direction has its own keys.

constexpr std::size_t kMaxDatagram = 1472;     // bytes of UDP payload: Ethernet's 1500
constexpr std::size_t kMaxRelayed = 1200;      // of a datagram within another one
constexpr std::size_t kIpUdpBytes = 28;        // of IPv4 and UDP, before every datagram
constexpr std::uint8_t kProtectedType = 0x40;  // upper half of the first byte
constexpr std::uint8_t kRelayType = 0x50;      // contains a datagram of or for a third peer
constexpr std::size_t kProtectedHeader = 1 + 4 + 8;
constexpr std::size_t kProtectedOverhead = kProtectedHeader + crypto::kTagBytes;
constexpr std::size_t kRelayHeader = 1 + 8;  // direction and peer

struct ProtectedHeader {
  bool relay = false;
  std::uint8_t epoch = 0;      // modulo 16
  std::uint32_t receiver = 0;  // connection number of the receiver
  std::uint64_t sequence = 0;
};

/// None if it is no protected packet. Nothing is authenticated yet.
std::optional<ProtectedHeader> decode_protected_header(std::span<const std::byte> datagram);

/// When the sender changes to the next key.
struct RekeyPolicy {
  std::uint64_t packets = std::uint64_t{1} << 20;  // > 0
  std::int64_t period = 120'000'000'000;           // ns, > 0
};

/// Sealing key of one side. Sequence numbers start at 1 and are never reused: there is none after
/// the last one, and the object cannot be copied.
class SealingKey {
 public:
  SealingKey(const crypto::Secret& key, std::int64_t now, const RekeyPolicy& policy,
             std::uint64_t first_sequence);
  SealingKey(const SealingKey&) = delete;
  SealingKey& operator=(const SealingKey&) = delete;

  /// The number that the next seal() uses; 0 if none is left.
  std::uint64_t next_sequence() const { return next_; }
  std::uint64_t epoch() const { return epoch_; }
  /// Whether the next key is due.
  bool is_worn(std::int64_t now) const {
    return sealed_ >= policy_.packets || now - epoch_start_ >= policy_.period;
  }
  void renew(std::int64_t now);
  /// @pre next_sequence() > 0
  void seal(std::span<const std::byte> header, std::span<const std::byte> plain,
            std::span<std::byte> out);

 private:
  crypto::Secret key_;
  RekeyPolicy policy_;
  std::uint64_t next_;
  std::uint64_t epoch_ = 0;
  std::uint64_t sealed_ = 0;  // in this epoch
  std::int64_t epoch_start_;
};

/// Seals the packets that one side sends.
class PacketSealer {
 public:
  PacketSealer(const crypto::Secret& key, std::uint32_t receiver, std::int64_t now,
               const RekeyPolicy& policy = {}, std::uint64_t first_sequence = 1)
      : key_(key, now, policy, first_sequence), receiver_(receiver) {}

  std::uint64_t next_sequence() const { return key_.next_sequence(); }
  /// Replaces `datagram`. False if `plain` does not fit into kMaxDatagram or the numbers have run
  /// out: then the connection is over.
  [[nodiscard]] bool seal(std::span<const std::byte> plain, std::int64_t now,
                          std::vector<std::byte>& datagram, bool relay = false);
  std::uint64_t epoch() const { return key_.epoch(); }

 private:
  SealingKey key_;
  std::uint32_t receiver_;
};

/// Opens what the other side sealed. Tries the keys of the last epoch, of this one and of the next;
/// window and epoch move only once a packet is authenticated.
class PacketOpener {
 public:
  explicit PacketOpener(const crypto::Secret& key);
  PacketOpener(const PacketOpener&) = delete;
  PacketOpener& operator=(const PacketOpener&) = delete;

  struct Opened {
    std::uint64_t sequence = 0;
    bool relay = false;
    std::span<const std::byte> plain;  // in the caller's buffer
  };
  /// None: forged, damaged, repeated, too old, too long or too short. `buffer` is overwritten.
  std::optional<Opened> open(std::span<const std::byte> datagram, std::vector<std::byte>& buffer);

  struct Counters {
    std::uint64_t opened = 0;
    std::uint64_t malformed = 0;  // malformed, or of a distant epoch
    std::uint64_t replayed = 0;   // repeated or too old; not decrypted
    std::uint64_t forged = 0;     // authentication failed
  };
  const Counters& counters() const { return counters_; }
  const ReplayWindow& window() const { return window_; }
  std::uint64_t epoch() const { return epoch_; }

 private:
  crypto::Secret previous_;  // zero where has_previous_ is false
  crypto::Secret current_;
  crypto::Secret next_;
  bool has_previous_ = false;
  std::uint64_t epoch_ = 0;
  std::uint64_t epoch_first_ = 0;  // first number received in this epoch
  ReplayWindow window_;
  Counters counters_;
};

}  // namespace tandem::net
