// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
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

/// Who this process is, and whom it trusts.
class TcpSecurity {
 public:
  virtual ~TcpSecurity() = default;
  /// Whether to listen to somebody at that address (IPv6, or IPv4 mapped into it) once more.
  virtual bool allow(const std::array<std::uint8_t, 16>& ip, std::int64_t now) = 0;
  virtual std::unique_ptr<KeyExchange> ask() = 0;
  /// The listener's half. None where the question is not of one that has the session key.
  virtual std::optional<LinkKeys> answer(std::span<const std::byte> question, std::int64_t now) = 0;
  /// Whether that may be the peer's public key.
  virtual bool trusts(PeerId peer, const Key& remote) const = 0;
};

/// Whether this build can protect anything.
bool has_protection();
/// Null where there is no session key.
std::unique_ptr<TcpSecurity> make_tcp_security(const TcpOptions& options);

}  // namespace tandem::net
