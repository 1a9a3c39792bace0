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

// Keys of TCP connections, and whom they are given to. Times are ns of a steady clock.

/// Both directions of one connection.
struct LinkCipher {
  LinkCipher(const crypto::Secret& send, const crypto::Secret& receive, std::int64_t now)
      : sealer(send, now), opener(receive) {}

  StreamSealer sealer;
  StreamOpener opener;
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
  KeyExchange(const crypto::Secret& session_key, const Credentials& own,
              const crypto::Random& random);
  std::span<const std::byte> message() const { return std::as_bytes(std::span(message_)); }
  /// None where the answer is not of one that has the session key.
  std::optional<LinkKeys> finish(std::span<const std::byte> answer, std::int64_t now) const;

 private:
  NoiseInitiator noise_;
  std::vector<std::uint8_t> message_;
};

/// Who this process is, and whom it lets in.
class TcpSecurity {
 public:
  /// @pre the options have a session key
  explicit TcpSecurity(const TcpOptions& options);

  /// Whether to listen to somebody at that address (IPv6, or IPv4 mapped into it) once more.
  bool allow(const std::array<std::uint8_t, 16>& ip, std::int64_t now);
  /// @param attempt  how often that address has been dialled: keys take turns
  std::unique_ptr<KeyExchange> ask(std::uint64_t attempt) const;
  /// The listener's half. None where the question is not of one that has the session key.
  std::optional<LinkKeys> answer(std::span<const std::byte> question, std::int64_t now) const;
  /// Whether whoever has that key may be that peer, and as what.
  /// @return why not; empty where it may
  std::string judge(PeerId peer, const Key& remote, std::span<const std::byte> badge,
                    Member& member) const;
  /// Why what was a member is none any more; empty where it is.
  std::string expelled(const Member& member) const;
  Credentials::Changed change_group(std::span<const std::byte> signed_change);
  /// With what the organiser has said since.
  const Credentials& credentials() const { return own_; }

 private:
  crypto::Random random_;
  const std::uint64_t session_;
  Credentials own_;
  AddressLimiter limiter_;
};

}  // namespace tandem::net
