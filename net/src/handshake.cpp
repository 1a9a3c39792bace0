// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "handshake.h"

#include <algorithm>
#include <utility>

#include "octets.h"
#include "tandem/pbd/bytes.h"

namespace tandem::net {

namespace {

constexpr std::int64_t kFirstResend = 250'000'000;  // ns, doubled each time
constexpr std::int64_t kLastResend = 1'000'000'000;
constexpr int kProofsBeforeAsking = 3;  // after these the cookie may have expired
constexpr double kProofRate = 4.0;      // per s and address
constexpr double kProofBurst = 16.0;
constexpr double kProofTotal = 1000.0;  // per s

/// Hashed by both ends. The cookie binds the proof to the responder, the time and the address.
std::vector<std::uint8_t> udp_prologue(std::uint64_t nonce, const Cookie& cookie) {
  constexpr std::string_view kLabel = "tandem udp";
  std::vector<std::uint8_t> out(kLabel.begin(), kLabel.end());
  out.push_back(static_cast<std::uint8_t>(kUdpVersion));
  out.push_back(static_cast<std::uint8_t>(kUdpVersion >> 8));
  for (int i = 0; i < 8; ++i) out.push_back(static_cast<std::uint8_t>(nonce >> (8 * i)));
  out.insert(out.end(), cookie.begin(), cookie.end());
  return out;
}

std::string version_reason(std::uint16_t version) {
  return "protocol version " + std::to_string(version) + " differs from " +
         std::to_string(kUdpVersion);
}

Introduction introduce(const HandshakeConfig& config, std::uint32_t receiver) {
  return {.peer = config.self,
          .incarnation = config.incarnation,
          .scene_hash = config.scene_hash,
          .receiver = receiver,
          .idle_timeout_ms = config.idle_timeout_ms,
          .badge = config.badge()};
}

/// Check of the other end.
Credentials::Answer judge(const HandshakeConfig& config, const Introduction& other,
                          const crypto::PublicKey& key) {
  auto out = config.judge(other.peer, key, other.badge, config.scene_hash);
  if (out.verdict != Verdict::Welcome) return out;
  if (other.peer == config.self) out.verdict = Verdict::SameId;
  if (other.scene_hash != config.scene_hash) out.verdict = Verdict::SceneDiffers;
  return out;
}

crypto::Secret random_secret(const crypto::Random& random) {
  crypto::Secret out;
  random(out.bytes());
  return out;
}

}  // namespace

HandshakeInitiator::HandshakeInitiator(const HandshakeConfig& config, const crypto::Random& random,
                                       std::uint32_t local_receiver, std::int64_t now,
                                       std::size_t key)
    : config_(config),
      random_(random),
      key_(config.key(key)),
      nonce_(crypto::random_number(random)),
      local_receiver_(local_receiver),
      deadline_(now + kTimeout),
      due_(now),
      interval_(kFirstResend),
      reason_("no answer") {}

std::span<const std::byte> HandshakeInitiator::poll(std::int64_t now) {
  if (state_ != State::Asking && state_ != State::Proving) return {};
  if (now >= deadline_) {
    state_ = State::TimedOut;
    return {};
  }
  if (now < due_) return {};
  if (state_ == State::Proving && unanswered_ >= kProofsBeforeAsking) {
    state_ = State::Asking;
    interval_ = kFirstResend;
  }
  if (state_ == State::Asking) {
    encode({.type = HandshakeType::Hello, .nonce = nonce_}, datagram_);
  } else {
    ++unanswered_;
    encode({.type = HandshakeType::Initiate,
            .nonce = nonce_,
            .cookie = cookie_,
            .noise = first_message_},
           datagram_);
  }
  due_ = now + interval_;
  interval_ = std::min(2 * interval_, kLastResend);
  return datagram_;
}

void HandshakeInitiator::on_datagram(std::span<const std::byte> datagram, std::int64_t now) {
  const auto packet = decode_handshake(datagram);
  if (!packet || packet->nonce != nonce_) return;
  if (packet->version != kUdpVersion) {
    reason_ = version_reason(packet->version);
    return;
  }
  if (packet->type == HandshakeType::Challenge) on_challenge(*packet, now);
  if (packet->type == HandshakeType::Accept) on_accept(*packet);
}

void HandshakeInitiator::on_challenge(const HandshakePacket& packet, std::int64_t now) {
  if (state_ != State::Asking) return;
  state_ = State::Proving;
  cookie_ = packet.cookie;
  noise_.emplace(key_, config_.identity, udp_prologue(nonce_, cookie_), random_);
  first_message_ = noise_->first_message(encode(introduce(config_, local_receiver_)));
  unanswered_ = 0;
  interval_ = kFirstResend;
  due_ = now;
}

void HandshakeInitiator::on_accept(const HandshakePacket& packet) {
  if (!noise_ || (state_ != State::Proving && state_ != State::Asking)) return;
  auto result = noise_->second_message(packet.noise);
  if (!result) return;
  const auto remote = decode_introduction(result->payload);
  if (!remote) return;
  const auto own = judge(config_, *remote, result->remote);
  const Verdict verdict = own.verdict != Verdict::Welcome ? own.verdict : remote->verdict;
  if (verdict != Verdict::Welcome) {
    state_ = State::Refused;
    verdict_ = verdict;
    refused_by_ = remote->peer;
    reason_ = describe(verdict);
    return;
  }
  session_ = Session{.remote = *remote,
                     .member = own.member,
                     .send = result->keys.initiator,
                     .receive = result->keys.responder,
                     .local_receiver = local_receiver_};
  state_ = State::Done;
  reason_.clear();
}

HandshakeResponder::HandshakeResponder(const HandshakeConfig& config, const crypto::Random& random,
                                       Decide decide, NextReceiver next_receiver)
    : config_(config),
      random_(random),
      decide_(std::move(decide)),
      next_receiver_(std::move(next_receiver)),
      cookie_key_(random_secret(random)),
      proofs_(random_secret(random), kProofRate, kProofBurst, kProofTotal) {}

Cookie HandshakeResponder::make_cookie(std::int64_t time, std::uint64_t nonce,
                                       const Address& from) const {
  std::vector<std::byte> message;
  pbd::ByteWriter writer(message);
  writer.i64(time);
  writer.u64(nonce);
  writer.bytes(as_bytes(from.ip));
  writer.u16(from.port);
  const auto bytes = octets(std::span<const std::byte>(message));
  const auto tag = crypto::mac16(cookie_key_, bytes);
  Cookie cookie{};
  std::copy_n(bytes.begin(), 8, cookie.begin());
  std::copy(tag.begin(), tag.end(), cookie.begin() + 8);
  return cookie;
}

bool HandshakeResponder::good_cookie(const HandshakePacket& packet, const Address& from,
                                     std::int64_t now) const {
  pbd::ByteReader reader(as_bytes(packet.cookie));
  const std::int64_t time = reader.i64();
  if (!crypto::equal(make_cookie(time, packet.nonce, from), packet.cookie)) return false;
  return now - time <= kCookieLife;
}

HandshakeResponder::Result HandshakeResponder::on_datagram(std::span<const std::byte> datagram,
                                                           const Address& from, std::int64_t now) {
  const auto packet = decode_handshake(datagram);
  if (!packet) {
    ++counters_.malformed;
    return {};
  }
  if (packet->type == HandshakeType::Hello) {
    ++counters_.challenged;
    // Not limited, since anybody could use up another address's limit: an answer costs one hash and
    // is shorter than the question. It has our version, whatever theirs is.
    encode({.type = HandshakeType::Challenge,
            .nonce = packet->nonce,
            .cookie = make_cookie(now, packet->nonce, from)},
           reply_);
    return {.reply = reply_, .session = {}};
  }
  if (packet->type == HandshakeType::Initiate && packet->version == kUdpVersion) {
    if (!good_cookie(*packet, from, now)) {
      ++counters_.bad_cookie;
      return {};
    }
    return on_initiate(*packet, from, now);
  }
  ++counters_.malformed;
  return {};
}

std::optional<HandshakeResponder::Proof> HandshakeResponder::open(
    const HandshakePacket& packet) const {
  for (std::size_t key = 0; key < config_.key_count(); ++key) {
    Proof out{.noise = {config_.key(key), udp_prologue(packet.nonce, packet.cookie)}};
    auto first = out.noise.first_message(packet.noise);
    if (!first) continue;
    const auto remote = decode_introduction(first->payload);
    if (!remote || remote->receiver == 0) return {};
    out.first = std::move(*first);
    out.remote = *remote;
    return out;
  }
  return {};
}

HandshakeResponder::Result HandshakeResponder::on_initiate(const HandshakePacket& packet,
                                                           const Address& from, std::int64_t now) {
  std::erase_if(half_open_, [now](const HalfOpen& entry) { return now >= entry.until; });
  // A repeated message: our answer was lost.
  for (const HalfOpen& entry : half_open_) {
    if (entry.from == from && entry.nonce == packet.nonce &&
        std::ranges::equal(entry.first_message, packet.noise)) {
      return {.reply = entry.reply, .session = {}};
    }
  }

  auto proof = open(packet);
  if (!proof) {
    ++counters_.bad_proof;
    return {};
  }
  // Only a sender that receives at its address and has a session key can use up a limit. All others
  // have cost a few hashes so far; curve arithmetic follows.
  if (!proofs_.allow(from, now)) {
    ++counters_.limited;
    return {};
  }
  const Introduction& remote = proof->remote;
  const auto answer = judge(config_, remote, proof->first.remote);
  Verdict verdict = answer.verdict;
  if (verdict == Verdict::NoWork) {  // no answer: it would cost us work and the sender none
    ++counters_.refused;
    return {};
  }
  if (verdict == Verdict::Welcome) verdict = decide_(remote, answer.member, from);
  Introduction own = introduce(config_, verdict == Verdict::Welcome ? next_receiver_() : 0);
  own.verdict = verdict;
  auto second = proof->noise.second_message(config_.identity, random_, encode(own));
  if (!second) {
    ++counters_.bad_proof;
    return {};
  }
  encode({.type = HandshakeType::Accept, .nonce = packet.nonce, .noise = second->message}, reply_);
  if (verdict != Verdict::Welcome) {
    ++counters_.refused;
    return {.reply = reply_, .session = {}};
  }
  ++accepted_;
  if (half_open_.size() >= kMaxHalfOpen) half_open_.pop_front();
  half_open_.push_back({.from = from,
                        .nonce = packet.nonce,
                        .first_message = {packet.noise.begin(), packet.noise.end()},
                        .reply = reply_,
                        .until = now + kHalfOpenLife});
  return {.reply = reply_,
          .session = Session{.remote = remote,
                             .member = answer.member,
                             .send = second->keys.responder,
                             .receive = second->keys.initiator,
                             .local_receiver = own.receiver}};
}

}  // namespace tandem::net
