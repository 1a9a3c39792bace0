// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace tandem::room {

using Bytes = std::vector<std::uint8_t>;
using View = std::span<const std::uint8_t>;
using MemberId = std::uint64_t;  ///< drawn by the member at each start, never 0

/// Fills with unpredictable bytes.
using Random = std::function<void(std::span<std::uint8_t>)>;

constexpr std::size_t kKeyBytes = 32;
constexpr std::size_t kMaxPlainBytes = 62 * 1024;
constexpr std::size_t kMaxProfileBytes = 512;

/// Messages between a room's members, sealed with the room's key, which servers never have. The
/// page runs this code too (tools/room/README.md, "What is sealed").
///
///     hello   u8 1 | 24 nonce | sealed by the room's key: 16 life, profile
///     packet  u8 2 | u64 counter, from 1 | sealed by the key of sender and receiver: bytes
///
/// A member draws its id and its `life` at each start. The key from a to b is BLAKE2b of both ids
/// and lives under the room's key, so that recordings of other lives open nothing. Each id has one
/// life and is never forgotten, so no counter is used twice with one key. Hellos are
/// XChaCha20-Poly1305, packets ChaCha20-Poly1305 (IETF) with the counter as nonce; sender, receiver
/// and room are authenticated data.
/// @par Thread safety  Distinct objects: safe. One object: one thread at a time.
class Cipher {
 public:
  /// @param room  its name: keys of different rooms are independent
  /// @throws std::invalid_argument if the key does not have 32 bytes or `self` is 0
  Cipher(View key, std::string_view room, MemberId self, Random random);
  ~Cipher();
  Cipher(const Cipher&) = delete;
  Cipher& operator=(const Cipher&) = delete;

  /// The message that introduces this member. @throws std::invalid_argument if the profile is too
  /// long
  Bytes hello(View profile) const;

  enum class Kind : std::uint8_t {
    Refused,  ///< not sealed by a member, not for this one, or a repetition
    Hello,    ///< `out` is the profile; a new member: answer with a hello
    Known,    ///< a repeated hello; `out` is the profile
    Packet,   ///< `out` has the bytes
  };
  Kind open(MemberId from, View sealed, Bytes& out);
  /// False if `to` has not sent a hello, or above kMaxPlainBytes.
  bool seal(MemberId to, View plain, Bytes& out);

  /// True once a packet of it was opened: a hello alone may be a recording.
  bool alive(MemberId id) const;

 private:
  static constexpr std::size_t kLifeBytes = 16;
  static constexpr std::size_t kWindow = 4096;
  static constexpr std::size_t kMaxMembers = 4096;  ///< over the object's lifetime
  using Key = std::array<std::uint8_t, kKeyBytes>;
  using Life = std::array<std::uint8_t, kLifeBytes>;

  struct Member {
    Life life{};
    Key to{};
    Key from{};
    std::uint64_t sent = 0;
    std::uint64_t newest = 0;
    std::bitset<kWindow> seen;  ///< by counter modulo kWindow, the last kWindow up to `newest`
  };

  Kind open_hello(MemberId from, View sealed, Bytes& out);
  Kind open_packet(MemberId from, View sealed, Bytes& out);
  Key pair_key(MemberId from, const Life& from_life, MemberId to, const Life& to_life) const;
  Bytes context(std::uint8_t kind, MemberId from, MemberId to) const;
  static bool fresh(const Member& member, std::uint64_t counter);
  static void note(Member& member, std::uint64_t counter);

  Key key_{};
  std::string room_;
  MemberId self_;
  Random random_;
  Life life_{};
  std::map<MemberId, Member> members_;
};

}  // namespace tandem::room
