// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "ledger_wire.h"

#include <array>
#include <string_view>
#include <utility>

#include "octets.h"
#include "tandem/consensus/update.h"
#include "tandem/pbd/bytes.h"

namespace tandem::nats {

namespace crypto = net::crypto;
using net::octets;

namespace {

constexpr std::uint8_t kRecordVersion = 2;
constexpr std::size_t kSaltBytes = 16;
constexpr std::size_t kRecordHeader = 1 + kSaltBytes;
constexpr std::string_view kRecordLabel = "tandem ledger 1";

crypto::Secret record_key(const crypto::Secret& session_key, std::span<const std::byte> salt) {
  const auto label = std::as_bytes(std::span(kRecordLabel));
  crypto::Hash hash = crypto::hmac(session_key.bytes(), octets(label), octets(salt));
  const crypto::Secret out{std::span(std::as_const(hash)).first<crypto::kKeyBytes>()};
  crypto::wipe(hash);
  return out;
}

/// Additional authenticated data of a record: its header, and its body's id.
std::vector<std::byte> bound_to(std::span<const std::byte> header, const consensus::SharedId& id) {
  std::vector<std::byte> out(header.begin(), header.end());
  pbd::ByteWriter writer(out);
  writer.u64(id.high);
  writer.u64(id.low);
  return out;
}

}  // namespace

void seal_record(const LedgerRecord& record, Token token, const crypto::Secret& session_key,
                 const crypto::Random& random, std::vector<std::byte>& out) {
  std::vector<std::byte> plain;
  pbd::ByteWriter inner(plain);
  inner.u32(static_cast<std::uint32_t>(record.cell.x));
  inner.u32(static_cast<std::uint32_t>(record.cell.y));
  inner.u64(record.keeper);
  inner.vec3(record.pose.position);
  inner.quat(record.pose.orientation);
  inner.vec3(record.twist.linear);
  inner.vec3(record.twist.angular);
  inner.u64(token);
  inner.u64(record.revision);
  std::array<std::uint8_t, kSaltBytes> salt{};
  random(salt);
  out.clear();
  pbd::ByteWriter writer(out);
  writer.u8(kRecordVersion);
  writer.bytes(std::as_bytes(std::span(salt)));
  out.resize(kRecordHeader + plain.size() + crypto::kTagBytes);
  const std::span whole(out);
  const auto header = bound_to(whole.first(kRecordHeader), record.id);
  crypto::seal(record_key(session_key, std::as_bytes(std::span(salt))), 1, octets(header),
               octets(std::span(std::as_const(plain))), octets(whole.subspan(kRecordHeader)));
}

std::optional<StoredRecord> open_record(std::span<const std::byte> bytes,
                                        const consensus::SharedId& id,
                                        const crypto::Secret& session_key) {
  if (bytes.size() < kRecordHeader + crypto::kTagBytes || bytes[0] != std::byte{kRecordVersion}) {
    return std::nullopt;
  }
  const auto header = bound_to(bytes.first(kRecordHeader), id);
  const auto sealed = bytes.subspan(kRecordHeader);
  std::vector<std::byte> plain(sealed.size() - crypto::kTagBytes);
  if (!crypto::open(record_key(session_key, bytes.subspan(1, kSaltBytes)), 1, octets(header),
                    octets(sealed), octets(std::span(plain)))) {
    return std::nullopt;
  }
  pbd::ByteReader reader(plain);
  StoredRecord out;
  out.record.id = id;
  out.record.cell.x = static_cast<std::int32_t>(reader.u32());
  out.record.cell.y = static_cast<std::int32_t>(reader.u32());
  out.record.keeper = reader.u64();
  out.record.pose.position = reader.vec3();
  out.record.pose.orientation = reader.quat();
  out.record.twist.linear = reader.vec3();
  out.record.twist.angular = reader.vec3();
  out.token = reader.u64();
  out.record.revision = reader.u64();
  if (reader.failed() || reader.remaining() != 0 || out.record.revision == 0) return std::nullopt;
  // A lying member's record that no peer would accept as a state.
  const consensus::StateUpdate state{
      .id = id, .pose = out.record.pose, .twist = out.record.twist, .stamp = 1};
  if (!consensus::check(state).ok()) return std::nullopt;
  out.record.pose.orientation.normalize();
  return out;
}

}  // namespace tandem::nats
