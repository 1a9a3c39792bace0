// SPDX-License-Identifier: MIT
// Copyright (c) 2026 The Tandem authors
#include "tandem/consensus/update.h"

#include <algorithm>

#include "tandem/pbd/bytes.h"
#include "wire/compact_wire.h"

namespace tandem::consensus {
namespace {

using pbd::ByteReader;
using pbd::ByteWriter;
using pbd::Quat;
using pbd::Vec3;

constexpr std::uint8_t kKnownFlags = (1U << kFlags) - 1;

// Layout of one record of each kind.

void write_vec3_f32(ByteWriter& out, const Vec3& v) {
  out.f32(static_cast<float>(v.x()));
  out.f32(static_cast<float>(v.y()));
  out.f32(static_cast<float>(v.z()));
}

Vec3 read_vec3_f32(ByteReader& in) {
  const double x = in.f32();
  const double y = in.f32();
  const double z = in.f32();
  return {x, y, z};
}

double read_fixed(ByteReader& in) { return from_fixed(static_cast<std::int32_t>(in.u32())); }

void write(ByteWriter& out, const StateUpdate& update) {
  write_id(out, update.id);
  out.vec3(update.pose.position);
  write_vec3_f32(out, update.twist.linear);
  const Quat& q = update.pose.orientation;
  for (const double component : {q.w(), q.x(), q.y(), q.z()}) {
    out.u32(static_cast<std::uint32_t>(to_fixed(component)));
  }
  write_vec3_f32(out, update.twist.angular);
  out.f32(update.influence);
  out.i64(update.stamp);
  out.u8(pack(update.flags));
}

CodecResult read(ByteReader& in, StateUpdate& update) {
  update.id = read_id(in);
  update.pose.position = in.vec3();
  update.twist.linear = read_vec3_f32(in);
  Quat& q = update.pose.orientation;
  q.w() = read_fixed(in);
  q.x() = read_fixed(in);
  q.y() = read_fixed(in);
  q.z() = read_fixed(in);
  update.twist.angular = read_vec3_f32(in);
  update.influence = in.f32();
  update.stamp = in.i64();
  const std::uint8_t flags = in.u8();
  if ((flags & ~kKnownFlags) != 0) return fault(PacketFault::BadCode, "flags: must be below 64");
  update.flags = unpack(flags);
  const CodecResult result = check(update);
  if (result.ok()) q.normalize();
  return result;
}

void write(ByteWriter& out, const SpringUpdate& update) {
  out.u32(update.spring);
  out.u32(update.revision);
  out.u8(static_cast<std::uint8_t>(update.event));
  write_id(out, update.body);
  out.vec3(update.attachment_l);
  out.vec3(update.anchor_w);
  out.vec3(update.anchor_velocity);
  out.f64(update.stiffness);
  out.f64(update.damping);
  out.f64(update.max_force);
  out.i64(update.stamp);
}

CodecResult read(ByteReader& in, SpringUpdate& update) {
  update.spring = in.u32();
  update.revision = in.u32();
  update.event = static_cast<SpringEvent>(in.u8());
  update.body = read_id(in);
  update.attachment_l = in.vec3();
  update.anchor_w = in.vec3();
  update.anchor_velocity = in.vec3();
  update.stiffness = in.f64();
  update.damping = in.f64();
  update.max_force = in.f64();
  update.stamp = in.i64();
  return check(update);
}

void write(ByteWriter& out, const Leave& leave) { out.i64(leave.stamp); }

CodecResult read(ByteReader& in, Leave& leave) {
  leave.stamp = in.i64();
  return check(leave);
}

void write(ByteWriter& out, const OwnershipUpdate& update) {
  write_id(out, update.body);
  out.u64(update.to);
  out.u8(static_cast<std::uint8_t>(update.event));
  out.i64(update.stamp);
}

CodecResult read(ByteReader& in, OwnershipUpdate& update) {
  update.body = read_id(in);
  update.to = in.u64();
  update.event = static_cast<OwnershipEvent>(in.u8());
  update.stamp = in.i64();
  return check(update);
}

// Absent fields are zeros, so that all records have one length.
constexpr std::uint8_t kSaysPose = 1;
constexpr std::uint8_t kSaysTwist = 2;

void write(ByteWriter& out, const ActUpdate& act) {
  out.u32(act.number);
  write_id(out, act.body);
  out.u64(act.name);
  const unsigned says = (act.pose ? kSaysPose : 0U) | (act.twist ? kSaysTwist : 0U);
  out.u8(static_cast<std::uint8_t>(says));
  out.vec3(act.impulse);
  out.vec3(act.angular_impulse);
  const pbd::Pose pose = act.pose.value_or(pbd::Pose{});
  out.vec3(pose.position);
  const Quat& q = pose.orientation;
  for (const double component : {q.w(), q.x(), q.y(), q.z()}) {
    out.u32(static_cast<std::uint32_t>(act.pose ? to_fixed(component) : 0));
  }
  const pbd::Twist twist = act.twist.value_or(pbd::Twist{});
  out.vec3(twist.linear);
  out.vec3(twist.angular);
  out.i64(act.stamp);
}

CodecResult read(ByteReader& in, ActUpdate& act) {
  act.number = in.u32();
  act.body = read_id(in);
  act.name = in.u64();
  const std::uint8_t says = in.u8();
  if ((says & ~(kSaysPose | kSaysTwist)) != 0) {
    return fault(PacketFault::BadCode, "act: bits of what it says must be below 4");
  }
  act.impulse = in.vec3();
  act.angular_impulse = in.vec3();
  pbd::Pose pose;
  pose.position = in.vec3();
  pose.orientation.w() = read_fixed(in);
  pose.orientation.x() = read_fixed(in);
  pose.orientation.y() = read_fixed(in);
  pose.orientation.z() = read_fixed(in);
  const Vec3 linear = in.vec3();
  const Vec3 angular = in.vec3();
  if ((says & kSaysPose) != 0) act.pose = pose;
  if ((says & kSaysTwist) != 0) act.twist = pbd::Twist{linear, angular};
  act.stamp = in.i64();
  const CodecResult result = check(act);
  if (result.ok() && act.pose) act.pose->orientation.normalize();
  return result;
}

void write(ByteWriter& out, const ActReceipt& receipt) {
  out.u64(receipt.actor);
  out.u32(receipt.number);
  write_id(out, receipt.body);
  out.u64(receipt.name);
  out.i64(receipt.stamp);
}

CodecResult read(ByteReader& in, ActReceipt& receipt) {
  receipt.actor = in.u64();
  receipt.number = in.u32();
  receipt.body = read_id(in);
  receipt.name = in.u64();
  receipt.stamp = in.i64();
  return check(receipt);
}

CodecResult read(ByteReader& in, IndicesWanted& wanted) {
  wanted.table = in.u32();
  return {};
}

CodecResult read(ByteReader& in, Alive& alive) {
  alive.stamp = in.i64();
  return check(alive);
}

template <class Record>
std::size_t encode_all(std::span<const Record> records, MessageKind kind,
                       std::vector<std::byte>& out) {
  ByteWriter writer(out);
  std::size_t appended = 0;
  std::size_t next = 0;
  while (next < records.size()) {
    const std::size_t start = out.size();
    write_header(out, kind, 0);
    std::size_t count = 0;
    for (; next < records.size() && count < kMaxRecords; ++next) {
      if (!check(records[next]).ok()) continue;
      write(writer, records[next]);
      ++count;
    }
    if (count == 0) out.resize(start);
    if (count > 0) put_u16(out, start + kHeaderBytes - 2, count);
    appended += count;
  }
  return appended;
}

template <class Record>
CodecResult decode_records(ByteReader& in, std::size_t count, std::size_t record_bytes,
                           std::size_t packet_bytes, std::vector<Record>& out) {
  if (in.remaining() < count * record_bytes) {
    return fault(PacketFault::BadLength, "message: must hold all its records");
  }
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t offset = packet_bytes - in.remaining();
    CodecResult result = read(in, out.emplace_back());
    if (!result.ok()) {
      result.offset = offset;
      return result;
    }
  }
  return {};
}

CodecResult decode_message(ByteReader& in, std::size_t packet_bytes, DecodedPacket& out) {
  if (in.remaining() < kHeaderBytes) {
    return fault(PacketFault::BadLength, "message: must have a whole header");
  }
  if (in.u16() != kPacketMagic) return fault(PacketFault::BadMagic, "magic: must be 0x4354");
  if (in.u8() != kPacketVersion) {
    return fault(PacketFault::BadVersion, "version: must be 2");
  }
  const std::uint8_t kind = in.u8();
  const std::size_t count = in.u16();
  if (count == 0 || count > kMaxRecords) {
    return fault(PacketFault::BadCount, "count: must be 1 to 1024");
  }
  switch (static_cast<MessageKind>(kind)) {
    case MessageKind::States:
      return decode_records(in, count, kStateBytes, packet_bytes, out.states);
    case MessageKind::Springs:
      return decode_records(in, count, kSpringBytes, packet_bytes, out.springs);
    case MessageKind::Leave:
      return decode_records(in, count, kLeaveBytes, packet_bytes, out.leaves);
    case MessageKind::Ownership:
      return decode_records(in, count, kOwnershipBytes, packet_bytes, out.ownership);
    case MessageKind::CompactStates:
      return decode_compact(in, count, out.compact);
    case MessageKind::Indices:
      return decode_indices(in, count, out.assignments);
    case MessageKind::Anchors:
      return decode_anchors(in, count, out.anchors);
    case MessageKind::IndicesWanted:
      return decode_records(in, count, kIndicesWantedBytes, packet_bytes, out.indices_wanted);
    case MessageKind::Alive:
      return decode_records(in, count, kAliveBytes, packet_bytes, out.alive);
    case MessageKind::Acts:
      return decode_records(in, count, kActBytes, packet_bytes, out.acts);
    case MessageKind::ActReceipts:
      return decode_records(in, count, kActReceiptBytes, packet_bytes, out.receipts);
  }
  return fault(PacketFault::UnknownKind, "kind: must be 1 to 11");
}

}  // namespace

void DecodedPacket::clear() {
  states.clear();
  springs.clear();
  leaves.clear();
  ownership.clear();
  compact.clear();
  assignments.clear();
  indices_wanted.clear();
  alive.clear();
  anchors.clear();
  acts.clear();
  receipts.clear();
}

std::string CodecResult::reason() const {
  if (ok()) return {};
  return "byte " + std::to_string(offset) + ": " + detail;
}

void put_u16(std::vector<std::byte>& out, std::size_t at, std::size_t value) {
  out[at] = static_cast<std::byte>(value & 0xff);
  out[at + 1] = static_cast<std::byte>(value >> 8 & 0xff);
}

void write_header(std::vector<std::byte>& out, MessageKind kind, std::size_t count) {
  ByteWriter writer(out);
  writer.u16(kPacketMagic);
  writer.u8(kPacketVersion);
  writer.u8(static_cast<std::uint8_t>(kind));
  writer.u16(static_cast<std::uint16_t>(count));
}

std::size_t encode(std::span<const StateUpdate> updates, std::vector<std::byte>& out) {
  return encode_all(updates, MessageKind::States, out);
}

std::size_t encode(std::span<const SpringUpdate> updates, std::vector<std::byte>& out) {
  return encode_all(updates, MessageKind::Springs, out);
}

std::size_t encode(const Leave& leave, std::vector<std::byte>& out) {
  return encode_all(std::span<const Leave>(&leave, 1), MessageKind::Leave, out);
}

std::size_t encode(std::span<const OwnershipUpdate> updates, std::vector<std::byte>& out) {
  return encode_all(updates, MessageKind::Ownership, out);
}

std::size_t encode(std::span<const ActUpdate> acts, std::vector<std::byte>& out) {
  return encode_all(acts, MessageKind::Acts, out);
}

std::size_t encode(std::span<const ActReceipt> receipts, std::vector<std::byte>& out) {
  return encode_all(receipts, MessageKind::ActReceipts, out);
}

CodecResult decode(std::span<const std::byte> packet, DecodedPacket& out) {
  out.clear();
  if (packet.size() > kMaxPacketBytes) {
    return fault(PacketFault::TooLong, "packet: must have at most 61440 bytes");
  }
  if (packet.empty()) return fault(PacketFault::BadLength, "packet: must not be empty");
  ByteReader in(packet);
  while (in.remaining() > 0) {
    const std::size_t offset = packet.size() - in.remaining();
    CodecResult result = decode_message(in, packet.size(), out);
    if (!result.ok()) {
      result.offset = std::max(result.offset, offset);
      out.clear();
      return result;
    }
  }
  return {};
}

}  // namespace tandem::consensus
