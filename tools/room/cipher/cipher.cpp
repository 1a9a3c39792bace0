// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "cipher/cipher.h"

#include <sodium.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace tandem::room {

namespace {

constexpr std::uint8_t kHello = 1;
constexpr std::uint8_t kPacket = 2;
constexpr std::size_t kHelloNonce = crypto_aead_xchacha20poly1305_ietf_NPUBBYTES;
constexpr std::size_t kPacketNonce = crypto_aead_chacha20poly1305_ietf_NPUBBYTES;
constexpr std::size_t kTag = crypto_aead_chacha20poly1305_ietf_ABYTES;
constexpr std::size_t kCounterBytes = 8;
static_assert(kKeyBytes == crypto_aead_chacha20poly1305_ietf_KEYBYTES);
static_assert(kKeyBytes == crypto_aead_xchacha20poly1305_ietf_KEYBYTES);

void append(Bytes& out, std::uint64_t value) {
  for (std::size_t i = 0; i < 8; ++i) out.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
}

void append(Bytes& out, View bytes) { out.insert(out.end(), bytes.begin(), bytes.end()); }

std::uint64_t read(View bytes) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < 8; ++i) value |= static_cast<std::uint64_t>(bytes[i]) << (8 * i);
  return value;
}

std::array<std::uint8_t, kPacketNonce> nonce_of(std::uint64_t counter) {
  std::array<std::uint8_t, kPacketNonce> nonce{};
  for (std::size_t i = 0; i < 8; ++i) nonce[4 + i] = static_cast<std::uint8_t>(counter >> (8 * i));
  return nonce;
}

}  // namespace

Cipher::Cipher(View key, std::string_view room, MemberId self, Random random)
    : room_(room), self_(self), random_(std::move(random)) {
  if (key.size() != kKeyBytes) throw std::invalid_argument("room key must have 32 bytes");
  if (self == 0) throw std::invalid_argument("member id must not be 0");
  std::copy(key.begin(), key.end(), key_.begin());
  random_(life_);
}

Cipher::~Cipher() {
  sodium_memzero(key_.data(), key_.size());
  for (auto& [id, member] : members_) {
    sodium_memzero(member.to.data(), member.to.size());
    sodium_memzero(member.from.data(), member.from.size());
  }
}

Bytes Cipher::context(std::uint8_t kind, MemberId from, MemberId to) const {
  Bytes bytes{kind};
  append(bytes, from);
  append(bytes, to);
  bytes.insert(bytes.end(), room_.begin(), room_.end());
  return bytes;
}

Cipher::Key Cipher::pair_key(MemberId from, const Life& from_life, MemberId to,
                             const Life& to_life) const {
  constexpr std::string_view kLabel = "tandem room 1";
  Bytes text(kLabel.begin(), kLabel.end());
  append(text, from);
  append(text, from_life);
  append(text, to);
  append(text, to_life);
  text.insert(text.end(), room_.begin(), room_.end());
  Key key{};
  crypto_generichash(key.data(), key.size(), text.data(), text.size(), key_.data(), key_.size());
  return key;
}

Bytes Cipher::hello(View profile) const {
  if (profile.size() > kMaxProfileBytes) {
    throw std::invalid_argument("profile must have at most 512 bytes");
  }
  Bytes plain(life_.begin(), life_.end());
  append(plain, profile);
  Bytes out(1 + kHelloNonce + plain.size() + kTag);
  out[0] = kHello;
  random_(std::span(out).subspan(1, kHelloNonce));
  const Bytes with = context(kHello, self_, 0);
  crypto_aead_xchacha20poly1305_ietf_encrypt(out.data() + 1 + kHelloNonce, nullptr, plain.data(),
                                             plain.size(), with.data(), with.size(), nullptr,
                                             out.data() + 1, key_.data());
  return out;
}

Cipher::Kind Cipher::open(MemberId from, View sealed, Bytes& out) {
  out.clear();
  if (sealed.empty() || from == 0 || from == self_) return Kind::Refused;
  if (sealed[0] == kHello) return open_hello(from, sealed.subspan(1), out);
  if (sealed[0] == kPacket) return open_packet(from, sealed.subspan(1), out);
  return Kind::Refused;
}

Cipher::Kind Cipher::open_hello(MemberId from, View sealed, Bytes& out) {
  if (sealed.size() < kHelloNonce + kLifeBytes + kTag ||
      sealed.size() > kHelloNonce + kLifeBytes + kTag + kMaxProfileBytes) {
    return Kind::Refused;
  }
  const View body = sealed.subspan(kHelloNonce);
  Bytes plain(body.size() - kTag);
  const Bytes with = context(kHello, from, 0);
  if (crypto_aead_xchacha20poly1305_ietf_decrypt(plain.data(), nullptr, nullptr, body.data(),
                                                 body.size(), with.data(), with.size(),
                                                 sealed.data(), key_.data()) != 0) {
    return Kind::Refused;
  }
  Life life{};
  std::copy_n(plain.begin(), kLifeBytes, life.begin());
  const auto known = members_.find(from);
  // A known id with another life is refused.
  if (known != members_.end() && known->second.life != life) return Kind::Refused;
  if (known == members_.end() && members_.size() >= kMaxMembers) return Kind::Refused;
  out.assign(plain.begin() + kLifeBytes, plain.end());
  if (known != members_.end()) return Kind::Known;
  Member member;
  member.life = life;
  member.to = pair_key(self_, life_, from, life);
  member.from = pair_key(from, life, self_, life_);
  members_[from] = member;
  return Kind::Hello;
}

bool Cipher::fresh(const Member& member, std::uint64_t counter) {
  if (counter == 0) return false;
  if (counter > member.newest) return true;
  return member.newest - counter < kWindow && !member.seen[counter % kWindow];
}

void Cipher::note(Member& member, std::uint64_t counter) {
  if (counter > member.newest) {
    if (counter - member.newest >= kWindow) {
      member.seen.reset();
    } else {
      for (std::uint64_t k = member.newest + 1; k < counter; ++k) member.seen[k % kWindow] = false;
    }
    member.newest = counter;
  }
  member.seen[counter % kWindow] = true;
}

Cipher::Kind Cipher::open_packet(MemberId from, View sealed, Bytes& out) {
  const auto found = members_.find(from);
  if (found == members_.end() || sealed.size() < kCounterBytes + kTag ||
      sealed.size() > kCounterBytes + kMaxPlainBytes + kTag) {
    return Kind::Refused;
  }
  Member& member = found->second;
  const std::uint64_t counter = read(sealed);
  if (!fresh(member, counter)) return Kind::Refused;
  const View body = sealed.subspan(kCounterBytes);
  out.resize(body.size() - kTag);
  const Bytes with = context(kPacket, from, self_);
  if (crypto_aead_chacha20poly1305_ietf_decrypt(
          out.data(), nullptr, nullptr, body.data(), body.size(), with.data(), with.size(),
          nonce_of(counter).data(), member.from.data()) != 0) {
    out.clear();
    return Kind::Refused;
  }
  note(member, counter);
  return Kind::Packet;
}

bool Cipher::seal(MemberId to, View plain, Bytes& out) {
  const auto found = members_.find(to);
  if (found == members_.end() || plain.size() > kMaxPlainBytes) return false;
  Member& member = found->second;
  ++member.sent;
  out.clear();
  out.push_back(kPacket);
  append(out, member.sent);
  out.resize(out.size() + plain.size() + kTag);
  const Bytes with = context(kPacket, self_, to);
  crypto_aead_chacha20poly1305_ietf_encrypt(out.data() + 1 + kCounterBytes, nullptr, plain.data(),
                                            plain.size(), with.data(), with.size(), nullptr,
                                            nonce_of(member.sent).data(), member.to.data());
  return true;
}

bool Cipher::alive(MemberId id) const {
  const auto found = members_.find(id);
  return found != members_.end() && found->second.newest > 0;
}

}  // namespace tandem::room
