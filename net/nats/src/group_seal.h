// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "credentials.h"
#include "crypto.h"
#include "tandem/consensus/transport.h"

namespace tandem::nats {

// A member's message to all, sealed under the session key: the server can neither read nor forge
// it. Any owner of the session key could have sealed it, in any name:
//   u8 version, u64 sender, u64 incarnation, 8 bytes of salt, i64 time, sealed bytes, 16 bytes of
//   tag.
// Each process of a sender has its own key, derived from the session key, its id and its salt. The
// time, in ns, is its system clock's at its start, continued by its steady clock; it increases with
// each message, so that no number is used twice with one key. The header is authenticated.

constexpr std::size_t kGroupHeader = 1 + 8 + 8 + 8 + 8;
constexpr std::size_t kGroupOverhead = kGroupHeader + net::crypto::kTagBytes;

class GroupSealer {
 public:
  /// @param incarnation  of this process, as in handshakes
  GroupSealer(consensus::PeerId self, std::uint64_t incarnation, const net::crypto::Random& random);

  /// Replaces `out`. @param time  ns; if it has not increased, 1 ns is added to the last one
  void seal(std::span<const std::byte> plain, const net::crypto::Secret& session_key,
            std::int64_t time, std::vector<std::byte>& out);
  /// Whether this sealer has made a message that was opened.
  bool has_sealed(std::span<const std::byte> message) const;

 private:
  consensus::PeerId self_;
  std::uint64_t incarnation_;
  std::array<std::uint8_t, 8> salt_{};
  std::int64_t latest_ = 0;
};

/// Sender and contents of a record. Opening stores nothing and can be repeated.
struct OpenedRecord {
  consensus::PeerId sender = 0;
  std::vector<std::byte> plain;
};
/// None: malformed, forged, of another session key.
std::optional<OpenedRecord> open_group_record(std::span<const std::byte> message,
                                              const net::crypto::Secret& session_key);

/// Opens each message once. From a connected sender only those of the connected process; from any
/// other sender those at most kMaxAge old by its clock, each later than the one before. Clocks of
/// hosts may differ: the offset is learned while the sender is connected.
class GroupOpener {
 public:
  static constexpr std::size_t kMaxSenders = 4096;  ///< the one silent for the longest is replaced
  static constexpr std::int64_t kMaxAge = 4'000'000'000;  ///< ns; also the largest lead

  enum class Heard : std::uint8_t {
    Refused,  ///< malformed, forged, of another session key, or a repetition
    /// Sealed by a member, perhaps long ago: under a former session key, or at another time.
    /// `sender` may be present; a connection to it will show.
    Elsewhen,
    Now,
  };
  struct Opened {
    Heard heard = Heard::Refused;
    consensus::PeerId sender = 0;
    std::span<const std::byte> plain{};  ///< of Now alone; until the next call
    std::size_t key = 0;                 ///< that has opened it, see net::Credentials::key
  };
  /// Incarnation of the process connected as this peer; none if it is not connected.
  using Connected = std::function<std::optional<std::uint64_t>(consensus::PeerId)>;

  /// @param now  ns, as in GroupSealer: messages sealed before are not opened
  explicit GroupOpener(std::int64_t now) : floor_(now) {}

  Opened open(std::span<const std::byte> message, const net::Credentials& credentials,
              std::int64_t now, const Connected& connected);
  std::uint64_t refused() const { return refused_; }
  std::size_t senders() const { return senders_.size(); }

 private:
  struct Sender {
    std::uint64_t incarnation = 0;
    std::int64_t latest = 0;  ///< time of its last message
    std::int64_t most = 0;    ///< latest time of any incarnation
    std::int64_t ahead = 0;   ///< ns, lead over our clock
    std::uint64_t heard = 0;  ///< increasing
  };
  Heard judge(const struct GroupHeader& header, const Sender* known, std::int64_t now,
              const std::optional<std::uint64_t>& connected) const;
  void remember(const struct GroupHeader& header, bool is_connected, std::int64_t now);

  std::map<consensus::PeerId, Sender> senders_;
  std::int64_t floor_;
  std::uint64_t turn_ = 0;
  std::uint64_t refused_ = 0;
  std::vector<std::byte> plain_;
};

}  // namespace tandem::nats
