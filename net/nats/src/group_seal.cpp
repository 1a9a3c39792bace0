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

constexpr std::uint8_t kVersion = 1;
constexpr std::string_view kLabel = "tandem cells 1";

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

GroupSealer::GroupSealer(const crypto::Secret& session_key, PeerId self,
                         const crypto::Random& random)
    : self_(self) {
  random(salt_);
  key_ = sender_key(session_key, self, salt_);
}

void GroupSealer::seal(std::span<const std::byte> plain, std::vector<std::byte>& out) {
  out.clear();
  pbd::ByteWriter writer(out);
  writer.u8(kVersion);
  writer.u64(self_);
  writer.bytes(std::as_bytes(std::span(salt_)));
  writer.u64(next_);
  out.resize(kGroupOverhead + plain.size());
  const std::span whole(out);
  crypto::seal(key_, next_++, octets(whole.first(kGroupHeader)), octets(plain),
               octets(whole.subspan(kGroupHeader)));
}

bool GroupOpener::open_with(const crypto::Secret& key, std::span<const std::byte> message,
                            std::uint64_t number) {
  plain_.resize(message.size() - kGroupOverhead);
  return crypto::open(key, number, octets(message.first(kGroupHeader)),
                      octets(message.subspan(kGroupHeader)), octets(std::span(plain_)));
}

GroupOpener::Sender& GroupOpener::remember(PeerId sender) {
  if (senders_.size() >= kMaxSenders && !senders_.contains(sender)) {
    senders_.erase(std::ranges::min_element(senders_, {},
                                            [](const auto& entry) { return entry.second.heard; }));
  }
  return senders_[sender];
}

std::optional<GroupOpener::Opened> GroupOpener::open(std::span<const std::byte> message,
                                                     const net::Credentials& credentials) {
  ++refused_;  // until it is known to be good
  if (message.size() < kGroupOverhead) return std::nullopt;
  pbd::ByteReader reader(message);
  const std::uint8_t version = reader.u8();
  const PeerId sender = reader.u64();
  const auto salted = reader.bytes(8);
  const std::uint64_t number = reader.u64();
  if (version != kVersion || sender == 0) return std::nullopt;
  std::array<std::uint8_t, 8> salt{};
  std::ranges::copy(octets(salted), salt.begin());

  const auto known = senders_.find(sender);
  const bool same = known != senders_.end() && known->second.salt == salt;
  if (same && number <= known->second.latest) return std::nullopt;
  std::optional<crypto::Secret> key;
  if (same && known->second.group == credentials.group) {
    if (open_with(known->second.key, message, number)) key = known->second.key;
  } else {
    for (std::size_t i = 0; i < credentials.key_count() && !key; ++i) {
      const crypto::Secret made = sender_key(credentials.key(i), sender, salt);
      if (open_with(made, message, number)) key = made;
    }
  }
  if (!key) return std::nullopt;
  // Only now is anything remembered: it is a member's.
  remember(sender) = {
      .salt = salt, .key = *key, .group = credentials.group, .latest = number, .heard = ++turn_};
  --refused_;
  return Opened{sender, plain_};
}

}  // namespace tandem::nats
