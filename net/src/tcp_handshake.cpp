// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tcp_handshake.h"

#include <algorithm>
#include <cstdio>
#include <utility>

namespace tandem::net {

namespace {

using SteadyClock = std::chrono::steady_clock;

constexpr std::uint32_t kMinIdleMs = 40;  // of peers' requests for pings

std::string hex(std::uint64_t value) {
  char text[19];
  std::snprintf(text, sizeof text, "0x%016llx", static_cast<unsigned long long>(value));
  return text;
}

}  // namespace

void TcpHandshake::start(TcpLink& link) {
  link.phase = security_ != nullptr ? TcpLink::Phase::Keying : TcpLink::Phase::Greeting;
  link.deadline = SteadyClock::now() + options_.handshake_timeout;
  link.start(options_.socket_buffer_bytes);
  if (link.phase == TcpLink::Phase::Closed || link.dial == 0) return;
  if (security_ == nullptr) return greet(link);
  link.keying.exchange = security_->ask(dialler_.attempts_before(link.dial));
  link.send(FrameType::KeyRequest, [&](pbd::ByteWriter& writer) {
    encode(writer, KeyFrame{.message = link.keying.exchange->message()});
  });
}

std::optional<PeerTable::AttachResult> TcpHandshake::on_frame(TcpLink& link,
                                                              const FrameBuffer::Frame& frame) {
  switch (link.phase) {
    case TcpLink::Phase::Keying:
      on_key_frame(link, frame);
      break;
    case TcpLink::Phase::Greeting:
      if (const auto hello =
              frame.type == FrameType::Hello ? decode_hello(frame.payload) : std::nullopt) {
        on_hello(link, *hello);
      } else {
        on_malformed(link, frame.type == FrameType::KeyRequest
                               ? "this end has no session key"
                               : "not a handshake of this protocol");
      }
      break;
    case TcpLink::Phase::Welcoming:
      if (frame.type == FrameType::Welcome) {
        if (const auto welcome = decode_welcome(frame.payload)) return on_welcome(link, *welcome);
      }
      on_malformed(link, "handshake out of order");
      break;
    default:
      break;
  }
  return {};
}

void TcpHandshake::on_malformed(TcpLink& link, const std::string& reason) {
  if (link.phase != TcpLink::Phase::Keying && link.hello.peer != 0) {
    table_.note_failure(link.hello.peer, reason, true);
  }
  if (link.dial == 0) report_.count(&StrangerStatus::malformed, reason);
  if (link.phase == TcpLink::Phase::Keying) return link.close(reason);
  link.leave(reason, SteadyClock::now() + kLinger);
}

/// A refused link is closed at once: a goodbye would keep memory for a stranger. Two kinds of error
/// get one all the same.
void TcpHandshake::on_key_frame(TcpLink& link, const FrameBuffer::Frame& frame) {
  const bool inbound = link.dial == 0;
  const auto say = [&](const std::string& reason) {
    if (inbound) report_.count(&StrangerStatus::refused, reason);
    link.leave(reason, SteadyClock::now() + kLinger);
  };
  if (frame.type == FrameType::Hello && decode_hello(frame.payload)) {
    return say("a session key is needed");
  }
  const bool expected = frame.type == (inbound ? FrameType::KeyRequest : FrameType::KeyReply);
  const auto theirs = expected ? decode_key_frame(frame.payload) : std::nullopt;
  if (!theirs) return on_malformed(link, "not a key exchange of this protocol");
  if (theirs->version != kKeyVersion) {
    return say("key exchange version " + std::to_string(theirs->version) + " differs from " +
               std::to_string(kKeyVersion));
  }
  const std::int64_t now = nanoseconds(SteadyClock::now());
  auto keys = inbound ? security_->answer(theirs->message, now)
                      : link.keying.exchange->finish(theirs->message, now);
  if (!keys) {
    if (inbound) report_.count(&StrangerStatus::bad_proof, "session key differs");
    return link.close("session key differs");
  }
  if (inbound) {
    link.send(FrameType::KeyReply,
              [&](pbd::ByteWriter& writer) { encode(writer, KeyFrame{.message = keys->message}); });
  }
  link.keying.exchange.reset();
  link.keying.remote = keys->remote;
  link.keying.badge = std::move(keys->badge);
  link.phase = TcpLink::Phase::Greeting;
  link.protect(std::move(keys->cipher));
  // Sealed: it proves that the dialler is no recording.
  if (!inbound && link.phase == TcpLink::Phase::Greeting) greet(link);
}

void TcpHandshake::greet(TcpLink& link) {
  const Hello hello{
      .version = kProtocolVersion,
      .peer = options_.self,
      .incarnation = options_.incarnation,
      .scene_hash = options_.scene_hash,
      .max_message_bytes = options_.max_message_bytes,
      .idle_timeout_ms = static_cast<std::uint32_t>(options_.idle_timeout.count()),
      .listen_port = port_,
  };
  link.send(FrameType::Hello, [&](pbd::ByteWriter& writer) { encode(writer, hello); });
}

std::optional<std::string> TcpHandshake::mismatch(const Hello& hello) const {
  if (hello.version != kProtocolVersion) {
    return "protocol version " + std::to_string(hello.version) + " differs from " +
           std::to_string(kProtocolVersion);
  }
  if (hello.peer == options_.self) {
    return "peer id " + std::to_string(hello.peer) + " is used by both ends";
  }
  if (hello.scene_hash != options_.scene_hash) {
    return "scene hash " + hex(hello.scene_hash) + " differs from " + hex(options_.scene_hash);
  }
  return {};
}

void TcpHandshake::on_hello(TcpLink& link, const Hello& hello) {
  // Judged before anything is recorded under an id that may be another's.
  std::string refusal;
  if (security_) {
    refusal = security_->judge(hello.peer, link.keying.remote, link.keying.badge, link.member);
  }
  if (!refusal.empty()) {
    const std::string reason = refusal + " (" + std::to_string(hello.peer) + ')';
    if (link.dial == 0) report_.count(&StrangerStatus::refused, reason);
    return link.leave(reason, SteadyClock::now() + kLinger);
  }
  link.hello = hello;
  // The listener identifies itself even if it refuses, so that both ends know each other.
  if (link.dial == 0) greet(link);
  if (hello.peer == options_.self && hello.incarnation == options_.incarnation) {
    dialler_.note_self(link.dial);
  }
  if (const auto why = mismatch(hello)) return refuse(link, *why, true);
  if (const auto why = table_.refusal(hello, link.member, SteadyClock::now()))
    return refuse(link, *why, false);
  link.phase = TcpLink::Phase::Welcoming;
  if (options_.self < hello.peer) {
    link.ticket = next_ticket_++;
    send_welcome(link);
  }
}

void TcpHandshake::refuse(TcpLink& link, const std::string& reason, bool rejected) {
  if (link.hello.peer != options_.self) table_.note_failure(link.hello.peer, reason, rejected);
  if (link.dial == 0) report_.count(&StrangerStatus::refused, reason);
  link.leave(reason, SteadyClock::now() + kLinger);
}

void TcpHandshake::send_welcome(TcpLink& link) {
  const Welcome welcome{
      .ticket = link.ticket,
      .received = table_.received(link.hello.peer, link.hello.incarnation, link.member.key)};
  link.send(FrameType::Welcome, [&](pbd::ByteWriter& writer) { encode(writer, welcome); });
}

std::optional<PeerTable::AttachResult> TcpHandshake::on_welcome(TcpLink& link,
                                                                const Welcome& welcome) {
  const bool deciding = options_.self < link.hello.peer;
  if (deciding && welcome.ticket != link.ticket) {
    on_malformed(link, "wrong ticket");
    return {};
  }
  link.ticket = welcome.ticket;

  const SteadyTime now = SteadyClock::now();
  auto result = table_.attach(link.serial(), link.hello, link.member, welcome, link.ticket, now);
  if (!result.attached) {
    link.leave(result.reason, now + kLinger);
    return {};
  }
  // After attach: no more frames from an older connection, so the number sent is final.
  if (!deciding) send_welcome(link);
  link.phase = TcpLink::Phase::Attached;
  link.times.attached = now;
  link.times.ping_interval =
      std::min(options_.idle_timeout,
               std::chrono::milliseconds(std::max(link.hello.idle_timeout_ms, kMinIdleMs))) /
      4;
  link.raise_limit(std::max(kMaxControlFrame, options_.max_message_bytes + kReliableHeader));
  return result;
}

}  // namespace tandem::net
