// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "cell_wire.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "octets.h"
#include "tandem/pbd/bytes.h"

namespace tandem::nats {

namespace {

constexpr std::uint8_t kPresence = 1;
constexpr std::uint8_t kSummary = 2;
constexpr int kMaxLevel = 5;
constexpr std::int32_t kMaxIndex = 1 << 28;  // 1e7 m in the smallest edges

bool is_position(const pbd::Vec3& value) { return value.allFinite() && value.norm() < 1e7; }

bool is_index(std::int32_t value) { return value > -kMaxIndex && value < kMaxIndex; }

}  // namespace

void encode(const Presence& presence, std::vector<std::byte>& out) {
  pbd::ByteWriter writer(out);
  writer.u8(kPresence);
  writer.i64(presence.sent);
  writer.vec3(presence.position);
  writer.f64(presence.hears);
}

void encode(const Summary& summary, std::vector<std::byte>& out) {
  pbd::ByteWriter writer(out);
  writer.u8(kSummary);
  writer.u8(static_cast<std::uint8_t>(summary.cell.level));
  writer.u32(static_cast<std::uint32_t>(summary.cell.x));
  writer.u32(static_cast<std::uint32_t>(summary.cell.y));
  writer.u32(summary.people);
  writer.u16(static_cast<std::uint16_t>(summary.content.size()));
  writer.bytes(summary.content);
}

std::optional<Presence> decode_presence(std::span<const std::byte> bytes) {
  pbd::ByteReader reader(bytes);
  Presence out;
  const bool right = reader.u8() == kPresence;
  out.sent = reader.i64();
  out.position = reader.vec3();
  out.hears = reader.f64();
  if (!right || reader.failed() || reader.remaining() != 0 || !is_position(out.position) ||
      !(out.hears >= 0.0 && out.hears <= kMaxHears)) {
    return std::nullopt;
  }
  return out;
}

std::optional<Summary> decode_summary(std::span<const std::byte> bytes) {
  pbd::ByteReader reader(bytes);
  Summary out;
  const bool right = reader.u8() == kSummary;
  out.cell.level = reader.u8();
  out.cell.x = static_cast<std::int32_t>(reader.u32());
  out.cell.y = static_cast<std::int32_t>(reader.u32());
  out.people = reader.u32();
  const std::size_t length = reader.u16();
  if (length > kMaxContent) return std::nullopt;
  out.content = reader.bytes(length);
  const auto signature = reader.bytes(out.signature.size());
  if (!right || reader.failed() || reader.remaining() != 0 || out.cell.level < 1 ||
      out.cell.level > kMaxLevel || !is_index(out.cell.x) || !is_index(out.cell.y)) {
    return std::nullopt;
  }
  std::ranges::copy(net::octets(signature), out.signature.begin());
  return out;
}

}  // namespace tandem::nats
