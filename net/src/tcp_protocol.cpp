// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// TcpMesh: meaning of frames. All bytes are untrusted.
#include <algorithm>
#include <asio/post.hpp>
#include <utility>

#include "loopback.h"
#include "tcp_mesh.h"

namespace tandem::net {

using consensus::Delivery;

namespace {

constexpr std::size_t kWriteBatch = 64 * 1024;  // bytes gathered for one write

PeerAddress peer_address_of(const TcpLink& link) {
  return {.peer = link.hello.peer, .ip = to_bytes(link.remote), .port = link.hello.listen_port};
}

}  // namespace

void TcpMesh::on_frame(TcpLink& link, const FrameBuffer::Frame& frame) {
  const PeerId peer = link.hello.peer;
  if (frame.type == FrameType::Goodbye) {
    const std::string reason = "peer: " + decode_reason(frame.payload);
    if (link.phase != TcpLink::Phase::Attached && peer != 0) {
      table_.note_failure(peer, reason, false);
    }
    return link.close(reason);
  }
  if (link.phase == TcpLink::Phase::Attached) return on_peer_frame(link, frame);
  if (const auto attached = handshake_.on_frame(link, frame)) on_attached(link, *attached);
}

void TcpMesh::on_attached(TcpLink& link, const PeerTable::AttachResult& result) {
  if (TcpLink* other = find_link(result.replaced_link)) {
    other->leave(result.reason, Clock::now() + kLinger);
  }
  dialler_.learn(link.dial, link.hello.peer,
                 {plain(link.remote).to_string(), link.hello.listen_port});
  introduce(link);
  send_group_change(link);
  dialler_.publish();
  link.kick();
}

/// Announces a newcomer to the others, and the others to it.
void TcpMesh::introduce(TcpLink& newcomer) {
  const auto send = [](TcpLink& link, std::span<const PeerAddress> addresses) {
    link.send(FrameType::Addresses, [&](pbd::ByteWriter& writer) { encode(writer, addresses); });
  };
  const PeerAddress own = peer_address_of(newcomer);
  std::vector<PeerAddress> others;
  for (const auto& link : snapshot()) {
    if (link.get() == &newcomer || link->phase != TcpLink::Phase::Attached) continue;
    if (link->hello.listen_port != 0) others.push_back(peer_address_of(*link));
    if (own.port != 0) send(*link, std::span(&own, 1));
  }
  for (std::size_t at = 0; at < others.size(); at += kMaxAddresses) {
    send(newcomer, std::span(others).subspan(at, std::min(kMaxAddresses, others.size() - at)));
  }
}

void TcpMesh::on_malformed(TcpLink& link, const std::string& reason) {
  if (link.phase != TcpLink::Phase::Attached) return handshake_.on_malformed(link, reason);
  const SteadyTime now = Clock::now();
  table_.reject(link.serial(), link.hello.peer, reason, now);
  link.leave("dropped: " + reason, now + kLinger);
}

/// Not the peer's fault: it is not held against it, and both set up a new connection.
void TcpMesh::on_forged(TcpLink& link, const std::string& reason) {
  report_.count(&StrangerStatus::forged, reason);
  if (link.phase != TcpLink::Phase::Attached) return link.close(reason);
  table_.detach(link.serial(), link.hello.peer, "connection lost: " + reason);
  link.leave("connection lost: " + reason, Clock::now() + kLinger);
}

void TcpMesh::on_peer_frame(TcpLink& link, const FrameBuffer::Frame& frame) {
  const PeerId peer = link.hello.peer;
  if (frame.type != FrameType::Newest && frame.type != FrameType::Reliable) {
    table_.charge(link.serial(), peer, Clock::now());
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
      // Verified by everybody, so that nobody forwards an unsigned change.
      if (security_ && take_group_change(frame.payload) != Credentials::Changed::Forged) return;
      return on_malformed(link, "group change that the organiser has not signed");
    case FrameType::Addresses:
      if (const auto addresses = decode_addresses(frame.payload)) {
        return dialler_.hear(*addresses, plain(link.remote));
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
  if (bytes.size() > options_.max_message_bytes) {
    return on_malformed(link, "payload of " + std::to_string(bytes.size()) + " bytes, at most " +
                                  std::to_string(options_.max_message_bytes));
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
  if (link.times.attached != SteadyTime{}) {
    dialler_.redial(peer, Clock::now() - link.times.attached > options_.backoff_max);
  }
  // A listener with another key does not answer.
  const bool silent = link.keying.exchange && !reason.starts_with("peer: ");
  const char* const hint = silent ? " (has it the same session key?)" : "";
  if (link.dial != 0) dialler_.on_failure(link.dial, reason + hint);
  if (shutdown_deadline_ && links_.empty()) context_.stop();
}

// ---- who is no member any more, and a group key that changes while a session goes on ----

void TcpMesh::change_group(std::vector<std::byte> signed_change) {
  asio::post(context_, [this, change = std::move(signed_change)] {
    if (security_) take_group_change(change);
  });
}

Credentials::Changed TcpMesh::take_group_change(std::span<const std::byte> change) {
  const auto changed = security_->change_group(change);
  if (changed != Credentials::Changed::Yes) return changed;
  group_ = security_->credentials().group;
  expel();
  for (const auto& link : snapshot()) {
    if (link->phase == TcpLink::Phase::Attached) send_group_change(*link);
  }
  return changed;
}

void TcpMesh::send_group_change(TcpLink& link) {
  if (!security_ || security_->credentials().group_change.empty()) return;
  link.send(FrameType::GroupChange,
            [&](pbd::ByteWriter& writer) { writer.bytes(security_->credentials().group_change); });
}

void TcpMesh::expel() {
  for (const auto& link : snapshot()) {
    if (link->phase != TcpLink::Phase::Attached && link->phase != TcpLink::Phase::Welcoming) {
      continue;
    }
    const std::string reason = security_->expelled(link->member);
    if (reason.empty()) continue;
    table_.expel(link->serial(), link->hello.peer, reason);
    link->leave(reason, Clock::now() + kLinger);
  }
}

}  // namespace tandem::net
