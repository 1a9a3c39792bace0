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

// What one member says to all at once, sealed under the session key: the server reads nothing and
// invents nothing. Whoever has the session key could have sealed it, in anybody's name:
//   u8 version, u64 sender, u64 incarnation, 8 bytes of salt, i64 time, sealed bytes, 16 bytes of
//   tag.
// Each process of a sender has a key of its own, made of the session key, its id and its salt. The
// time is its system clock's at its start and its steady clock's from there on, ns; it grows with
// each message, so that no number is used twice with one key. The header is authenticated.

constexpr std::size_t kGroupHeader = 1 + 8 + 8 + 8 + 8;
constexpr std::size_t kGroupOverhead = kGroupHeader + net::crypto::kTagBytes;

class GroupSealer {
 public:
  /// @param incarnation  that handshakes tell of this process
  GroupSealer(consensus::PeerId self, std::uint64_t incarnation, const net::crypto::Random& random);

  /// Replaces `out`. @param time  ns; where it has not grown it is taken to be 1 ns later
  void seal(std::span<const std::byte> plain, const net::crypto::Secret& session_key,
            std::int64_t time, std::vector<std::byte>& out);
  /// Whether this sealer has made a message that has opened.
  bool has_sealed(std::span<const std::byte> message) const;

 private:
  consensus::PeerId self_;
  std::uint64_t incarnation_;
  std::array<std::uint8_t, 8> salt_{};
  std::int64_t latest_ = 0;
};

/// Who has sealed it and what it says. Nothing is remembered: it opens as often as it is shown.
struct OpenedRecord {
  consensus::PeerId sender = 0;
  std::vector<std::byte> plain;
};
/// None: malformed, forged, of another session key.
std::optional<OpenedRecord> open_group_record(std::span<const std::byte> message,
                                              const net::crypto::Secret& session_key);

/// Opens each message once. Of a sender that is connected, those of the process at the other end;
/// of any other one, those of no more than kMaxAge ago by its clock, each later than the one
/// before. Clocks of hosts may differ: by how much is learned while the sender is connected.
class GroupOpener {
 public:
  static constexpr std::size_t kMaxSenders = 4096;  ///< the longest silent one goes for a new one
  static constexpr std::int64_t kMaxAge = 4'000'000'000;  ///< ns; and so far ahead at most

  enum class Heard : std::uint8_t {
    Refused,  ///< malformed, forged, of another session key, or had before
    /// A member has sealed it, perhaps long ago: by a former session key, or at a time that is not
    /// now. It says that `sender` may be there, and who connects to it will know.
    Elsewhen,
    Now,
  };
  struct Opened {
    Heard heard = Heard::Refused;
    consensus::PeerId sender = 0;
    std::span<const std::byte> plain{};  ///< of Now alone; until the next call
    std::size_t key = 0;                 ///< that has opened it, see net::Credentials::key
  };
  /// The incarnation of the process that is connected as this peer; none: it is not.
  using Connected = std::function<std::optional<std::uint64_t>(consensus::PeerId)>;

  /// @param now  ns, as GroupSealer has it: what was sealed before is not opened
  explicit GroupOpener(std::int64_t now) : floor_(now) {}

  Opened open(std::span<const std::byte> message, const net::Credentials& credentials,
              std::int64_t now, const Connected& connected);
  std::uint64_t refused() const { return refused_; }
  std::size_t senders() const { return senders_.size(); }

 private:
  struct Sender {
    std::uint64_t incarnation = 0;
    std::int64_t latest = 0;  ///< time of it
    std::int64_t most = 0;    ///< of any
    std::int64_t ahead = 0;   ///< ns, of our clock
    std::uint64_t heard = 0;  ///< the later, the larger
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
