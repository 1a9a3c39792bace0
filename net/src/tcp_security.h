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

#include "address_limiter.h"
#include "credentials.h"
#include "noise.h"
#include "stream_protection.h"
#include "tandem/net/tcp.h"

namespace tandem::net {

// Keys of TCP connections, and who gets them. Times are ns of a steady clock.

/// Both directions of one connection.
struct LinkCipher {
  LinkCipher(const crypto::Secret& send, const crypto::Secret& receive, std::int64_t now)
      : sealer(send, now), opener(receive) {}

  StreamSealer sealer;
  StreamOpener opener;
};

/// Result of a key exchange: the other end has the session key, or is a recording of a peer with
/// it.
struct LinkKeys {
  std::unique_ptr<LinkCipher> cipher;
  Key remote{};                    // public key of the other end
  std::vector<std::byte> badge;    // its right to its id, see Credentials
  std::vector<std::byte> message;  // the listener's answer
};

/// The dialler's half of a key exchange.
class KeyExchange {
 public:
  KeyExchange(const crypto::Secret& session_key, const Credentials& own,
              const crypto::Random& random);
  std::span<const std::byte> message() const { return std::as_bytes(std::span(message_)); }
  /// None if the answerer does not have the session key.
  std::optional<LinkKeys> finish(std::span<const std::byte> answer, std::int64_t now) const;

 private:
  NoiseInitiator noise_;
  std::vector<std::uint8_t> message_;
};

/// Identity of this process, and admission of others.
class TcpSecurity {
 public:
  /// @pre the options have a session key
  explicit TcpSecurity(const TcpOptions& options);

  /// Whether one more connection from that address (IPv6, or IPv4 mapped into it) is allowed.
  bool allow(const std::array<std::uint8_t, 16>& ip, std::int64_t now);
  /// @param attempt  number of dials of that address: session keys take turns
  std::unique_ptr<KeyExchange> ask(std::uint64_t attempt) const;
  /// The listener's half. None if the dialler does not have the session key.
  std::optional<LinkKeys> answer(std::span<const std::byte> question, std::int64_t now) const;
  /// Whether the owner of that key may be that peer, and in which role.
  /// @return why not; empty if it may
  std::string judge(PeerId peer, const Key& remote, std::span<const std::byte> badge,
                    Member& member) const;
  /// Why a member no longer is one; empty if it is.
  std::string expelled(const Member& member) const;
  Credentials::Changed change_group(std::span<const std::byte> signed_change);
  /// With the organiser's changes since.
  const Credentials& credentials() const { return own_; }

 private:
  crypto::Random random_;
  const std::uint64_t session_;
  Credentials own_;
  AddressLimiter limiter_;
};

}  // namespace tandem::net
