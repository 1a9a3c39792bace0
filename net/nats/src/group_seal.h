// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "credentials.h"
#include "crypto.h"
#include "tandem/consensus/transport.h"

namespace tandem::nats {

// What one member says to all at once, sealed under the session key: the server reads nothing and
// invents nothing. Whoever has the session key could have sealed it, in anybody's name:
//   u8 version, u64 sender, 8 bytes of salt, u64 number, sealed bytes, 16 bytes of tag.
// Each process of a sender has a key of its own, made of the session key, its id and its salt, so
// that no number is used twice with one key. The header is authenticated.

constexpr std::size_t kGroupHeader = 1 + 8 + 8 + 8;
constexpr std::size_t kGroupOverhead = kGroupHeader + net::crypto::kTagBytes;

class GroupSealer {
 public:
  GroupSealer(const net::crypto::Secret& session_key, consensus::PeerId self,
              const net::crypto::Random& random);

  /// Replaces `out`.
  void seal(std::span<const std::byte> plain, std::vector<std::byte>& out);

 private:
  consensus::PeerId self_;
  std::array<std::uint8_t, 8> salt_{};
  net::crypto::Secret key_;
  std::uint64_t next_ = 1;
};

class GroupOpener {
 public:
  static constexpr std::size_t kMaxSenders = 4096;  ///< the longest silent one goes for a new one

  struct Opened {
    consensus::PeerId sender = 0;
    std::span<const std::byte> plain;  ///< until the next call
  };
  /// None: malformed, forged, of another session key, or had before. The former keys of a group
  /// that has changed are good here.
  std::optional<Opened> open(std::span<const std::byte> message,
                             const net::Credentials& credentials);
  std::uint64_t refused() const { return refused_; }
  std::size_t senders() const { return senders_.size(); }

 private:
  struct Sender {
    std::array<std::uint8_t, 8> salt{};
    net::crypto::Secret key;
    std::uint64_t group = 0;   ///< of the change by which the key was made
    std::uint64_t latest = 0;  ///< number
    std::uint64_t heard = 0;   ///< the later, the larger
  };
  bool open_with(const net::crypto::Secret& key, std::span<const std::byte> message,
                 std::uint64_t number);
  Sender& remember(consensus::PeerId sender);

  std::map<consensus::PeerId, Sender> senders_;
  std::uint64_t turn_ = 0;
  std::uint64_t refused_ = 0;
  std::vector<std::byte> plain_;
};

}  // namespace tandem::nats
