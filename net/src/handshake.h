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

/// Identity and trust of this process. Times are ns of any monotonic clock.
struct HandshakeConfig : Credentials {
  consensus::PeerId self = 0;
  std::uint64_t incarnation = 0;
  std::uint64_t scene_hash = 0;
  std::uint32_t idle_timeout_ms = 5000;
};

/// Result of a handshake: keys of this connection, and the identity of the other end.
struct Session {
  Introduction remote;
  Member member;
  crypto::Secret send;
  crypto::Secret receive;
  std::uint32_t local_receiver = 0;  // on incoming packets
};

/// Handshake with one address. Pass it what comes from there, and send what poll() returns. The
/// proof is bound to one cookie, and so to one responder, one address and a few seconds: a
/// recording is useless elsewhere or later.
class HandshakeInitiator {
 public:
  static constexpr std::int64_t kTimeout = 5'000'000'000;  // ns
  enum class State { Asking, Proving, Done, Refused, TimedOut };

  /// @param key  index of the session key, see Credentials::key
  HandshakeInitiator(const HandshakeConfig& config, const crypto::Random& random,
                     std::uint32_t local_receiver, std::int64_t now, std::size_t key = 0);

  /// The datagram that is due, empty if none is. Valid until the next call.
  std::span<const std::byte> poll(std::int64_t now);
  /// Datagrams of other handshakes, forged or late ones are ignored.
  void on_datagram(std::span<const std::byte> datagram, std::int64_t now);

  State state() const { return state_; }
  std::uint32_t receiver() const { return local_receiver_; }
  /// @pre State::Done
  const Session& session() const { return *session_; }
  /// In State::Refused, with the refusing peer.
  Verdict verdict() const { return verdict_; }
  consensus::PeerId refused_by() const { return refused_by_; }
  /// Reason for the lack of success so far. An unauthenticated reason ("another version") is
  /// reported but not believed: the handshake continues until kTimeout.
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

/// Answers strangers: a question by a cookie, which costs no memory; a proof by a session, if the
/// cookie shows that the sender receives at its address and the session key that it is a member.
class HandshakeResponder {
 public:
  static constexpr std::int64_t kCookieLife = 5'000'000'000;    // ns
  static constexpr std::int64_t kHalfOpenLife = 5'000'000'000;  // ns
  /// Repeated answers, in case the first one was lost: 0.8 s at 300 a second.
  static constexpr std::size_t kMaxHalfOpen = 256;

  /// Application's verdict on a member; called last.
  using Decide = std::function<Verdict(const Introduction&, const Member&, const Address&)>;
  /// An unused receiver number for a new session, never 0.
  using NextReceiver = std::function<std::uint32_t()>;

  HandshakeResponder(const HandshakeConfig& config, const crypto::Random& random, Decide decide,
                     NextReceiver next_receiver);

  struct Result {
    std::span<const std::byte> reply;  // never longer than the datagram; valid until the next call
    /// Set once for each session. Unconfirmed: the other end might be a recording, and nothing may
    /// give way to it before a packet of it has been opened.
    std::optional<Session> session;
  };
  Result on_datagram(std::span<const std::byte> datagram, const Address& from, std::int64_t now);

  /// All but `unknown`: packets of connections do not come here.
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
  /// With the session key, or a former one for a member that has missed a change.
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
