// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "address.h"
#include "address_limiter.h"
#include "credentials.h"
#include "crypto.h"
#include "handshake_wire.h"
#include "noise.h"
#include "tandem/net/udp.h"

namespace tandem::net {

/// Who this process is, and whom it trusts. Times are ns of any clock that does not go back.
struct HandshakeConfig : Credentials {
  consensus::PeerId self = 0;
  std::uint64_t incarnation = 0;
  std::uint64_t scene_hash = 0;
  std::uint32_t idle_timeout_ms = 5000;
};

/// What a handshake leaves: keys of this connection alone, and who is at the other end.
struct Session {
  Introduction remote;
  Member member;
  crypto::Secret send;
  crypto::Secret receive;
  std::uint32_t local_receiver = 0;  // on packets that come
};

/// Asks one address. Give it what comes from there, send what poll() returns. The proof is made for
/// one cookie, and so for one responder, one address and a few seconds: recorded, it proves nothing
/// to anybody else and nothing later.
class HandshakeInitiator {
 public:
  static constexpr std::int64_t kTimeout = 5'000'000'000;  // ns
  enum class State { Asking, Proving, Done, Refused, TimedOut };

  /// @param key  which of the config's session keys, see Credentials::key
  HandshakeInitiator(const HandshakeConfig& config, const crypto::Random& random,
                     std::uint32_t local_receiver, std::int64_t now, std::size_t key = 0);

  /// The datagram that is due, empty where none is. Valid until the next call.
  std::span<const std::byte> poll(std::int64_t now);
  /// Not of this handshake, forged, late: nothing happens.
  void on_datagram(std::span<const std::byte> datagram, std::int64_t now);

  State state() const { return state_; }
  std::uint32_t receiver() const { return local_receiver_; }
  /// In State::Done.
  const Session& session() const { return *session_; }
  /// In State::Refused, and by whom.
  Verdict verdict() const { return verdict_; }
  consensus::PeerId refused_by() const { return refused_by_; }
  /// Why not, as far as is known. What was not authenticated ("another version") is said here and
  /// never believed: it goes on until kTimeout.
  const std::string& reason() const { return reason_; }

 private:
  void on_challenge(const HandshakePacket& packet, std::int64_t now);
  void on_accept(const HandshakePacket& packet);

  const HandshakeConfig& config_;
  crypto::Random random_;
  crypto::Secret key_;
  State state_ = State::Asking;
  std::uint64_t nonce_ = 0;
  std::uint32_t local_receiver_;
  std::optional<NoiseInitiator> noise_;
  std::vector<std::uint8_t> first_message_;
  Cookie cookie_{};
  std::vector<std::byte> datagram_;
  std::int64_t deadline_;
  std::int64_t due_;
  std::int64_t interval_;
  int unanswered_ = 0;
  std::optional<Session> session_;
  Verdict verdict_ = Verdict::Welcome;
  consensus::PeerId refused_by_ = 0;
  std::string reason_;
};

/// Answers strangers: questions, all of them, by a cookie that costs no memory, and proofs, where a
/// cookie shows that the stranger receives at his address and the session key that he is a member,
/// by a session.
class HandshakeResponder {
 public:
  static constexpr std::int64_t kCookieLife = 5'000'000'000;    // ns
  static constexpr std::int64_t kHalfOpenLife = 5'000'000'000;  // ns
  /// What is answered a second time where the first answer was lost: 0.8 s at 300 a second.
  static constexpr std::size_t kMaxHalfOpen = 256;

  /// What else is to be said about a member; asked last.
  using Decide = std::function<Verdict(const Introduction&, const Member&, const Address&)>;
  /// A number for packets of a new session, not in use, never 0.
  using NextReceiver = std::function<std::uint32_t()>;

  HandshakeResponder(const HandshakeConfig& config, const crypto::Random& random, Decide decide,
                     NextReceiver next_receiver);

  struct Result {
    std::span<const std::byte> reply;  // never longer than the datagram; valid until the next call
    /// Set once for each session. Not confirmed: the other end might be a recording, and nothing
    /// that exists may give way to it before a packet of it has been opened.
    std::optional<Session> session;
  };
  Result on_datagram(std::span<const std::byte> datagram, const Address& from, std::int64_t now);

  /// All but `unknown`: no datagram of a connection comes here.
  const UdpStrangers& counters() const { return counters_; }
  std::uint64_t accepted() const { return accepted_; }
  std::size_t half_open() const { return half_open_.size(); }

 private:
  struct HalfOpen {
    Address from;
    std::uint64_t nonce = 0;
    std::vector<std::uint8_t> first_message;
    std::vector<std::byte> reply;
    std::int64_t until = 0;
  };

  Cookie make_cookie(std::int64_t time, std::uint64_t nonce, const Address& from) const;
  bool good_cookie(const HandshakePacket& packet, const Address& from, std::int64_t now) const;
  struct Proof {
    NoiseResponder noise;
    NoiseResponder::First first;
    Introduction remote;
  };
  /// By the session key, or by one before it, of whoever has missed a change.
  std::optional<Proof> open(const HandshakePacket& packet) const;
  Result on_initiate(const HandshakePacket& packet, const Address& from, std::int64_t now);

  const HandshakeConfig& config_;
  crypto::Random random_;
  Decide decide_;
  NextReceiver next_receiver_;
  crypto::Secret cookie_key_;
  AddressLimiter proofs_;
  std::deque<HalfOpen> half_open_;  // oldest first
  std::vector<std::byte> reply_;
  UdpStrangers counters_;
  std::uint64_t accepted_ = 0;
};

}  // namespace tandem::net
