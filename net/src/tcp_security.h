// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tandem/net/tcp.h"

namespace tandem::net {

// What TCP needs of the cryptography, which not every build has. Times are ns of a steady clock.

/// Both directions of one connection; see StreamSealer and StreamOpener.
class LinkCipher {
 public:
  virtual ~LinkCipher() = default;
  [[nodiscard]] virtual bool seal(std::span<const std::byte> frames, std::int64_t now,
                                  std::vector<std::byte>& out) = 0;
  virtual std::optional<std::span<const std::byte>> open(std::span<const std::byte> frame) = 0;
};

/// The end of a key exchange: the other end has the session key, or is a recording of one that had.
struct LinkKeys {
  std::unique_ptr<LinkCipher> cipher;
  Key remote{};                    // public key of the other end
  std::vector<std::byte> badge;    // why it may go by its id, see Credentials
  std::vector<std::byte> message;  // the listener's answer
};

/// The dialler's half of a key exchange.
class KeyExchange {
 public:
  virtual ~KeyExchange() = default;
  virtual std::span<const std::byte> message() const = 0;
  /// None where the answer is not of one that has the session key.
  virtual std::optional<LinkKeys> finish(std::span<const std::byte> answer, std::int64_t now) = 0;
};

/// How somebody stands to this process, see Credentials.
struct LinkMember {
  Key key{};
  Role role = Role::Share;
  bool bound = true;
  std::int64_t expires = INT64_MAX;
  std::string refusal;  // why he may not come in; empty where he may
};

/// Who this process is, and whom it lets in.
class TcpSecurity {
 public:
  virtual ~TcpSecurity() = default;
  /// Whether to listen to somebody at that address (IPv6, or IPv4 mapped into it) once more.
  virtual bool allow(const std::array<std::uint8_t, 16>& ip, std::int64_t now) = 0;
  /// @param attempt  how often that address has been dialled: keys take turns
  virtual std::unique_ptr<KeyExchange> ask(std::uint64_t attempt) = 0;
  /// The listener's half. None where the question is not of one that has the session key.
  virtual std::optional<LinkKeys> answer(std::span<const std::byte> question, std::int64_t now) = 0;
  /// Whether whoever has that key may be that peer, and as what.
  virtual LinkMember judge(PeerId peer, const Key& remote,
                           std::span<const std::byte> badge) const = 0;
  /// Why what was a member is none any more; empty where it is.
  virtual std::string expelled(const LinkMember& member) const = 0;

  enum class Changed { Yes, Known, Forged };
  virtual Changed change_group(std::span<const std::byte> signed_change) = 0;
  /// The one that holds; empty: none.
  virtual std::span<const std::byte> group_change() const = 0;
  virtual std::uint64_t group() const = 0;
};

/// Whether this build can protect anything.
bool has_protection();
/// Null where there is no session key.
std::unique_ptr<TcpSecurity> make_tcp_security(const TcpOptions& options);

}  // namespace tandem::net
