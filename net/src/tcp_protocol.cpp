// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// TcpMesh: what the frames mean. Every byte here comes from a stranger.
#include <algorithm>
#include <asio/io_context.hpp>
#include <cstdio>
#include <utility>

#include "tcp_mesh.h"

namespace tandem::net {

using consensus::Delivery;

namespace {

constexpr std::size_t kWriteBatch = 64 * 1024;  // bytes gathered for one write
constexpr std::uint32_t kMinIdleMs = 40;        // whatever a peer asks for, ping no faster

std::string hex(std::uint64_t value) {
  char text[19];
  std::snprintf(text, sizeof text, "0x%016llx", static_cast<unsigned long long>(value));
  return text;
}

std::string from_peer(const std::string& text) { return "peer: " + text; }

}  // namespace

void TcpMesh::on_frame(TcpLink& link, const FrameBuffer::Frame& frame) {
  if (frame.type == FrameType::Goodbye) return on_goodbye(link, decode_reason(frame.payload));
  switch (link.phase) {
    case TcpLink::Phase::Keying:
      return on_key_frame(link, frame);
    case TcpLink::Phase::Greeting:
      if (frame.type == FrameType::Hello) {
        if (const auto hello = decode_hello(frame.payload)) return on_hello(link, *hello);
      }
      return on_malformed(link, frame.type == FrameType::KeyRequest
                                    ? "this end has no session key"
                                    : "not a handshake of this protocol");
    case TcpLink::Phase::Welcoming:
      if (frame.type == FrameType::Welcome) {
        if (const auto welcome = decode_welcome(frame.payload)) return on_welcome(link, *welcome);
      }
      return on_malformed(link, "handshake out of order");
    case TcpLink::Phase::Attached:
      return on_peer_frame(link, frame);
    default:
      return;
  }
}

void TcpMesh::ask_for_keys(TcpLink& link) {
  const Dial* const dial = find_dial(link.dial);
  link.exchange = security_->ask(dial != nullptr && dial->attempts > 0 ? dial->attempts - 1 : 0);
  link.send(FrameType::KeyRequest, [&](pbd::ByteWriter& writer) {
    encode(writer, KeyFrame{.message = link.exchange->message()});
  });
}

/// What is refused here is closed at once: a goodbye would keep something for a stranger. Two
/// mistakes get one all the same.
void TcpMesh::on_key_frame(TcpLink& link, const FrameBuffer::Frame& frame) {
  const bool inbound = link.dial == 0;
  const auto say = [&](const std::string& reason) {
    if (inbound) table_.count(PeerTable::Stranger::Refused, reason);
    link.leave(reason, Clock::now() + kLinger);
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
  const std::int64_t now = nanoseconds(Clock::now());
  auto keys = inbound ? security_->answer(theirs->message, now)
                      : link.exchange->finish(theirs->message, now);
  if (!keys) {
    if (inbound) table_.count(PeerTable::Stranger::BadProof, "session key differs");
    return link.close("session key differs");
  }
  if (inbound) {
    link.send(FrameType::KeyReply,
              [&](pbd::ByteWriter& writer) { encode(writer, KeyFrame{.message = keys->message}); });
  }
  link.exchange.reset();
  link.remote_key = keys->remote;
  link.badge = std::move(keys->badge);
  link.phase = TcpLink::Phase::Greeting;
  link.protect(std::move(keys->cipher));
  // Sealed, so that it is the dialler's proof that it is no recording.
  if (!inbound && link.phase == TcpLink::Phase::Greeting) greet(link);
}

void TcpMesh::greet(TcpLink& link) {
  const Hello hello{
      .version = kProtocolVersion,
      .peer = options_.self,
      .incarnation = options_.incarnation,
      .scene_hash = options_.scene_hash,
      .max_frame_bytes = options_.max_frame_bytes,
      .idle_timeout_ms = static_cast<std::uint32_t>(options_.idle_timeout.count()),
      .listen_port = local_port_,
  };
  link.send(FrameType::Hello, [&](pbd::ByteWriter& writer) { encode(writer, hello); });
}

std::optional<std::string> TcpMesh::mismatch(const Hello& hello) const {
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

void TcpMesh::on_hello(TcpLink& link, const Hello& hello) {
  // Before anything is noted under an id that may be another's.
  if (security_) link.member = security_->judge(hello.peer, link.remote_key, link.badge);
  if (!link.member.refusal.empty()) {
    const std::string reason = link.member.refusal + " (" + std::to_string(hello.peer) + ')';
    if (link.dial == 0) table_.count(PeerTable::Stranger::Refused, reason);
    return link.leave(reason, Clock::now() + kLinger);
  }
  link.hello = hello;
  // The listener names itself even where it refuses, so that both ends know whom they disagree
  // with.
  if (link.dial == 0) greet(link);
  if (hello.peer == options_.self && hello.incarnation == options_.incarnation) {
    if (Dial* dial = find_dial(link.dial)) dial->is_self = true;
  }
  if (const auto why = mismatch(hello)) return refuse(link, *why, true);
  if (const auto why = table_.refusal(hello, link.member, Clock::now()))
    return refuse(link, *why, false);
  link.phase = TcpLink::Phase::Welcoming;
  if (options_.self < hello.peer) {
    link.ticket = next_ticket_++;
    send_welcome(link);
  }
}

void TcpMesh::refuse(TcpLink& link, const std::string& reason, bool rejected) {
  if (link.hello.peer != options_.self) table_.note_failure(link.hello.peer, reason, rejected);
  if (link.dial == 0) table_.count(PeerTable::Stranger::Refused, reason);
  link.leave(reason, Clock::now() + kLinger);
}

void TcpMesh::send_welcome(TcpLink& link) {
  const Welcome welcome{
      .ticket = link.ticket,
      .received = table_.received(link.hello.peer, link.hello.incarnation, link.member.key)};
  link.send(FrameType::Welcome, [&](pbd::ByteWriter& writer) { encode(writer, welcome); });
}

void TcpMesh::on_welcome(TcpLink& link, const Welcome& welcome) {
  const bool deciding = options_.self < link.hello.peer;
  if (deciding && welcome.ticket != link.ticket) return on_malformed(link, "wrong ticket");
  link.ticket = welcome.ticket;

  const SteadyTime now = Clock::now();
  const auto result =
      table_.attach(link.serial(), link.hello, link.member, welcome, link.ticket, now);
  if (!result.attached) return link.leave(result.reason, now + kLinger);
  // After attach: nothing more is taken from an older connection, the number sent is final.
  if (!deciding) send_welcome(link);
  link.phase = TcpLink::Phase::Attached;
  link.attached_at = now;
  link.ping_interval =
      std::min(options_.idle_timeout,
               std::chrono::milliseconds(std::max(link.hello.idle_timeout_ms, kMinIdleMs))) /
      4;
  link.raise_limit(std::max(kMaxControlFrame, options_.max_frame_bytes + kReliableHeader));
  if (TcpLink* replaced = find_link(result.replaced_link)) {
    replaced->leave("replaced by a newer connection", now + kLinger);
  }
  learn_address(link);
  introduce(link);
  send_group_change(link);
  publish_dials();
  link.kick();
}

void TcpMesh::on_goodbye(TcpLink& link, const std::string& text) {
  const PeerId peer = link.hello.peer;
  if (link.phase != TcpLink::Phase::Attached && peer != 0) {
    table_.note_failure(peer, from_peer(text), false);
  }
  link.close(from_peer(text));
}

void TcpMesh::on_malformed(TcpLink& link, const std::string& reason) {
  const SteadyTime now = Clock::now();
  if (link.phase == TcpLink::Phase::Keying) {
    if (link.dial == 0) table_.count(PeerTable::Stranger::Malformed, reason);
    return link.close(reason);
  }
  if (link.phase == TcpLink::Phase::Attached) {
    table_.reject(link.serial(), link.hello.peer, reason, now);
    return link.leave("dropped: " + reason, now + kLinger);
  }
  if (link.hello.peer != 0) table_.note_failure(link.hello.peer, reason, true);
  if (link.dial == 0) table_.count(PeerTable::Stranger::Malformed, reason);
  link.leave(reason, now + kLinger);
}

/// Not the peer's doing: it is not held against it, and both set up a new connection.
void TcpMesh::on_forged(TcpLink& link, const std::string& reason) {
  table_.count(PeerTable::Stranger::Forged, reason);
  if (link.phase != TcpLink::Phase::Attached) return link.close(reason);
  table_.detach(link.serial(), link.hello.peer, "connection lost: " + reason);
  link.leave("connection lost: " + reason, Clock::now() + kLinger);
}

void TcpMesh::on_peer_frame(TcpLink& link, const FrameBuffer::Frame& frame) {
  const PeerId peer = link.hello.peer;
  if (frame.type != FrameType::Newest && frame.type != FrameType::Reliable) {
    table_.charge(link.serial(), peer);
  }
  switch (frame.type) {
    case FrameType::Ping:
      return;
    case FrameType::Ack: {
      pbd::ByteReader reader(frame.payload);
      const std::uint64_t acked = reader.u64();
      if (reader.failed() || reader.remaining() != 0 ||
          !table_.acknowledge(link.serial(), peer, acked)) {
        on_malformed(link, "acknowledgement of what was never sent");
      }
      return;
    }
    case FrameType::GroupChange:
      return on_group_change(link, frame.payload);
    case FrameType::Addresses:
      if (const auto addresses = decode_addresses(frame.payload)) {
        return on_addresses(link, *addresses);
      }
      return on_malformed(link, "addresses cannot be decoded");
    case FrameType::Reliable: {
      pbd::ByteReader reader(frame.payload);
      const std::uint64_t sequence = reader.u64();
      if (reader.failed() || sequence == 0) return on_malformed(link, "frame without its number");
      return on_payload(link, Delivery::Reliable, sequence, frame.payload.subspan(kReliableHeader));
    }
    case FrameType::Newest:
      return on_payload(link, Delivery::Newest, 0, frame.payload);
    default:
      return on_malformed(
          link, "unknown frame type " + std::to_string(static_cast<unsigned>(frame.type)));
  }
}

void TcpMesh::on_payload(TcpLink& link, Delivery delivery, std::uint64_t sequence,
                         std::span<const std::byte> bytes) {
  const PeerId peer = link.hello.peer;
  if (bytes.size() > options_.max_frame_bytes) {
    return on_malformed(link, "payload of " + std::to_string(bytes.size()) + " bytes, at most " +
                                  std::to_string(options_.max_frame_bytes));
  }
  switch (table_.deliver(link.serial(), peer, delivery, sequence, bytes, Clock::now())) {
    case PeerTable::Delivered::Ok:
      link.ack_due |= delivery == Delivery::Reliable;
      return;
    case PeerTable::Delivered::Stale:
      return;  // dropped meanwhile, its link is about to be cut
    case PeerTable::Delivered::Abused:
      return on_malformed(link, MemberBudget::kReason);
    case PeerTable::Delivered::Gap:
      return on_malformed(link, "reliable frame out of order");
    case PeerTable::Delivered::Full: {
      // Not acknowledged, so it comes again after the reconnection.
      const std::string reason = "receive queue full of reliable frames, not drained";
      table_.detach(link.serial(), peer, reason);
      return link.leave(reason, Clock::now() + kLinger);
    }
  }
}

bool TcpMesh::may_read(TcpLink& link) {
  return link.phase != TcpLink::Phase::Attached ||
         table_.may_read(link.serial(), link.hello.peer, Clock::now());
}

void TcpMesh::on_writable(TcpLink& link, std::vector<std::byte>& out) {
  const PeerId peer = link.hello.peer;
  if (std::exchange(link.ack_due, false)) {
    const std::uint64_t received = table_.received(peer, link.hello.incarnation, link.member.key);
    append_frame(out, FrameType::Ack, [&](pbd::ByteWriter& writer) { writer.u64(received); });
  }
  table_.take(link.serial(), peer, kWriteBatch, out);
}

void TcpMesh::on_closed(TcpLink& link, const std::string& reason) {
  const PeerId peer = link.hello.peer;
  links_.erase(link.serial());
  table_.detach(link.serial(), peer, reason);
  if (link.attached_at != SteadyTime{}) {
    redial_peer(peer, Clock::now() - link.attached_at > options_.backoff_max);
  }
  // A listener that has another key says nothing.
  const bool silent = link.exchange && !reason.starts_with("peer: ");
  const char* const hint = silent ? " (has it the same session key?)" : "";
  if (link.dial != 0) dial_failed(link.dial, reason + hint);
  if (shutdown_deadline_ && links_.empty()) context_.stop();
}

}  // namespace tandem::net
