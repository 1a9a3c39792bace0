// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "group_seal.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include "octets.h"
#include "tandem/pbd/bytes.h"

namespace tandem::nats {

namespace crypto = net::crypto;
using consensus::PeerId;
using net::octets;

namespace {

constexpr std::uint8_t kVersion = 2;
constexpr std::string_view kLabel = "tandem cells 2";

crypto::Secret sender_key(const crypto::Secret& session_key, PeerId sender,
                          std::span<const std::uint8_t> salt) {
  std::vector<std::byte> who;
  pbd::ByteWriter writer(who);
  writer.u64(sender);
  writer.bytes(std::as_bytes(salt));
  const auto label = std::as_bytes(std::span(kLabel));
  crypto::Hash hash = crypto::hmac(session_key.bytes(), octets(label), octets(std::span(who)));
  const crypto::Secret out{std::span(std::as_const(hash)).first<crypto::kKeyBytes>()};
  crypto::wipe(hash);
  return out;
}

}  // namespace

struct GroupHeader {
  PeerId sender = 0;
  std::uint64_t incarnation = 0;
  std::array<std::uint8_t, 8> salt{};
  std::int64_t time = 0;
};

namespace {

std::optional<GroupHeader> read_header(std::span<const std::byte> message) {
  if (message.size() < kGroupOverhead) return std::nullopt;
  pbd::ByteReader reader(message);
  const std::uint8_t version = reader.u8();
  GroupHeader out;
  out.sender = reader.u64();
  out.incarnation = reader.u64();
  std::ranges::copy(octets(reader.bytes(8)), out.salt.begin());
  out.time = reader.i64();
  if (version != kVersion || out.sender == 0) return std::nullopt;
  return out;
}

bool open_with(const crypto::Secret& session_key, const GroupHeader& header,
               std::span<const std::byte> message, std::vector<std::byte>& plain) {
  plain.resize(message.size() - kGroupOverhead);
  return crypto::open(sender_key(session_key, header.sender, header.salt),
                      static_cast<std::uint64_t>(header.time), octets(message.first(kGroupHeader)),
                      octets(message.subspan(kGroupHeader)), octets(std::span(plain)));
}

}  // namespace

GroupSealer::GroupSealer(PeerId self, std::uint64_t incarnation, const crypto::Random& random)
    : self_(self), incarnation_(incarnation) {
  random(salt_);
}

void GroupSealer::seal(std::span<const std::byte> plain, const crypto::Secret& session_key,
                       std::int64_t time, std::vector<std::byte>& out) {
  latest_ = std::max(time, latest_ + 1);
  out.clear();
  pbd::ByteWriter writer(out);
  writer.u8(kVersion);
  writer.u64(self_);
  writer.u64(incarnation_);
  writer.bytes(std::as_bytes(std::span(salt_)));
  writer.i64(latest_);
  out.resize(kGroupOverhead + plain.size());
  const std::span whole(out);
  crypto::seal(sender_key(session_key, self_, salt_), static_cast<std::uint64_t>(latest_),
               octets(whole.first(kGroupHeader)), octets(plain),
               octets(whole.subspan(kGroupHeader)));
}

bool GroupSealer::has_sealed(std::span<const std::byte> message) const {
  const auto header = read_header(message);
  return header && header->sender == self_ && header->salt == salt_;
}

std::optional<OpenedRecord> open_group_record(std::span<const std::byte> message,
                                              const crypto::Secret& session_key) {
  const auto header = read_header(message);
  OpenedRecord out;
  if (!header || !open_with(session_key, *header, message, out.plain)) return std::nullopt;
  out.sender = header->sender;
  return out;
}

GroupOpener::Heard GroupOpener::judge(const GroupHeader& header, const Sender* known,
                                      std::int64_t now,
                                      const std::optional<std::uint64_t>& connected) const {
  const bool same_process = known != nullptr && known->incarnation == header.incarnation;
  if (same_process && header.time <= known->latest) return Heard::Refused;
  const std::int64_t there = now + (known != nullptr ? known->ahead : 0);
  const bool late = header.time < there - kMaxAge;
  const bool early = header.time > there + kMaxAge;
  if (connected && *connected == header.incarnation) {
    // The handshake has shown that this process is present, whatever its clock says; the error of
    // its clock follows from its first message, or a less delayed one.
    if (same_process) return late ? Heard::Refused : Heard::Now;
    return !late && header.time <= floor_ ? Heard::Refused : Heard::Now;
  }
  if (late || early || connected) return Heard::Elsewhen;
  if (known == nullptr) return header.time <= floor_ ? Heard::Refused : Heard::Now;
  // Clocks of its processes need not agree: a connection will show which one is present.
  return same_process || header.time > known->most ? Heard::Now : Heard::Elsewhen;
}

void GroupOpener::remember(const GroupHeader& header, bool is_connected, std::int64_t now) {
  if (senders_.size() >= kMaxSenders && !senders_.contains(header.sender)) {
    const auto silent = std::ranges::min_element(
        senders_, {}, [](const auto& entry) { return entry.second.heard; });
    // A dropped sender's messages must not open again.
    floor_ = std::max(floor_, silent->second.most - silent->second.ahead);
    senders_.erase(silent);
  }
  Sender& sender = senders_[header.sender];
  const std::int64_t ahead = header.time - now;
  if (is_connected) {
    // A delayed message underestimates the lead.
    sender.ahead = sender.incarnation == header.incarnation ? std::max(sender.ahead, ahead) : ahead;
  }
  sender.incarnation = header.incarnation;
  sender.latest = header.time;
  sender.most = std::max(sender.most, header.time);
  sender.heard = ++turn_;
}

GroupOpener::Opened GroupOpener::open(std::span<const std::byte> message,
                                      const net::Credentials& credentials, std::int64_t now,
                                      const Connected& connected) {
  ++refused_;  // until it is accepted
  const auto header = read_header(message);
  if (!header) return {};
  const auto at = senders_.find(header->sender);
  const Sender* known = at != senders_.end() ? &at->second : nullptr;
  const auto process = connected(header->sender);
  const Heard heard = judge(*header, known, now, process);
  if (heard == Heard::Refused) return {};
  for (std::size_t i = 0; i < credentials.key_count(); ++i) {
    if (!open_with(credentials.key(i), *header, message, plain_)) continue;
    // A member that has missed a change still has the former key, and so has a revoked one.
    if (heard == Heard::Elsewhen || i > 0) {
      return {.heard = Heard::Elsewhen, .sender = header->sender, .key = i};
    }
    // Stored only now that it is authenticated.
    remember(*header, process.has_value(), now);
    --refused_;
    return {.heard = Heard::Now, .sender = header->sender, .plain = plain_};
  }
  return {};
}

}  // namespace tandem::nats
