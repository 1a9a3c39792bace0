// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "packet_protection.h"

#include "octets.h"
#include "require.h"
#include "tandem/pbd/bytes.h"

namespace tandem::net {

namespace {

std::size_t longest(bool relay) {
  return relay ? kMaxRelayed + kProtectedOverhead + kRelayHeader : kMaxDatagram;
}

}  // namespace

std::optional<ProtectedHeader> decode_protected_header(std::span<const std::byte> datagram) {
  if (datagram.size() < kProtectedOverhead) return {};
  pbd::ByteReader reader(datagram);
  const std::uint8_t type = reader.u8();
  ProtectedHeader header;
  header.relay = (type & 0xf0) == kRelayType;
  if (!header.relay && (type & 0xf0) != kProtectedType) return {};
  if (datagram.size() > longest(header.relay)) return {};
  header.epoch = type & 0x0f;
  header.receiver = reader.u32();
  header.sequence = reader.u64();
  return header;
}

SealingKey::SealingKey(const crypto::Secret& key, std::int64_t now, const RekeyPolicy& policy,
                       std::uint64_t first_sequence)
    : key_(key), policy_(policy), next_(first_sequence), epoch_start_(now) {
  crypto::initialise();
  require(policy.packets > 0, "RekeyPolicy", "packets", policy.packets, "> 0");
  require(policy.period > 0, "RekeyPolicy", "period", policy.period, "> 0 ns");
  require(first_sequence > 0, "SealingKey", "first_sequence", first_sequence, "> 0");
}

void SealingKey::renew(std::int64_t now) {
  key_ = crypto::next_key(key_);
  ++epoch_;
  sealed_ = 0;
  epoch_start_ = now;
}

void SealingKey::seal(std::span<const std::byte> header, std::span<const std::byte> plain,
                      std::span<std::byte> out) {
  crypto::seal(key_, next_, octets(header), octets(plain), octets(out));
  ++next_;  // 0 after the last one
  ++sealed_;
}

bool PacketSealer::seal(std::span<const std::byte> plain, std::int64_t now,
                        std::vector<std::byte>& datagram, bool relay) {
  if (next_sequence() == 0 || plain.size() > longest(relay) - kProtectedOverhead) return false;
  if (key_.is_worn(now)) key_.renew(now);
  datagram.clear();
  pbd::ByteWriter writer(datagram);
  writer.u8(static_cast<std::uint8_t>((relay ? kRelayType : kProtectedType) | (epoch() & 0x0f)));
  writer.u32(receiver_);
  writer.u64(next_sequence());
  datagram.resize(kProtectedOverhead + plain.size());
  const std::span<std::byte> all(datagram);
  key_.seal(all.first(kProtectedHeader), plain, all.subspan(kProtectedHeader));
  return true;
}

PacketOpener::PacketOpener(const crypto::Secret& key)
    : current_(key), next_(crypto::next_key(key)) {
  crypto::initialise();
}

std::optional<PacketOpener::Opened> PacketOpener::open(std::span<const std::byte> datagram,
                                                       std::vector<std::byte>& buffer) {
  const auto header = decode_protected_header(datagram);
  const unsigned ahead = header ? (header->epoch - static_cast<unsigned>(epoch_)) & 0x0f : 0;
  const bool is_next = ahead == 1;
  const bool is_previous = ahead == 15 && has_previous_;
  if (!header || (ahead != 0 && !is_next && !is_previous)) {
    ++counters_.malformed;
    return {};
  }
  if (!window_.fresh(header->sequence)) {
    ++counters_.replayed;
    return {};
  }
  buffer.reserve(kMaxDatagram);
  buffer.resize(datagram.size() - kProtectedOverhead);
  const crypto::Secret& key = is_next ? next_ : is_previous ? previous_ : current_;
  if (!crypto::open(key, header->sequence, octets(datagram.first(kProtectedHeader)),
                    octets(datagram.subspan(kProtectedHeader)), octets(std::span(buffer)))) {
    ++counters_.forged;
    return {};
  }
  window_.note(header->sequence);
  if (is_next) {
    previous_ = current_;
    has_previous_ = true;
    current_ = next_;
    next_ = crypto::next_key(current_);
    ++epoch_;
    epoch_first_ = header->sequence;
  } else if (has_previous_ && window_.latest() - epoch_first_ >= ReplayWindow::kSize) {
    previous_ = crypto::Secret();  // the window accepts nothing that old
    has_previous_ = false;
  }
  ++counters_.opened;
  return Opened{.sequence = header->sequence, .relay = header->relay, .plain = buffer};
}

}  // namespace tandem::net
