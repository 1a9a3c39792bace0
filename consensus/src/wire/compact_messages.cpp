// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
//
// Messages beside compact states: anchors, indices, Alive.
#include <algorithm>
#include <cmath>
#include <limits>

#include "tandem/consensus/compact.h"
#include "wire/compact_wire.h"

namespace tandem::consensus {
namespace {

using pbd::ByteReader;
using pbd::ByteWriter;

constexpr std::size_t kAnchorBytes = 4 + 2 + 3 * 4 + 3 * 2;
constexpr SessionTime kStampUnit = 1 << 14;  // ns
constexpr SessionTime kMaxDelay = 0xffff;    // units
constexpr double kMaxAnchor = 32767.0;       // m
constexpr double kMaxAnchorSpeed = 127.0;    // m/s

/// Whether an anchor can be encoded in a message of that stamp.
bool is_near(const SpringUpdate& spring, SessionTime newest) {
  return check(spring).ok() && spring.anchor_w.cwiseAbs().maxCoeff() < kMaxAnchor &&
         spring.anchor_velocity.cwiseAbs().maxCoeff() < kMaxAnchorSpeed &&
         newest - spring.stamp < kStampUnit * kMaxDelay;
}

}  // namespace

std::size_t encode_anchors(std::span<const SpringUpdate> springs, std::size_t max_bytes,
                           std::vector<SpringUpdate>& others, std::vector<std::byte>& out) {
  const std::size_t start = out.size();
  SessionTime newest = std::numeric_limits<SessionTime>::min();
  for (const SpringUpdate& spring : springs) {
    if (check(spring).ok()) newest = std::max(newest, spring.stamp);
  }
  write_header(out, MessageKind::Anchors, 0);
  ByteWriter bytes(out);
  bytes.i64(newest);
  std::size_t count = 0;
  std::size_t done = 0;
  for (; done < springs.size() && count < kMaxRecords; ++done) {
    const SpringUpdate& spring = springs[done];
    if (!is_near(spring, newest)) {
      others.push_back(spring);
      continue;
    }
    if (out.size() + kAnchorBytes > max_bytes) break;
    bytes.u32(spring.spring);
    bytes.u16(static_cast<std::uint16_t>((newest - spring.stamp + kStampUnit / 2) / kStampUnit));
    for (int k = 0; k < 3; ++k) {
      const auto whole = std::lround(spring.anchor_w[k] / kAnchorQuantum);
      bytes.u32(static_cast<std::uint32_t>(whole));
    }
    for (int k = 0; k < 3; ++k) {
      const auto whole = std::lround(spring.anchor_velocity[k] / kAnchorSpeedQuantum);
      bytes.u16(static_cast<std::uint16_t>(whole));
    }
    ++count;
  }
  if (count == 0) out.resize(start);
  if (count > 0) put_u16(out, start + kHeaderBytes - 2, count);
  return done;
}

CodecResult decode_anchors(ByteReader& in, std::size_t count, std::vector<AnchorUpdate>& out) {
  const SessionTime newest = in.i64();
  if (in.failed() || in.remaining() < count * kAnchorBytes) {
    return fault(PacketFault::BadLength, "message: must hold all its records");
  }
  if (CodecResult result = check(Alive{newest}); !result.ok()) return result;
  for (std::size_t i = 0; i < count; ++i) {
    AnchorUpdate& anchor = out.emplace_back();
    anchor.spring = in.u32();
    anchor.stamp = newest - kStampUnit * in.u16();
    for (int k = 0; k < 3; ++k) {
      anchor.anchor_w[k] = kAnchorQuantum * static_cast<std::int32_t>(in.u32());
    }
    for (int k = 0; k < 3; ++k) {
      anchor.anchor_velocity[k] = kAnchorSpeedQuantum * static_cast<std::int16_t>(in.u16());
    }
    if (CodecResult result = check_anchor(anchor); !result.ok()) return result;
  }
  return {};
}

void encode_indices(std::uint32_t table, std::uint16_t first, std::span<const SharedId> ids,
                    std::vector<std::byte>& out) {
  write_header(out, MessageKind::Indices, ids.size());
  ByteWriter bytes(out);
  bytes.u32(table);
  bytes.u16(first);
  for (const SharedId& id : ids) write_id(bytes, id);
}

void encode(const IndicesWanted& wanted, std::vector<std::byte>& out) {
  write_header(out, MessageKind::IndicesWanted, 1);
  ByteWriter(out).u32(wanted.table);
}

void encode(const Alive& alive, std::vector<std::byte>& out) {
  if (!check(alive).ok()) return;
  write_header(out, MessageKind::Alive, 1);
  ByteWriter(out).i64(alive.stamp);
}

CodecResult decode_indices(ByteReader& in, std::size_t count, std::vector<IndexAssignment>& out) {
  const std::uint32_t table = in.u32();
  const std::size_t first = in.u16();
  if (in.failed() || in.remaining() < count * kIdBytes) {
    return fault(PacketFault::BadLength, "message: must hold all its records");
  }
  if (first + count > 0x10000) return fault(PacketFault::BadId, "index: must be below 65536");
  for (std::size_t i = 0; i < count; ++i) {
    IndexAssignment& name = out.emplace_back();
    name = {table, static_cast<std::uint16_t>(first + i), read_id(in)};
    if (!name.id.valid()) return fault(PacketFault::BadId, "id: must not be all zeros");
  }
  return {};
}

}  // namespace tandem::consensus
